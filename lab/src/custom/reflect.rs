//! Reads the interface of a user's SPIR-V: each variable with its kind of image or its block, the variables between
//! stages and to targets, constants, and demands on a device. The interface is checked against the manifest before any
//! driver sees the code, since a driver may do anything with a shader that does not fit.
//!
//! `code` reads the words, and `blocks` finds the place of each number in a block. Each variable gets a new binding
//! here, since OpenGL counts the bindings of samplers, images and blocks apart, and Vulkan counts them together.

mod blocks;
mod code;

pub use blocks::{BlockField, BlockLayout};

use code::{SpirvCode, decoration, op};
use rspirv::spirv::{Capability, ExecutionModel};
use ssct::gpu::interface::Constant;
use std::collections::BTreeMap;

/// Storage classes of variables.
mod class {
    use rspirv::spirv::StorageClass;

    pub const UNIFORM_CONSTANT: u32 = StorageClass::UniformConstant as u32;
    pub const INPUT: u32 = StorageClass::Input as u32;
    pub const UNIFORM: u32 = StorageClass::Uniform as u32;
    pub const OUTPUT: u32 = StorageClass::Output as u32;
    pub const WORKGROUP: u32 = StorageClass::Workgroup as u32;
    pub const PUSH_CONSTANT: u32 = StorageClass::PushConstant as u32;
    pub const STORAGE_BUFFER: u32 = StorageClass::StorageBuffer as u32;
}

/// Capabilities (SPIR-V, 3.31) that every device of this program has: plain shaders, images of every kind with their
/// queries and gathering, arrays of descriptors, derivatives, and subgroups.
const CAPABILITIES: [Capability; 27] = [
    Capability::Matrix,
    Capability::Shader,
    Capability::ImageGatherExtended,
    Capability::UniformBufferArrayDynamicIndexing,
    Capability::SampledImageArrayDynamicIndexing,
    Capability::StorageBufferArrayDynamicIndexing,
    Capability::StorageImageArrayDynamicIndexing,
    Capability::ImageCubeArray,
    Capability::Sampled1D,
    Capability::Image1D,
    Capability::SampledCubeArray,
    Capability::SampledBuffer,
    Capability::ImageBuffer,
    Capability::StorageImageExtendedFormats,
    Capability::ImageQuery,
    Capability::DerivativeControl,
    Capability::InterpolationFunction,
    Capability::StorageImageReadWithoutFormat,
    Capability::StorageImageWriteWithoutFormat,
    Capability::GroupNonUniform,
    Capability::GroupNonUniformVote,
    Capability::GroupNonUniformArithmetic,
    Capability::GroupNonUniformBallot,
    Capability::GroupNonUniformShuffle,
    Capability::GroupNonUniformShuffleRelative,
    Capability::GroupNonUniformClustered,
    Capability::GroupNonUniformQuad,
];

/// Other capabilities that shaders of engines ask for, with their names in messages.
const NAMES: [(Capability, &str); 14] = [
    (Capability::Geometry, "geometry shaders"),
    (Capability::Tessellation, "tessellation"),
    (Capability::Float16, "16-bit floats"),
    (Capability::Float64, "64-bit floats"),
    (Capability::Int64, "64-bit integers"),
    (Capability::Int16, "16-bit integers"),
    (Capability::ClipDistance, "clip distances"),
    (Capability::SampleRateShading, "shading of each sample"),
    (Capability::ImageRect, "rectangle images"),
    (Capability::SampledRect, "rectangle images"),
    (Capability::Int8, "8-bit integers"),
    (Capability::InputAttachment, "input attachments"),
    (Capability::SparseResidency, "sparse images"),
    (Capability::RayQueryKHR, "ray queries"),
];

/// The type of the numbers that an image, an input or an output has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component {
    Float,
    Int,
    Uint,
}

/// The kind of an image that a shader declares.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageKind {
    pub dim: Dim,
    pub arrayed: bool,
    pub multisampled: bool,
    /// True if lookups compare with a depth.
    pub shadow: bool,
    pub component: Component,
    /// The format of an image for storage, as SPIR-V numbers it; 0 for none.
    pub format: u32,
}

/// The name that is given to a push-constant block without a name of its own.
const NAMELESS_PUSH: &str = "push";

/// Returns a clause for messages that explains a name which consists of set and binding.
pub fn explain_nameless(name: &str) -> String {
    format!("the module has no names, and {name:?} is set and binding; a compiler keeps names with -g")
}

/// The dimensions of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dim {
    One,
    Two,
    Three,
    Cube,
    Rect,
    Buffer,
}

/// A variable with a binding.
#[derive(Debug, Clone)]
pub struct Variable {
    /// The binding in set 0, which no other variable has.
    pub binding: u32,
    /// The variable's name, or else the block's name; if neither has a name, set and binding with a point between them.
    pub name: String,
    /// True if neither the variable nor its block has a name.
    pub is_nameless: bool,
    /// The block's name; empty for an image.
    pub block: String,
    /// Number of elements; above 1 for an array.
    pub count: u32,
    /// True if the shader declares that it only reads the variable.
    pub read_only: bool,
    pub kind: VariableKind,
}

/// The kind of a variable with a binding.
#[derive(Debug, Clone)]
pub enum VariableKind {
    /// An image with a sampler.
    Sampled(ImageKind),
    /// A storage image.
    Stored(ImageKind),
    /// A uniform block.
    Uniform(BlockLayout),
    /// A storage block, with its least number of bytes.
    Storage(u32),
}

/// An input from another stage, or an output to a target.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StageVariable {
    /// The name of the variable.
    pub name: String,
    /// The location of the variable.
    pub location: u32,
    /// The type of the numbers; `None` for a variable that is neither a number nor a vector.
    pub component: Option<Component>,
    /// How many numbers the vector has.
    pub numbers: u32,
}

/// A module and its interface.
#[derive(Debug)]
pub struct ShaderInterface {
    /// The code, in which each variable has its new binding, and the input is at location 0.
    pub words: Vec<u32>,
    /// The variables in the order of their bindings.
    pub variables: Vec<Variable>,
    /// The push-constant block: its name and its layout.
    pub push: Option<(String, BlockLayout)>,
    /// Inputs that a fragment shader reads.
    pub inputs: Vec<StageVariable>,
    /// The outputs in the order of their locations.
    pub outputs: Vec<StageVariable>,
    /// The specialization constants.
    pub constants: Vec<Constant>,
    /// Threads of a workgroup along each axis.
    pub local_size: [u32; 3],
    /// Bytes that a workgroup shares.
    pub shared_bytes: u64,
}

/// Reads a module whose entry point is `main`; `is_fragment` is true for a fragment shader, and false for a compute shader.
///
/// # Errors
/// A sentence on the first fault, which does not name the file.
pub fn reflect(words: &[u32], is_fragment: bool) -> Result<ShaderInterface, String> {
    let code = SpirvCode::read(words).ok_or("is not SPIR-V")?;
    check_entry(&code, is_fragment)?;
    for capability in code.with_opcode(op::CAPABILITY) {
        let number = capability.word(0);
        if !CAPABILITIES.iter().any(|known| *known as u32 == number) {
            let name = NAMES.iter().find(|(known, _)| *known as u32 == number).map(|(_, name)| (*name).to_owned());
            let name = name.unwrap_or_else(|| format!("the capability {number} of SPIR-V"));
            return Err(format!("needs {name}, which this program does not turn on"));
        }
    }
    let mut interface = ShaderInterface {
        words: Vec::new(),
        variables: Vec::new(),
        push: None,
        inputs: Vec::new(),
        outputs: Vec::new(),
        constants: specialization_constants(&code),
        local_size: code.local_size()?,
        shared_bytes: 0,
    };
    // The variables that descriptors bind: set and binding, id, and variable.
    let mut resources = Vec::new();
    for variable in code.with_opcode(op::VARIABLE) {
        let (pointer, id, class) = (variable.word(0), variable.word(1), variable.word(2));
        let pointee = code.pointee(pointer).ok_or("has a variable without a type")?;
        match class {
            class::UNIFORM_CONSTANT | class::UNIFORM | class::STORAGE_BUFFER => {
                let place = [decoration::SET, decoration::BINDING].map(|d| code.decoration(id, d).unwrap_or(0));
                let variable = read_bound(&code, (id, class, pointee), place)?;
                resources.push((place, id, variable));
            }
            class::PUSH_CONSTANT => {
                let layout = BlockLayout::from_type(&code, pointee, id)?;
                let name = code.name(pointee);
                interface.push =
                    Some((if name.is_empty() { NAMELESS_PUSH.to_owned() } else { name.to_owned() }, layout));
            }
            class::INPUT if is_fragment && code.is_used(id) => {
                interface.inputs.extend(stage_variable(&code, id, pointee))
            }
            class::OUTPUT if is_fragment => interface.outputs.extend(stage_variable(&code, id, pointee)),
            class::WORKGROUP => interface.shared_bytes += u64::from(code.plain_size(pointee).unwrap_or(0)),
            _ => {}
        }
    }
    interface.outputs.sort_by_key(|output| output.location);
    resources.sort_by_key(|(place, id, _)| (*place, *id));
    let mut bindings = BTreeMap::new();
    for (binding, (_, id, mut variable)) in (0..).zip(resources) {
        variable.binding = binding;
        bindings.insert(id, binding);
        interface.variables.push(variable);
    }
    interface.words = code.with_places(&bindings, sole_input(&code, &interface.inputs));
    Ok(interface)
}

/// Returns the id of the input that a fragment shader reads, if it reads only one. The input is moved to location 0, at
/// which texture coordinates arrive.
fn sole_input(code: &SpirvCode, inputs: &[StageVariable]) -> Option<u32> {
    let [only] = inputs else { return None };
    let is_only_input =
        |id: u32| code.name(id) == only.name && code.decoration(id, decoration::LOCATION) == Some(only.location);
    let mut ids = code.with_opcode(op::VARIABLE).filter(|v| v.word(2) == class::INPUT).map(|v| v.word(1));
    ids.find(|id| is_only_input(*id))
}

/// Checks that the module has an entry point `main`, and that its stage is the wanted one.
fn check_entry(code: &SpirvCode, is_fragment: bool) -> Result<(), String> {
    const FRAGMENT: u32 = ExecutionModel::Fragment as u32;
    const COMPUTE: u32 = ExecutionModel::GLCompute as u32;
    let entries: Vec<(u32, String)> = code.with_opcode(op::ENTRY_POINT).map(|e| (e.word(0), e.text(2))).collect();
    let Some((stage, _)) = entries.iter().find(|(_, name)| name == "main") else {
        return Err("has no entry point main".to_owned());
    };
    match (*stage, is_fragment) {
        (FRAGMENT, true) | (COMPUTE, false) => Ok(()),
        (FRAGMENT, false) => Err("is a fragment shader, and the pass is a compute pass".to_owned()),
        (COMPUTE, true) => Err("is a compute shader, and the pass is a fragment pass".to_owned()),
        _ => Err("is neither a fragment nor a compute shader".to_owned()),
    }
}

/// Reads a variable that a descriptor binds: from its id, its storage class, the type that it points to, and its set
/// and binding in the module. Its new binding is still 0.
fn read_bound(
    code: &SpirvCode,
    (id, class, pointee): (u32, u32, u32),
    [set, binding]: [u32; 2],
) -> Result<Variable, String> {
    let own_name = code.name(id);
    let (element, count) = code.array_element(pointee);
    let is_nameless = own_name.is_empty() && code.name(element).is_empty();
    let block = if is_nameless { format!("{set}.{binding}") } else { code.name(element).to_owned() };
    let name = if own_name.is_empty() { block.clone() } else { own_name.to_owned() };
    let is_storage = class == class::STORAGE_BUFFER || code.decoration(element, decoration::BUFFER_BLOCK).is_some();
    let separate = || {
        let why = if is_nameless { format!(" ({})", explain_nameless(&name)) } else { String::new() };
        format!("binds {name} as a separate image or sampler{why}; use sampler2D and the like, which are both")
    };
    let kind = match code.definition(element).map(|d| (d.opcode, d)) {
        Some((op::TYPE_SAMPLED_IMAGE, definition)) => {
            VariableKind::Sampled(image_kind(code, definition.word(1)).ok_or_else(separate)?)
        }
        // Operand 6 of an image's type is 2 for a storage image.
        Some((op::TYPE_IMAGE, definition)) => match (image_kind(code, element), definition.word(6)) {
            (Some(kind), 2) => VariableKind::Stored(kind),
            // A buffer of texels has no sampler.
            (Some(kind), _) if kind.dim == Dim::Buffer => VariableKind::Sampled(kind),
            _ => return Err(separate()),
        },
        Some((op::TYPE_STRUCT, _)) if class != class::UNIFORM_CONSTANT => match is_storage {
            true => VariableKind::Storage(BlockLayout::least_bytes(code, element)),
            false => VariableKind::Uniform(BlockLayout::from_type(code, element, id)?),
        },
        Some((op::TYPE_SAMPLER, _)) => return Err(separate()),
        _ => return Err(format!("binds {name} as something that is neither an image nor a block")),
    };
    let block = if matches!(kind, VariableKind::Sampled(_) | VariableKind::Stored(_)) { String::new() } else { block };
    Ok(Variable { binding: 0, name, is_nameless, block, count, read_only: code.is_read_only(id, element), kind })
}

/// Returns the kind of image that the type `id` is; `None` for another type, and for texels that are no 32-bit numbers.
fn image_kind(code: &SpirvCode, id: u32) -> Option<ImageKind> {
    let definition = code.definition(id).filter(|d| d.opcode == op::TYPE_IMAGE)?;
    let dim = match definition.word(2) {
        0 => Dim::One,
        1 => Dim::Two,
        2 => Dim::Three,
        3 => Dim::Cube,
        4 => Dim::Rect,
        5 => Dim::Buffer,
        _ => return None,
    };
    let (component, _) = code.number_type(definition.word(1))?;
    // Operands 3 to 5 of an image's type are flags, and operand 7 is its format.
    let [shadow, arrayed, multisampled] = [3, 4, 5].map(|operand| definition.word(operand) == 1);
    Some(ImageKind { dim, arrayed, multisampled, shadow, component, format: definition.word(7) })
}

/// Reads the input or output with the id `id` and the type `pointee`; `None` for a built-in variable of the stage.
fn stage_variable(code: &SpirvCode, id: u32, pointee: u32) -> Option<StageVariable> {
    if code.decoration(id, decoration::BUILT_IN).is_some() || code.has_built_in_members(pointee) {
        return None;
    }
    let numbers = code.number_type(pointee);
    Some(StageVariable {
        name: code.name(id).to_owned(),
        location: code.decoration(id, decoration::LOCATION).unwrap_or(0),
        component: numbers.map(|(component, _)| component),
        numbers: numbers.map_or(0, |(_, n)| n),
    })
}

/// Reads the specialization constants, each with its type in Rust and the bits of its default value; sorted by id.
fn specialization_constants(code: &SpirvCode) -> Vec<Constant> {
    let mut found = Vec::new();
    for definition in [op::SPEC_CONSTANT, op::SPEC_CONSTANT_TRUE, op::SPEC_CONSTANT_FALSE]
        .into_iter()
        .flat_map(|o| code.with_opcode(o))
    {
        // The operands are the id of the type, the id of the constant and, except for a bool, its default value.
        let [type_id, constant_id, default_bits] = [0, 1, 2].map(|operand| definition.word(operand));
        let Some(id) = code.decoration(constant_id, decoration::SPEC_ID) else { continue };
        let ty = match code.number_type(type_id) {
            _ if definition.opcode != op::SPEC_CONSTANT => "bool",
            Some((Component::Float, _)) => "f32",
            Some((Component::Int, _)) => "i32",
            _ => "u32",
        };
        let is_true = definition.opcode == op::SPEC_CONSTANT_TRUE;
        let default = if ty == "bool" { u32::from(is_true) } else { default_bits };
        found.push(Constant { id, name: code.name(constant_id).to_owned(), ty, default });
    }
    found.sort();
    found
}

#[cfg(test)]
mod tests;
