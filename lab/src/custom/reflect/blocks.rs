//! Finds the place of each number in a uniform block.

use super::Component;
use super::code::{SpirvCode, decoration, op};

/// The most bytes of a uniform block.
const MAX_BYTES: u32 = 1 << 16;

/// The most fields of a block; each element of an array of structs counts.
const MAX_FIELDS: usize = 1 << 12;

/// A uniform or push-constant block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BlockLayout {
    /// The fields in their order.
    pub fields: Vec<BlockField>,
    /// Size in bytes.
    pub size: u32,
}

/// A field of numbers in a block: a scalar, a vector, a matrix, or an array of these.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BlockField {
    /// The field's name; within structs and arrays of structs, a name such as `lights[1].colour`.
    pub name: String,
    /// The type of its numbers.
    pub component: Component,
    /// Number of elements of an array, of columns of a matrix, and of rows of a matrix or numbers of a vector; 1 where
    /// there is no array, matrix or vector.
    pub shape: [u32; 3],
    /// Offset of each number in bytes: element by element, and column by column.
    pub places: Vec<u32>,
    /// True if a function of the shader may read the field.
    pub is_read: bool,
}

impl BlockLayout {
    /// Reads the layout of a block from its type; `id` is that of the type, and `variable` that of the block's
    /// variable.
    ///
    /// # Errors
    /// A sentence on a block that is too large, or has something other than numbers.
    pub(super) fn from_type(code: &SpirvCode, id: u32, variable: u32) -> Result<Self, String> {
        let mut block = Self { fields: Vec::new(), size: 0 };
        let reached = code.reached_members(variable);
        for member in 0..code.member_types(id).len() as u32 {
            let first = block.fields.len();
            block.add_member(code, (id, member), 0, "")?;
            let is_read = reached.as_ref().is_none_or(|reached| reached.contains(&member));
            block.fields[first..].iter_mut().for_each(|field| field.is_read = is_read);
        }
        let end = block.fields.iter().flat_map(|f| &f.places).max().map_or(0, |last| last + 4);
        block.size = end.next_multiple_of(16);
        Ok(block)
    }

    /// Returns the least size in bytes of a storage block of the type `id`: up to its last member that has a size.
    pub(super) fn least_bytes(code: &SpirvCode, id: u32) -> u32 {
        let end_of_member = |(member, ty): (u32, &u32)| {
            let offset = code.member_decoration(id, member, decoration::OFFSET).unwrap_or(0);
            let definition = code.definition(*ty);
            let count = definition.filter(|d| d.opcode == op::TYPE_ARRAY).and_then(|d| code.constant(d.word(2)));
            match (count, code.decoration(*ty, decoration::ARRAY_STRIDE)) {
                (Some(count), Some(stride)) => offset.saturating_add(stride.saturating_mul(count)),
                _ => offset.saturating_add(code.plain_size(*ty).unwrap_or(0)),
            }
        };
        (0..).zip(code.member_types(id)).map(end_of_member).max().unwrap_or(0)
    }

    /// Adds the member with the number `member` of the struct type `id`. The struct begins at the byte `start` of the
    /// block, and `prefix` stands before the member's name.
    fn add_member(
        &mut self,
        code: &SpirvCode,
        (id, member): (u32, u32),
        start: u32,
        prefix: &str,
    ) -> Result<(), String> {
        let decorated = |decoration: u32| code.member_decoration(id, member, decoration);
        let own_name = code.member_name(id, member);
        // If the module has no names, the number of the member takes the place of its name.
        let name = if own_name.is_empty() { format!("{prefix}{member}") } else { format!("{prefix}{own_name}") };
        let offset = start.saturating_add(decorated(decoration::OFFSET).unwrap_or(0));
        let matrix = (decorated(decoration::MATRIX_STRIDE).unwrap_or(16), decorated(decoration::ROW_MAJOR).is_some());
        let ty = code.member_types(id)[member as usize];
        self.add_value(code, ty, (offset, matrix), name)
    }

    /// Adds the fields of a value of type `id` at the byte `offset`, with every element of its arrays. `matrix` has the
    /// stride of its matrices in bytes, and whether the matrices are stored row by row.
    fn add_value(
        &mut self,
        code: &SpirvCode,
        id: u32,
        (offset, matrix): (u32, (u32, bool)),
        name: String,
    ) -> Result<(), String> {
        // The offsets of all elements; each loop goes from an array to its elements, which may be arrays again.
        let mut elements = vec![offset];
        let mut ty = id;
        while let Some(array) = code.definition(ty).filter(|d| d.opcode == op::TYPE_ARRAY) {
            let count = code.constant(array.word(2)).unwrap_or(0);
            let stride = code.decoration(ty, decoration::ARRAY_STRIDE).unwrap_or(16);
            let last = elements.last().copied().unwrap_or(0);
            // Damaged code may put all elements at one place, so their number is bounded as well as their size.
            let total = (elements.len() as u64).saturating_mul(u64::from(count));
            if last.saturating_add(stride.saturating_mul(count)) > MAX_BYTES || total > u64::from(MAX_BYTES / 4) {
                return Err(too_large(&name));
            }
            elements = elements.iter().flat_map(|start| (0..count).map(move |n| start + n * stride)).collect();
            ty = array.word(1);
        }
        if code.member_types(ty).is_empty() {
            let field =
                number_field(code, ty, &elements, matrix).ok_or_else(|| format!("has a field {name} of no number"))?;
            if field.places.iter().any(|place| *place > MAX_BYTES - 4) {
                return Err(too_large(&name));
            }
            if self.fields.len() >= MAX_FIELDS {
                return Err(format!("has a block of more than {MAX_FIELDS} fields"));
            }
            self.fields.push(BlockField { name, ..field });
            return Ok(());
        }
        for (element, start) in elements.iter().enumerate() {
            let prefix = if ty == id { format!("{name}.") } else { format!("{name}[{element}].") };
            for member in 0..code.member_types(ty).len() as u32 {
                self.add_member(code, (ty, member), *start, &prefix)?;
            }
        }
        Ok(())
    }
}

/// Makes the sentence about a field that lies too far from the beginning of its block.
fn too_large(name: &str) -> String {
    format!("has a block in which {name} lies beyond the {MAX_BYTES} bytes that uniform blocks may have")
}

/// Makes a field, still without a name, of numbers of the type `ty`, whose elements begin at the bytes `elements`. The
/// matrices in it have a stride in bytes, and may be stored row by row. `None` for a type that has no numbers.
fn number_field(
    code: &SpirvCode,
    ty: u32,
    elements: &[u32],
    (stride, is_row_major): (u32, bool),
) -> Option<BlockField> {
    let definition = code.definition(ty)?;
    let (columns, vector) = match definition.opcode {
        op::TYPE_MATRIX => (definition.word(2), definition.word(1)),
        _ => (1, ty),
    };
    let (component, rows) = code.number_type(vector)?;
    if columns > 4 || rows > 4 {
        return None;
    }
    // The bytes from a column to the next column, and from a row to the next row.
    let (to_column, to_row) = if is_row_major && columns > 1 { (4, stride) } else { (stride, 4) };
    let element_places = move |start: u32| {
        (0..columns).flat_map(move |c| {
            (0..rows).map(move |r| {
                start.saturating_add(c.saturating_mul(to_column)).saturating_add(r.saturating_mul(to_row))
            })
        })
    };
    let places = elements.iter().flat_map(|start| element_places(*start)).collect();
    Some(BlockField {
        name: String::new(),
        component,
        shape: [elements.len() as u32, columns, rows],
        places,
        is_read: true,
    })
}
