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
    pub fields: Vec<BlockField>,
    /// Size in bytes.
    pub size: u32,
}

/// A field of numbers in a block: a scalar, a vector, a matrix, or an array of these.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BlockField {
    /// The field's name; within structs and arrays of structs, a name such as `lights[1].colour`.
    pub name: String,
    pub component: Component,
    /// Number of elements of an array, of columns of a matrix, and of rows or numbers of a vector.
    pub shape: [u32; 3],
    /// Offset of each number in bytes: element by element, and column by column.
    pub places: Vec<u32>,
    /// True if a function of the shader may read the field.
    pub is_read: bool,
}

impl BlockLayout {
    /// The layout of a block, from its type; `variable` is the variable of this type.
    ///
    /// # Errors
    /// A sentence on a block that is too large, or has something else than numbers.
    pub(super) fn from_type(code: &SpirvCode, id: u32, variable: u32) -> Result<Self, String> {
        let mut block = Self { fields: Vec::new(), size: 0 };
        let reached = code.reached_members(variable);
        for member in 0..code.members(id).len() as u32 {
            let first = block.fields.len();
            block.add_member(code, (id, member), 0, "")?;
            let is_read = reached.as_ref().is_none_or(|reached| reached.contains(&member));
            block.fields[first..].iter_mut().for_each(|field| field.is_read = is_read);
        }
        let end = block.fields.iter().flat_map(|f| &f.places).max().map_or(0, |last| last + 4);
        block.size = end.next_multiple_of(16);
        Ok(block)
    }

    /// The least size of a storage block in bytes: up to its last member that has a size.
    pub(super) fn least_bytes(code: &SpirvCode, id: u32) -> u32 {
        let member = |(m, ty): (u32, &u32)| {
            let offset = code.member_decoration(id, m, decoration::OFFSET).unwrap_or(0);
            let definition = code.definition(*ty);
            let many = definition.filter(|d| d.opcode == op::TYPE_ARRAY).and_then(|d| code.constant(d.word(2)));
            match (many, code.decoration(*ty, decoration::ARRAY_STRIDE)) {
                (Some(many), Some(stride)) => offset.saturating_add(stride.saturating_mul(many)),
                _ => offset.saturating_add(code.plain_size(*ty).unwrap_or(0)),
            }
        };
        (0..).zip(code.members(id)).map(member).max().unwrap_or(0)
    }

    /// Adds a member of a struct. The struct begins at the byte `start` of the block, and `before` stands before the
    /// member's name.
    fn add_member(
        &mut self,
        code: &SpirvCode,
        (id, member): (u32, u32),
        start: u32,
        before: &str,
    ) -> Result<(), String> {
        let value = |what: u32| code.member_decoration(id, member, what);
        let own = code.member_name(id, member);
        // If the module has no names, the number of the member takes the place of its name.
        let name = if own.is_empty() { format!("{before}{member}") } else { format!("{before}{own}") };
        let offset = start.saturating_add(value(decoration::OFFSET).unwrap_or(0));
        let matrix = (value(decoration::MATRIX_STRIDE).unwrap_or(16), value(decoration::ROW_MAJOR).is_some());
        let ty = code.members(id)[member as usize];
        self.add(code, ty, (offset, matrix), name)
    }

    /// Adds the fields of a value of type `id` at the byte `offset`, with every element of its arrays. `matrix` has the
    /// stride of its matrices in bytes, and whether the matrices are stored row by row.
    fn add(
        &mut self,
        code: &SpirvCode,
        id: u32,
        (offset, matrix): (u32, (u32, bool)),
        name: String,
    ) -> Result<(), String> {
        let mut elements = vec![offset];
        let mut ty = id;
        while let Some(array) = code.definition(ty).filter(|d| d.opcode == op::TYPE_ARRAY) {
            let many = code.constant(array.word(2)).unwrap_or(0);
            let stride = code.decoration(ty, decoration::ARRAY_STRIDE).unwrap_or(16);
            let last = elements.last().copied().unwrap_or(0);
            // Damaged code may put all elements at one place, so that their count is bounded, too.
            let count = (elements.len() as u64).saturating_mul(u64::from(many));
            if last.saturating_add(stride.saturating_mul(many)) > MAX_BYTES || count > u64::from(MAX_BYTES / 4) {
                return Err(too_large(&name));
            }
            elements = elements.iter().flat_map(|start| (0..many).map(move |k| start + k * stride)).collect();
            ty = array.word(1);
        }
        if code.members(ty).is_empty() {
            let field =
                numbers(code, ty, &elements, matrix).ok_or_else(|| format!("has a field {name} of no number"))?;
            if field.places.iter().any(|place| *place > MAX_BYTES - 4) {
                return Err(too_large(&name));
            }
            if self.fields.len() >= MAX_FIELDS {
                return Err(format!("has a block of more than {MAX_FIELDS} fields"));
            }
            self.fields.push(BlockField { name, ..field });
            return Ok(());
        }
        for (k, start) in elements.iter().enumerate() {
            let before = if ty == id { format!("{name}.") } else { format!("{name}[{k}].") };
            for member in 0..code.members(ty).len() as u32 {
                self.add_member(code, (ty, member), *start, &before)?;
            }
        }
        Ok(())
    }
}

fn too_large(name: &str) -> String {
    format!("has a block in which {name} lies beyond the {MAX_BYTES} bytes that uniform blocks may have")
}

/// A field of numbers, whose elements begin at the bytes `elements`; `None` for a type of other things than numbers.
fn numbers(code: &SpirvCode, ty: u32, elements: &[u32], (stride, is_row_major): (u32, bool)) -> Option<BlockField> {
    let definition = code.definition(ty)?;
    let (columns, vector) = match definition.opcode {
        op::TYPE_MATRIX => (definition.word(2), definition.word(1)),
        _ => (1, ty),
    };
    let (component, rows) = code.numbers(vector)?;
    if columns > 4 || rows > 4 {
        return None;
    }
    // The bytes from a column to the next column, and from a row to the next row.
    let (along, across) = if is_row_major && columns > 1 { (4, stride) } else { (stride, 4) };
    let within = move |start: u32| {
        (0..columns).flat_map(move |c| {
            (0..rows)
                .map(move |r| start.saturating_add(c.saturating_mul(along)).saturating_add(r.saturating_mul(across)))
        })
    };
    let places = elements.iter().flat_map(|start| within(*start)).collect();
    Some(BlockField {
        name: String::new(),
        component,
        shape: [elements.len() as u32, columns, rows],
        places,
        is_read: true,
    })
}
