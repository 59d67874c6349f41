//! Reads the words of a SPIR-V module into tables of its types, names and decorations.

use super::Component;
use rspirv::spirv::{BuiltIn, ExecutionMode, MAGIC_NUMBER, Op};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Instructions that are read here.
pub(super) mod op {
    use rspirv::spirv::Op;

    pub const NAME: u16 = Op::Name as u16;
    pub const MEMBER_NAME: u16 = Op::MemberName as u16;
    pub const ENTRY_POINT: u16 = Op::EntryPoint as u16;
    pub const EXECUTION_MODE: u16 = Op::ExecutionMode as u16;
    pub const CAPABILITY: u16 = Op::Capability as u16;
    pub const TYPE_VOID: u16 = Op::TypeVoid as u16;
    pub const TYPE_BOOL: u16 = Op::TypeBool as u16;
    pub const TYPE_INT: u16 = Op::TypeInt as u16;
    pub const TYPE_FLOAT: u16 = Op::TypeFloat as u16;
    pub const TYPE_VECTOR: u16 = Op::TypeVector as u16;
    pub const TYPE_MATRIX: u16 = Op::TypeMatrix as u16;
    pub const TYPE_IMAGE: u16 = Op::TypeImage as u16;
    pub const TYPE_SAMPLER: u16 = Op::TypeSampler as u16;
    pub const TYPE_SAMPLED_IMAGE: u16 = Op::TypeSampledImage as u16;
    pub const TYPE_ARRAY: u16 = Op::TypeArray as u16;
    pub const TYPE_RUNTIME_ARRAY: u16 = Op::TypeRuntimeArray as u16;
    pub const TYPE_STRUCT: u16 = Op::TypeStruct as u16;
    pub const TYPE_POINTER: u16 = Op::TypePointer as u16;
    pub const TYPE_PIPE: u16 = Op::TypePipe as u16;
    pub const CONSTANT: u16 = Op::Constant as u16;
    pub const CONSTANT_COMPOSITE: u16 = Op::ConstantComposite as u16;
    pub const SPEC_CONSTANT_TRUE: u16 = Op::SpecConstantTrue as u16;
    pub const SPEC_CONSTANT_FALSE: u16 = Op::SpecConstantFalse as u16;
    pub const SPEC_CONSTANT: u16 = Op::SpecConstant as u16;
    pub const SPEC_CONSTANT_COMPOSITE: u16 = Op::SpecConstantComposite as u16;
    pub const FUNCTION: u16 = Op::Function as u16;
    pub const VARIABLE: u16 = Op::Variable as u16;
    pub const ACCESS_CHAIN: u16 = Op::AccessChain as u16;
    pub const IN_BOUNDS_ACCESS_CHAIN: u16 = Op::InBoundsAccessChain as u16;
    pub const DECORATE: u16 = Op::Decorate as u16;
    pub const MEMBER_DECORATE: u16 = Op::MemberDecorate as u16;
    pub const EXECUTION_MODE_ID: u16 = Op::ExecutionModeId as u16;
}

/// Decorations that are read here.
pub(super) mod decoration {
    use rspirv::spirv::Decoration;

    pub const SPEC_ID: u32 = Decoration::SpecId as u32;
    pub const BUFFER_BLOCK: u32 = Decoration::BufferBlock as u32;
    pub const ROW_MAJOR: u32 = Decoration::RowMajor as u32;
    pub const ARRAY_STRIDE: u32 = Decoration::ArrayStride as u32;
    pub const MATRIX_STRIDE: u32 = Decoration::MatrixStride as u32;
    pub const BUILT_IN: u32 = Decoration::BuiltIn as u32;
    pub const NON_WRITABLE: u32 = Decoration::NonWritable as u32;
    pub const LOCATION: u32 = Decoration::Location as u32;
    pub const BINDING: u32 = Decoration::Binding as u32;
    pub const SET: u32 = Decoration::DescriptorSet as u32;
    pub const OFFSET: u32 = Decoration::Offset as u32;
}

/// The number of words before the first instruction.
const HEADER: usize = 5;

/// An instruction. Its operands are all its words except the first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instruction<'a> {
    pub opcode: u16,
    operands: &'a [u32],
}

impl<'a> Instruction<'a> {
    /// The operand with an index; 0 if there are fewer operands.
    pub fn word(&self, index: usize) -> u32 {
        self.operands.get(index).copied().unwrap_or(0)
    }

    /// The text that begins at the operand with an index, up to its first NUL byte.
    pub fn text(&self, index: usize) -> String {
        let bytes = self.operands.iter().skip(index).flat_map(|w| w.to_le_bytes()).take_while(|b| *b != 0);
        String::from_utf8_lossy(&bytes.collect::<Vec<u8>>()).into_owned()
    }

    /// The operands from an index on; empty if there are fewer.
    fn operands_from(&self, index: usize) -> &'a [u32] {
        self.operands.get(index..).unwrap_or_default()
    }

    /// The operands that may be pointers, for instructions that read, write or hand on a pointer. Other instructions have numbers among
    /// their operands, which may look like ids.
    fn pointer_operands(&self) -> &'a [u32] {
        const CALL: u16 = Op::FunctionCall as u16;
        const TEXEL_POINTER: u16 = Op::ImageTexelPointer as u16;
        const LOAD: u16 = Op::Load as u16;
        const STORE: u16 = Op::Store as u16;
        const COPY_MEMORY: u16 = Op::CopyMemory as u16;
        const COPY_MEMORY_SIZED: u16 = Op::CopyMemorySized as u16;
        const ARRAY_LENGTH: u16 = Op::ArrayLength as u16;
        const COPY_OBJECT: u16 = Op::CopyObject as u16;
        const SELECT: u16 = Op::Select as u16;
        const PHI: u16 = Op::Phi as u16;
        const ATOMICS: std::ops::RangeInclusive<u16> = Op::AtomicLoad as u16..=Op::AtomicXor as u16;
        const LAST_CHAIN: u16 = Op::InBoundsPtrAccessChain as u16;
        match self.opcode {
            STORE | COPY_MEMORY | COPY_MEMORY_SIZED => &self.operands[..self.operands.len().min(2)],
            LOAD | TEXEL_POINTER | ARRAY_LENGTH | COPY_OBJECT => {
                &self.operands_from(2)[..self.operands_from(2).len().min(1)]
            }
            op::ACCESS_CHAIN..=LAST_CHAIN => &self.operands_from(2)[..self.operands_from(2).len().min(1)],
            CALL | SELECT | PHI => self.operands_from(2),
            other if ATOMICS.contains(&other) => self.operands,
            _ => &[],
        }
    }
}

/// A module of SPIR-V, with its instructions and with tables of what they say about each id.
pub(super) struct SpirvCode<'a> {
    words: &'a [u32],
    instructions: Vec<Instruction<'a>>,
    /// Types, constants and variables of the module, by their ids.
    definitions: HashMap<u32, Instruction<'a>>,
    names: HashMap<u32, String>,
    /// Names of the members of structs, by the struct's id and the member's number.
    member_names: HashMap<(u32, u32), String>,
    /// The first operand of each decoration, by the id that it decorates and by the decoration's number.
    decorations: HashMap<(u32, u32), u32>,
    /// The first operand of each decoration of a member, by the struct's id, the member's number and the decoration's
    /// number.
    member_decorations: HashMap<(u32, u32, u32), u32>,
    /// Sizes in bytes of types without a layout, by their ids.
    sizes: HashMap<u32, u32>,
    /// Depths to which types are nested within a type, by its id.
    depths: HashMap<u32, u32>,
    /// Ids of the pointers that functions use.
    used: HashSet<u32>,
}

impl<'a> SpirvCode<'a> {
    /// Reads a module; `None` if the words are not SPIR-V.
    pub fn read(words: &'a [u32]) -> Option<Self> {
        if words.len() < HEADER || words[0] != MAGIC_NUMBER {
            return None;
        }
        let mut code = Self {
            words,
            instructions: Vec::new(),
            definitions: HashMap::new(),
            names: HashMap::new(),
            member_names: HashMap::new(),
            decorations: HashMap::new(),
            member_decorations: HashMap::new(),
            sizes: HashMap::new(),
            depths: HashMap::new(),
            used: HashSet::new(),
        };
        let mut position = HEADER;
        let mut in_function = false;
        while position < words.len() {
            // The first word of an instruction has its number of words in the upper half, and its opcode in the lower
            // half.
            let length = (words[position] >> 16) as usize;
            let operands = words.get(position + 1..position + length.max(1))?;
            let instruction = Instruction { opcode: words[position] as u16, operands };
            if length == 0 {
                return None;
            }
            in_function |= instruction.opcode == op::FUNCTION;
            if in_function {
                code.used.extend(instruction.pointer_operands());
            } else {
                code.add_to_tables(instruction);
            }
            code.instructions.push(instruction);
            position += length;
        }
        Some(code)
    }

    /// Adds an instruction outside of functions to the tables.
    fn add_to_tables(&mut self, i: Instruction<'a>) {
        match i.opcode {
            op::NAME => {
                self.names.insert(i.word(0), i.text(1));
            }
            op::MEMBER_NAME => {
                self.member_names.insert((i.word(0), i.word(1)), i.text(2));
            }
            op::DECORATE => {
                self.decorations.insert((i.word(0), i.word(1)), i.word(2));
            }
            op::MEMBER_DECORATE => {
                self.member_decorations.insert((i.word(0), i.word(1), i.word(2)), i.word(3));
            }
            op::TYPE_VOID..=op::TYPE_PIPE => {
                // Types are taken only if they consist of earlier types, are not nested too deep, and are defined once.
                // Otherwise following a type to its parts might never end.
                let depth = self.depth_of(&i).filter(|_| !self.definitions.contains_key(&i.word(0)));
                if let Some(depth) = depth {
                    self.sizes.extend(self.size_of(&i).map(|size| (i.word(0), size)));
                    self.depths.insert(i.word(0), depth);
                    self.definitions.insert(i.word(0), i);
                }
            }
            // 41 to 52 are the instructions that define constants.
            41..=52 | op::VARIABLE => {
                self.definitions.entry(i.word(1)).or_insert(i);
            }
            _ => {}
        }
    }

    /// Returns how deep types are nested within the type that an instruction defines; `None` if that is too deep, or if
    /// one of the types is not known.
    fn depth_of(&self, i: &Instruction) -> Option<u32> {
        const MOST_DEPTH: u32 = 64;
        let parts = match i.opcode {
            op::TYPE_VECTOR | op::TYPE_MATRIX | op::TYPE_ARRAY | op::TYPE_RUNTIME_ARRAY => i.operands.get(1..2)?,
            op::TYPE_IMAGE | op::TYPE_SAMPLED_IMAGE => i.operands.get(1..2)?,
            op::TYPE_STRUCT => i.operands_from(1),
            _ => &[],
        };
        let deepest = parts.iter().try_fold(0, |deepest, part| Some((*self.depths.get(part)?).max(deepest)))?;
        (deepest < MOST_DEPTH).then_some(deepest + 1)
    }

    /// Returns the size in bytes of the type that an instruction defines, if numbers lie without gaps; `None` for a
    /// type that has no such size, such as an image.
    fn size_of(&self, i: &Instruction) -> Option<u32> {
        let size = |id: u32| self.sizes.get(&id).copied();
        match i.opcode {
            op::TYPE_BOOL => Some(4),
            // The instruction has the number of bits.
            op::TYPE_INT | op::TYPE_FLOAT => Some(i.word(1) / 8),
            op::TYPE_VECTOR | op::TYPE_MATRIX => size(i.word(1))?.checked_mul(i.word(2)),
            op::TYPE_ARRAY => size(i.word(1))?.checked_mul(self.constant(i.word(2))?),
            op::TYPE_STRUCT => i.operands_from(1).iter().try_fold(0_u32, |sum, m| sum.checked_add(size(*m)?)),
            _ => None,
        }
    }

    /// Returns the instructions with an opcode.
    pub fn with_opcode(&self, opcode: u16) -> impl Iterator<Item = Instruction<'a>> + '_ {
        self.instructions.iter().copied().filter(move |i| i.opcode == opcode)
    }

    /// The instruction that defines a type, a constant or a variable of the module.
    pub fn definition(&self, id: u32) -> Option<Instruction<'a>> {
        self.definitions.get(&id).copied()
    }

    /// The name of an id; empty if it has none.
    pub fn name(&self, id: u32) -> &str {
        self.names.get(&id).map_or("", String::as_str)
    }

    /// The name of a struct's member; empty if it has none.
    pub fn member_name(&self, id: u32, member: u32) -> &str {
        self.member_names.get(&(id, member)).map_or("", String::as_str)
    }

    /// The first operand of an id's decoration; `None` if the id is not decorated so.
    pub fn decoration(&self, id: u32, decoration: u32) -> Option<u32> {
        self.decorations.get(&(id, decoration)).copied()
    }

    /// The first operand of a decoration of a struct's member; `None` if the member is not decorated so.
    pub fn member_decoration(&self, id: u32, member: u32, decoration: u32) -> Option<u32> {
        self.member_decorations.get(&(id, member, decoration)).copied()
    }

    /// True if a function reads, writes or hands on the variable of this id.
    pub fn is_used(&self, id: u32) -> bool {
        self.used.contains(&id)
    }

    /// Returns the numbers of a block's members that functions reach; `None` if a function uses the block as a whole.
    /// `variable` is the id of the block's variable.
    pub fn reached_members(&self, variable: u32) -> Option<HashSet<u32>> {
        let chains = |i: &&Instruction| matches!(i.opcode, op::ACCESS_CHAIN | op::IN_BOUNDS_ACCESS_CHAIN);
        let start = self.instructions.iter().position(|i| i.opcode == op::FUNCTION)?;
        let body = &self.instructions[start..];
        // Only access chains name a member, as the constant after the variable.
        let is_used_whole = body.iter().filter(|i| !chains(i)).any(|i| i.pointer_operands().contains(&variable));
        let members = body.iter().filter(chains).filter(|i| i.word(2) == variable);
        let members: Option<HashSet<u32>> = members.map(|i| self.constant(i.word(3))).collect();
        members.filter(|_| !is_used_whole)
    }

    /// The type that a pointer's type points to.
    pub fn pointee(&self, pointer: u32) -> Option<u32> {
        self.definition(pointer).filter(|d| d.opcode == op::TYPE_POINTER).map(|d| d.word(2))
    }

    /// The value of a constant of 32 bits, or the default of a specialization constant.
    pub fn constant(&self, id: u32) -> Option<u32> {
        let definition = self.definition(id)?;
        matches!(definition.opcode, op::CONSTANT | op::SPEC_CONSTANT).then(|| definition.word(2))
    }

    /// Returns the type of an array's elements, and how many there are in all its dimensions. A type that is no array
    /// is returned with 1.
    pub fn array_element(&self, id: u32) -> (u32, u32) {
        match self.definition(id) {
            Some(array) if array.opcode == op::TYPE_ARRAY => {
                let (inner, count) = self.array_element(array.word(1));
                (inner, count.saturating_mul(self.constant(array.word(2)).unwrap_or(1)))
            }
            Some(array) if array.opcode == op::TYPE_RUNTIME_ARRAY => (array.word(1), u32::MAX),
            _ => (id, 1),
        }
    }

    /// The ids of the types of a struct's members; none for a type that is no struct.
    pub fn member_types(&self, id: u32) -> &'a [u32] {
        match self.definitions.get(&id) {
            Some(Instruction { opcode: op::TYPE_STRUCT, operands }) => operands.get(1..).unwrap_or_default(),
            _ => &[],
        }
    }

    /// Returns the type and the count of the numbers in a scalar or a vector of 32-bit numbers; `None` for any other
    /// type.
    pub fn number_type(&self, id: u32) -> Option<(Component, u32)> {
        let definition = self.definition(id)?;
        match definition.opcode {
            op::TYPE_FLOAT if definition.word(1) == 32 => Some((Component::Float, 1)),
            op::TYPE_INT if definition.word(1) == 32 => {
                Some((if definition.word(2) == 1 { Component::Int } else { Component::Uint }, 1))
            }
            op::TYPE_VECTOR => {
                self.number_type(definition.word(1)).map(|(component, _)| (component, definition.word(2)))
            }
            _ => None,
        }
    }

    /// The size in bytes of a type without a layout, as in the memory that a workgroup shares.
    pub fn plain_size(&self, id: u32) -> Option<u32> {
        self.sizes.get(&id).copied()
    }

    /// True if a struct has members that are built-in variables, such as `gl_Position`.
    pub fn has_built_in_members(&self, id: u32) -> bool {
        let (element, _) = self.array_element(id);
        let built_in = |m: usize| self.member_decoration(element, m as u32, decoration::BUILT_IN).is_some();
        (0..self.member_types(element).len()).any(built_in)
    }

    /// True if a variable, or every member of its block, is declared `readonly`.
    pub fn is_read_only(&self, id: u32, block: u32) -> bool {
        let members = self.member_types(block).len() as u32;
        let is_member_read_only = |m: u32| self.member_decoration(block, m, decoration::NON_WRITABLE).is_some();
        (members > 0 && (0..members).all(is_member_read_only))
            || self.decoration(id, decoration::NON_WRITABLE).is_some()
    }

    /// Returns the threads of a workgroup along each axis: from the built-in constant if there is one, or else from the
    /// execution mode. 1 along each axis without both.
    pub fn local_size(&self) -> Result<[u32; 3], String> {
        const LOCAL_SIZE: u32 = ExecutionMode::LocalSize as u32;
        const LOCAL_SIZE_ID: u32 = ExecutionMode::LocalSizeId as u32;
        const WORKGROUP_SIZE: u32 = BuiltIn::WorkgroupSize as u32;
        let unknown = || "has a workgroup whose size is no constant".to_owned();
        let values_of = |ids: &[u32]| -> Result<[u32; 3], String> {
            let size: Option<Vec<u32>> = ids.iter().take(3).map(|id| self.constant(*id)).collect();
            size.and_then(|size| size.try_into().ok()).ok_or_else(unknown)
        };
        let composites =
            [op::CONSTANT_COMPOSITE, op::SPEC_CONSTANT_COMPOSITE].into_iter().flat_map(|o| self.with_opcode(o));
        for composite in composites {
            if self.decoration(composite.word(1), decoration::BUILT_IN) == Some(WORKGROUP_SIZE) {
                return values_of(composite.operands_from(2));
            }
        }
        if let Some(mode) = self.with_opcode(op::EXECUTION_MODE_ID).find(|m| m.word(1) == LOCAL_SIZE_ID) {
            return values_of(mode.operands_from(2));
        }
        let mode = self.with_opcode(op::EXECUTION_MODE).find(|m| m.word(1) == LOCAL_SIZE);
        Ok(mode.map_or([1; 3], |m| [m.word(2), m.word(3), m.word(4)]))
    }

    /// Returns the words of the module with other places of variables. `bindings` has the new binding, in set 0, of
    /// variables by their ids, and the variable with the id `input` is moved to location 0.
    pub fn with_places(&self, bindings: &BTreeMap<u32, u32>, input: Option<u32>) -> Vec<u32> {
        let is_moved = |i: &Instruction| {
            i.opcode == op::DECORATE
                && match i.word(1) {
                    decoration::BINDING | decoration::SET => bindings.contains_key(&i.word(0)),
                    decoration::LOCATION => input == Some(i.word(0)),
                    _ => false,
                }
        };
        let decorate = |id: u32, what: u32, value: u32| [4 << 16 | u32::from(op::DECORATE), id, what, value];
        let mut places: Vec<u32> = Vec::new();
        for (&id, &binding) in bindings {
            places.extend(decorate(id, decoration::SET, 0));
            places.extend(decorate(id, decoration::BINDING, binding));
        }
        places.extend(input.into_iter().flat_map(|id| decorate(id, decoration::LOCATION, 0)));
        let mut words = self.words[..HEADER].to_vec();
        let mut written = false;
        for i in self.instructions.iter().filter(|i| !is_moved(i)) {
            // Decorations stand before the first type.
            if !written && (op::TYPE_VOID..=op::TYPE_PIPE).contains(&i.opcode) {
                words.append(&mut places);
                written = true;
            }
            words.push(((i.operands.len() as u32 + 1) << 16) | u32::from(i.opcode));
            words.extend(i.operands);
        }
        words
    }
}
