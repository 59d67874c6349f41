//! Reads the interface of a shader's stage off its SPIR-V: bindings, blocks, outputs and specialization constants.
//! `build.rs` includes this file, and so does the window.

use rspirv::dr::{Module, Operand};
use rspirv::spirv::{Decoration, Dim, ExecutionMode, ExecutionModel, ImageFormat, Op, StorageClass, Word};
use std::collections::{BTreeMap, HashMap};

/// The interface of a stage to its pipeline, and the layout of its blocks in memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Interface {
    /// Bindings of the stage, by number.
    pub bindings: Vec<StageBinding>,
    /// Push-constant block of the stage.
    pub push: Option<PushBlock>,
    /// Name of each output of a fragment stage, and the Rust type of its components, by location.
    pub outputs: Vec<(String, &'static str)>,
    /// Specialization constants of the stage, by id.
    pub constants: Vec<Constant>,
    /// Threads of a workgroup.
    pub local_size: [u32; 3],
    /// Uniform and push-constant blocks and the structs in them, by name.
    pub blocks: BTreeMap<String, Block>,
    /// Vulkan's names for the formats of storage images, by binding. Formats unknown to `format_name` are left out.
    pub formats: BTreeMap<u32, &'static str>,
}

/// One binding of a stage.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct StageBinding {
    /// `layout(binding = …)`.
    pub binding: u32,
    /// The variable's name, or the block's where the variable has none.
    pub name: String,
    /// Name of the variant of `BindingKind`.
    pub kind: &'static str,
    /// Number of descriptors; above 1 for an array of images.
    pub count: u32,
    /// Name of the block; empty for an image.
    pub block: String,
    /// Whether the stage declares the binding as read-only.
    pub read_only: bool,
}

/// A push-constant block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PushBlock {
    /// The variable's name.
    pub name: String,
    /// The block's name.
    pub block: String,
    /// Size in bytes.
    pub size: u32,
}

/// A specialization constant.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Constant {
    /// `layout(constant_id = …)`.
    pub id: u32,
    /// Name of the constant.
    pub name: String,
    /// Type of the constant in Rust.
    pub ty: &'static str,
    /// Bits of the default value in the shader; 0 or 1 for a `bool`.
    pub default: u32,
}

impl Interface {
    /// Finds the interface of a module of SPIR-V; errors call the module `name`.
    ///
    /// # Errors
    /// A sentence about a part of the module that has no twin in Rust.
    pub fn from_words(words: &[u32], name: &str) -> Result<Self, String> {
        let (words, local_size) = without_local_size_ids(words);
        let module = rspirv::dr::load_words(&words).map_err(|e| format!("{name}: {e}"))?;
        Reflection::new(&module, name, local_size).read_interface()
    }
}

/// Returns Vulkan's name for a format of an image; `None` for a format that no output of a shader has.
fn format_name(format: ImageFormat) -> Option<&'static str> {
    Some(match format {
        ImageFormat::Rgba32f => "R32G32B32A32_SFLOAT",
        ImageFormat::Rgba16f => "R16G16B16A16_SFLOAT",
        ImageFormat::Rg32f => "R32G32_SFLOAT",
        ImageFormat::R32f => "R32_SFLOAT",
        ImageFormat::Rg16f => "R16G16_SFLOAT",
        ImageFormat::R8 => "R8_UNORM",
        ImageFormat::R32ui => "R32_UINT",
        ImageFormat::Rgba32ui => "R32G32B32A32_UINT",
        _ => return None,
    })
}

/// Returns the words of a module without OpExecutionModeId, which rspirv's loader does not know, and the ids of the
/// three constants of LocalSizeId, the only mode for which SPIR-V 1.6 uses this instruction.
fn without_local_size_ids(words: &[u32]) -> (Vec<u32>, Option<[Word; 3]>) {
    const HEADER_WORDS: usize = 5;
    let (mut other_words, mut size_ids) = (words[..HEADER_WORDS].to_vec(), None);
    let mut offset = HEADER_WORDS;
    while offset < words.len() {
        // The upper half of an instruction's first word is the instruction's length in words.
        let instruction = &words[offset..offset + (words[offset] >> 16).max(1) as usize];
        offset += instruction.len();
        match *instruction {
            [head, _, mode, x, y, z]
                if head & 0xffff == Op::ExecutionModeId as u32 && mode == ExecutionMode::LocalSizeId as u32 =>
            {
                size_ids = Some([x, y, z]);
            }
            _ => other_words.extend_from_slice(instruction),
        }
    }
    (other_words, size_ids)
}

/// Returns the number that follows a decoration; 0 if none does.
fn number_or_zero(operands: &[Operand]) -> u32 {
    if let [Operand::LiteralBit32(number), ..] = operands { *number } else { 0 }
}

/// A block's Rust twin.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// Name, offset in bytes, Rust type, and size in bytes of each field.
    pub fields: Vec<(String, u32, String, u32)>,
    /// Size in bytes.
    pub size: u32,
    /// The stage in which the block was found first.
    pub used_in: String,
}

/// A module with look-ups of its names.
struct Reflection<'a> {
    module: &'a Module,
    name: &'a str,
    /// Ids of the constants for the workgroup's three sides.
    local_size: Option<[Word; 3]>,
    names: HashMap<Word, String>,
    /// Names of the members of structs, by the struct's id and the member's index.
    member_names: HashMap<(Word, u32), String>,
}

impl<'a> Reflection<'a> {
    /// Collects the names of ids and of the members of structs.
    fn new(module: &'a Module, name: &'a str, local_size: Option<[Word; 3]>) -> Self {
        let (mut names, mut member_names) = (HashMap::new(), HashMap::new());
        for i in &module.debug_names {
            match (i.class.opcode, i.operands.as_slice()) {
                (Op::Name, [Operand::IdRef(id), Operand::LiteralString(name)]) => {
                    names.insert(*id, name.clone());
                }
                (Op::MemberName, [Operand::IdRef(id), Operand::LiteralBit32(m), Operand::LiteralString(s)]) => {
                    member_names.insert((*id, *m), s.clone());
                }
                _ => {}
            }
        }
        Self { module, name, local_size, names, member_names }
    }

    /// Returns the number of the decoration `wanted` of an id, or 0 if it has no number; `None` without the decoration.
    fn decoration(&self, id: Word, wanted: Decoration) -> Option<u32> {
        self.module.annotations.iter().find_map(|i| match (i.class.opcode, i.operands.as_slice()) {
            (Op::Decorate, [Operand::IdRef(target), Operand::Decoration(d), rest @ ..])
                if *target == id && *d == wanted =>
            {
                Some(number_or_zero(rest))
            }
            _ => None,
        })
    }

    /// Returns the number of a decoration of a struct's member, as [`Self::decoration`] does for an id.
    fn member_decoration(&self, id: Word, member: u32, wanted: Decoration) -> Option<u32> {
        self.module.annotations.iter().find_map(|i| match (i.class.opcode, i.operands.as_slice()) {
            (
                Op::MemberDecorate,
                [Operand::IdRef(target), Operand::LiteralBit32(m), Operand::Decoration(d), rest @ ..],
            ) if *target == id && *m == member && *d == wanted => Some(number_or_zero(rest)),
            _ => None,
        })
    }

    /// Finds the instruction that declares a type, a constant or a variable.
    fn definition(&self, id: Word) -> Option<&rspirv::dr::Instruction> {
        self.module.types_global_values.iter().find(|i| i.result_id == Some(id))
    }

    /// Returns the operand `index` of the instruction that declares `id`, if the operand is an id.
    fn operand_id(&self, id: Word, index: usize) -> Result<Word, String> {
        match self.definition(id).and_then(|d| d.operands.get(index)) {
            Some(Operand::IdRef(x)) => Ok(*x),
            _ => Err(format!("{}: unexpected SPIR-V at id {id}", self.name)),
        }
    }

    /// Returns the value that a constant of 32 bits declares.
    fn constant_u32(&self, id: Word) -> Result<u32, String> {
        match self.definition(id).map(|d| d.operands.as_slice()) {
            Some([Operand::LiteralBit32(v)]) => Ok(*v),
            _ => Err(format!("{}: an array length that is no plain constant", self.name)),
        }
    }

    /// Returns the id of each variable, its storage class, and the id of the type that it points to.
    fn variables(&self) -> Result<Vec<(Word, StorageClass, Word)>, String> {
        let mut found = Vec::new();
        for i in self.module.types_global_values.iter().filter(|i| i.class.opcode == Op::Variable) {
            if let (Some(id), Some(pointer), Some(Operand::StorageClass(class))) =
                (i.result_id, i.result_type, i.operands.first())
            {
                found.push((id, *class, self.operand_id(pointer, 1)?));
            }
        }
        Ok(found)
    }

    /// Reads bindings, push constants, outputs, constants and blocks off the module.
    fn read_interface(&self) -> Result<Interface, String> {
        let mut found = Interface {
            bindings: Vec::new(),
            push: None,
            outputs: Vec::new(),
            constants: self.constants()?,
            local_size: match self.local_size {
                Some([x, y, z]) => [self.constant_u32(x)?, self.constant_u32(y)?, self.constant_u32(z)?],
                None => [1; 3],
            },
            blocks: BTreeMap::new(),
            formats: BTreeMap::new(),
        };
        let is_fragment = self.is_fragment();
        let mut outputs = BTreeMap::new();
        for (id, class, pointee) in self.variables()? {
            let own_name = self.names.get(&id).filter(|name| !name.is_empty());
            let block = self.names.get(&pointee).cloned().unwrap_or_default();
            let name = own_name.unwrap_or(&block).clone();
            let is_block = matches!(class, StorageClass::Uniform | StorageClass::PushConstant);
            if is_block && self.definition(pointee).is_some_and(|d| d.class.opcode == Op::TypeStruct) {
                self.add_structs(pointee, &mut found.blocks)?;
            }
            if class == StorageClass::PushConstant {
                found.push = Some(PushBlock { name, block, size: self.struct_layout(pointee)?.size });
                continue;
            }
            if is_fragment && class == StorageClass::Output {
                if let Some(location) = self.decoration(id, Decoration::Location) {
                    outputs.insert(location, (name, self.component_type(pointee)?));
                }
                continue;
            }
            let Some(binding) = self.decoration(id, Decoration::Binding) else { continue };
            let mut definition = self.definition(pointee).ok_or("no type")?;
            let mut count = 1;
            if class == StorageClass::UniformConstant && definition.class.opcode == Op::TypeArray {
                count = self.constant_u32(self.operand_id(pointee, 1)?)?;
                definition = self.definition(self.operand_id(pointee, 0)?).ok_or("no type")?;
            }
            // Operands 1 and 6 of OpTypeImage are its dimension and its format.
            let is_buffer = definition.operands.get(1) == Some(&Operand::Dim(Dim::DimBuffer));
            let kind = match (class, definition.class.opcode) {
                (StorageClass::UniformConstant, Op::TypeImage) if is_buffer => "StorageTexels",
                (StorageClass::UniformConstant, Op::TypeSampledImage) => "SampledImage",
                (StorageClass::UniformConstant, Op::TypeImage) => "StorageImage",
                (StorageClass::UniformConstant, Op::TypeAccelerationStructureKHR) => "RayStructure",
                (StorageClass::Uniform, _) => "UniformBuffer",
                (StorageClass::StorageBuffer, _) => "StorageBuffer",
                other => return Err(format!("{}: binding {binding} has an unknown kind {other:?}", self.name)),
            };
            if let ("StorageImage", Some(Operand::ImageFormat(format))) = (kind, definition.operands.get(6)) {
                found.formats.extend(format_name(*format).map(|name| (binding, name)));
            }
            found.bindings.push(StageBinding {
                binding,
                name,
                kind,
                count,
                block,
                read_only: self.is_read_only(id, pointee),
            });
        }
        found.bindings.sort();
        if outputs.keys().copied().ne(0..outputs.len() as u32) {
            return Err(format!("{}: its outputs are not at locations 0, 1 and so on", self.name));
        }
        found.outputs = outputs.into_values().collect();
        Ok(found)
    }

    fn is_fragment(&self) -> bool {
        let model = |i: &rspirv::dr::Instruction| i.operands.first().cloned();
        self.module.entry_points.iter().any(|i| model(i) == Some(Operand::ExecutionModel(ExecutionModel::Fragment)))
    }

    /// Whether a variable, or every member of its block, is declared `readonly`.
    fn is_read_only(&self, id: Word, pointee: Word) -> bool {
        let members = match self.definition(pointee) {
            Some(d) if d.class.opcode == Op::TypeStruct => self.members(pointee).len() as u32,
            _ => 0,
        };
        let is_read_only = |member| self.member_decoration(pointee, member, Decoration::NonWritable).is_some();
        (members > 0 && (0..members).all(is_read_only)) || self.decoration(id, Decoration::NonWritable).is_some()
    }

    /// Returns the specialization constants, sorted by id.
    fn constants(&self) -> Result<Vec<Constant>, String> {
        let mut found = Vec::new();
        for i in &self.module.types_global_values {
            let is_spec = matches!(i.class.opcode, Op::SpecConstant | Op::SpecConstantTrue | Op::SpecConstantFalse);
            let (true, Some(result), Some(ty)) = (is_spec, i.result_id, i.result_type) else { continue };
            let Some(id) = self.decoration(result, Decoration::SpecId) else { continue };
            let name = self.names.get(&result).cloned().unwrap_or_default();
            let default = match i.operands.first() {
                Some(Operand::LiteralBit32(bits)) => *bits,
                _ => u32::from(i.class.opcode == Op::SpecConstantTrue),
            };
            found.push(Constant { id, name, ty: self.component_type(ty)?, default });
        }
        found.sort();
        Ok(found)
    }

    /// Returns the Rust type of a scalar, or of a vector's component.
    fn component_type(&self, id: Word) -> Result<&'static str, String> {
        let d = self.definition(id).ok_or("no type")?;
        Ok(match d.class.opcode {
            Op::TypeBool => "bool",
            Op::TypeFloat => "f32",
            Op::TypeInt if d.operands.get(1) == Some(&Operand::LiteralBit32(1)) => "i32",
            Op::TypeInt => "u32",
            Op::TypeVector => self.component_type(self.operand_id(id, 0)?)?,
            other => return Err(format!("{}: an output or a constant of type {other:?}", self.name)),
        })
    }

    /// Adds a struct, and the structs that its members are made of, to `structs` by their names.
    fn add_structs(&self, id: Word, structs: &mut BTreeMap<String, Block>) -> Result<(), String> {
        for member in self.members(id) {
            let mut ty = member;
            while self.definition(ty).is_some_and(|d| d.class.opcode == Op::TypeArray) {
                ty = self.operand_id(ty, 0)?;
            }
            if self.definition(ty).is_some_and(|d| d.class.opcode == Op::TypeStruct) {
                self.add_structs(ty, structs)?;
            }
        }
        structs.insert(self.names.get(&id).cloned().unwrap_or_default(), self.struct_layout(id)?);
        Ok(())
    }

    /// The ids of the types of a struct's members.
    fn members(&self, id: Word) -> Vec<Word> {
        let operands = self.definition(id).map(|d| d.operands.as_slice()).unwrap_or_default();
        operands.iter().filter_map(|o| if let Operand::IdRef(x) = o { Some(*x) } else { None }).collect()
    }

    /// Returns the fields of a struct with their offsets, and the struct's size.
    fn struct_layout(&self, id: Word) -> Result<Block, String> {
        let mut fields = Vec::new();
        let (mut end, mut align) = (0, 4);
        for (member, ty) in self.members(id).into_iter().enumerate() {
            let member = member as u32;
            let offset = self.member_decoration(id, member, Decoration::Offset).unwrap_or(0);
            let (rust, size, member_align) = self.rust_type(ty)?;
            fields.push((self.member_names.get(&(id, member)).cloned().unwrap_or_default(), offset, rust, size));
            end = end.max(offset + size);
            align = align.max(member_align);
        }
        let size = end.div_ceil(align) * align;
        Ok(Block { fields, size, used_in: self.name.to_owned() })
    }

    /// Returns a type's name in Rust, and its size and its alignment in a GLSL block, both in bytes.
    fn rust_type(&self, id: Word) -> Result<(String, u32, u32), String> {
        let d = self.definition(id).ok_or("no type")?;
        let wrong = || format!("{}: a block member of type {:?} has no Rust twin", self.name, d.class.opcode);
        Ok(match d.class.opcode {
            Op::TypeFloat => ("f32".into(), 4, 4),
            Op::TypeInt => {
                (if d.operands.get(1) == Some(&Operand::LiteralBit32(1)) { "i32" } else { "u32" }.into(), 4, 4)
            }
            Op::TypeVector | Op::TypeMatrix => {
                let (inner, size, align) = self.rust_type(self.operand_id(id, 0)?)?;
                let Some(Operand::LiteralBit32(n)) = d.operands.get(1) else { return Err(wrong()) };
                // The columns of a matrix with three rows lie 16 bytes apart.
                if d.class.opcode == Op::TypeMatrix && size == 12 {
                    return Ok((format!("[[f32; 4]; {n}]"), 16 * n, 16));
                }
                if d.class.opcode == Op::TypeMatrix && size != 16 {
                    return Err(wrong());
                }
                let align = if d.class.opcode == Op::TypeMatrix { align } else { n.next_power_of_two() * 4 };
                (format!("[{inner}; {n}]"), n * size, align)
            }
            Op::TypeArray => {
                let (inner, size, align) = self.rust_type(self.operand_id(id, 0)?)?;
                let n = self.constant_u32(self.operand_id(id, 1)?)?;
                if self.decoration(id, Decoration::ArrayStride) != Some(size) {
                    return Err(format!("{}: an array whose stride is not its element's size", self.name));
                }
                (format!("[{inner}; {n}]"), n * size, align.max(16))
            }
            Op::TypeStruct => {
                let block = self.struct_layout(id)?;
                let size = block.size.div_ceil(16) * 16;
                if size != block.size {
                    return Err(format!("{}: pad the nested struct to 16 bytes", self.name));
                }
                (self.names.get(&id).cloned().unwrap_or_default(), size, 16)
            }
            _ => return Err(wrong()),
        })
    }
}
