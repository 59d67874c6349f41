//! Checks the kinds of images, inputs and outputs that a shader declares against those that it gets. A driver does not
//! check them, and would read wrong numbers or memory outside of the image.

use super::manifest::{ImageSection, Manifest, Pass, PassStage, format_of};
use super::reflect::{Component, Dim, ImageKind, ShaderInterface, StageVariable};
use super::source::ImageSource;
use ash::vk;
use std::collections::BTreeMap;

/// The most threads that a workgroup may have. Some devices allow fewer; making the pipeline checks that.
const MAX_THREADS: u32 = 1024;
/// The most threads that a workgroup may have along each axis.
const MAX_SIDES: [u32; 3] = [1024, 1024, 64];

/// The most bytes that a workgroup may share.
const MAX_SHARED_BYTES: u64 = 32768;

/// The most bytes of push constants that every device takes.
const MAX_PUSH_BYTES: u32 = 128;

/// Checks a sampled image against the source that feeds it.
///
/// # Errors
/// A clause that continues a sentence after the name of the variable.
pub fn check_sampled(
    kind: &ImageKind,
    source: &ImageSource,
    images: &BTreeMap<String, ImageSection>,
) -> Result<(), String> {
    let fed = source_kind(source, images);
    if kind.shadow {
        return Err(format!("a {}, which compares with a depth; compare in the shader", sampler_type(kind)));
    }
    if has_same_texels(kind, &fed) {
        return Ok(());
    }
    Err(format!("a {}, and is fed {source}, which is a {}", sampler_type(kind), sampler_type(&fed)))
}

/// True if a shader that declares an image as `declared` can read one of the kind `fed`. Comparisons with a depth and
/// formats are not looked at.
fn has_same_texels(declared: &ImageKind, fed: &ImageKind) -> bool {
    let is_equal = (declared.dim, declared.arrayed, declared.component) == (fed.dim, fed.arrayed, fed.component);
    is_equal && !declared.multisampled
}

/// Checks a storage image against the method's own image that feeds it.
///
/// # Errors
/// A clause that continues a sentence after the name of the variable.
pub fn check_stored(kind: &ImageKind, name: &str, images: &BTreeMap<String, ImageSection>) -> Result<(), String> {
    let Some(section) = images.get(name) else { return Ok(()) };
    let fed = source_kind(&ImageSource::Own(name.to_owned()), images);
    if !has_same_texels(kind, &fed) {
        let [declared, actual] = [kind, &fed].map(|k| sampler_type(k).replace("sampler", "image"));
        return Err(format!("an {declared}, and {name} is an {actual}"));
    }
    let storable = STORABLE.iter().find(|(format, _)| *format == section.format);
    match storable {
        None => Err(format!("stored to, and {name} is {}, which shaders can only draw to and look up", section.format)),
        Some((format, number)) if kind.format != 0 && kind.format != *number => {
            let declared = STORABLE.iter().find(|(_, number)| *number == kind.format);
            let declared = declared.map_or("of another format", |(format, _)| format);
            Err(format!("declared {declared}, and {name} is {format}"))
        }
        _ => Ok(()),
    }
}

/// Formats to which shaders can store, as a manifest names them, and their numbers in SPIR-V.
const STORABLE: [(&str, u32); 15] = [
    ("r8", 15),
    ("rg8", 13),
    ("rgba8", 4),
    ("r16f", 9),
    ("rg16f", 7),
    ("rgba16f", 2),
    ("r32f", 3),
    ("rg32f", 6),
    ("rgba32f", 1),
    ("r32ui", 33),
    ("rg32ui", 35),
    ("rgba32ui", 30),
    ("r32i", 24),
    ("r11f-g11f-b10f", 8),
    ("rgb10-a2", 11),
];

/// Returns the kind of image that a shader gets from a source.
fn source_kind(source: &ImageSource, images: &BTreeMap<String, ImageSection>) -> ImageKind {
    let plane = ImageKind {
        dim: Dim::Two,
        arrayed: false,
        multisampled: false,
        shadow: false,
        component: Component::Float,
        format: 0,
    };
    match source {
        ImageSource::Sky => ImageKind { dim: Dim::Cube, ..plane },
        ImageSource::Captures(_) => ImageKind { dim: Dim::Cube, arrayed: true, ..plane },
        ImageSource::Previous(original) => source_kind(original, images),
        ImageSource::Own(name) => {
            let format = images.get(name).and_then(|section| format_of(&section.format));
            ImageKind { component: format.map_or(Component::Float, format_component), ..plane }
        }
        _ => plane,
    }
}

/// Returns the type of the numbers that a shader reads from an image of a format.
fn format_component(format: vk::Format) -> Component {
    match format {
        vk::Format::R32_UINT | vk::Format::R32G32_UINT | vk::Format::R32G32B32A32_UINT => Component::Uint,
        vk::Format::R32_SINT => Component::Int,
        _ => Component::Float,
    }
}

/// Returns the GLSL type of a sampler for a kind of image, such as `usampler2DArray`.
fn sampler_type(kind: &ImageKind) -> String {
    let prefix = match kind.component {
        Component::Float => "",
        Component::Int => "i",
        Component::Uint => "u",
    };
    let dim = match kind.dim {
        Dim::One => "1D",
        Dim::Two => "2D",
        Dim::Three => "3D",
        Dim::Cube => "Cube",
        Dim::Rect => "2DRect",
        Dim::Buffer => "Buffer",
    };
    let [samples, array, shadow] = [(kind.multisampled, "MS"), (kind.arrayed, "Array"), (kind.shadow, "Shadow")]
        .map(|(applies, word)| if applies { word } else { "" });
    format!("{prefix}sampler{dim}{samples}{array}{shadow}")
}

/// Checks what a pass's shader demands of the device, and, for a fragment shader, its inputs from the vertex stage and
/// its outputs to targets. `file` is the shader's name in messages.
///
/// # Errors
/// A sentence about the first fault.
pub fn check_stage(manifest: &Manifest, pass: &Pass, interface: &ShaderInterface, file: &str) -> Result<(), String> {
    if let Some((block, layout)) = &interface.push
        && layout.size > MAX_PUSH_BYTES
    {
        let size = layout.size;
        return Err(format!("the push constants {block} of {file} have {size} bytes, more than {MAX_PUSH_BYTES}"));
    }
    match pass.stage {
        PassStage::Compute => check_workgroup(interface, file),
        PassStage::Fragment => {
            check_inputs(&interface.inputs, file)?;
            check_outputs(manifest, pass, &interface.outputs, file)
        }
    }
}

/// Checks the size of a compute shader's workgroups, and the memory that a workgroup shares.
fn check_workgroup(interface: &ShaderInterface, file: &str) -> Result<(), String> {
    let [x, y, z] = interface.local_size;
    let threads = u64::from(x) * u64::from(y) * u64::from(z);
    let sides_fit = interface.local_size.iter().zip(MAX_SIDES).all(|(side, most)| (1..=most).contains(side));
    if !sides_fit || threads > u64::from(MAX_THREADS) {
        let [max_x, max_y, max_z] = MAX_SIDES;
        return Err(format!(
            "the workgroups of {file} have {x}x{y}x{z} threads; at most {MAX_THREADS}, and {max_x}x{max_y}x{max_z}, \
             are possible"
        ));
    }
    if interface.shared_bytes > MAX_SHARED_BYTES {
        let bytes = interface.shared_bytes;
        return Err(format!("the workgroups of {file} share {bytes} bytes, more than {MAX_SHARED_BYTES}"));
    }
    Ok(())
}

/// Checks that a fragment shader reads from the vertex stage at most one `vec2`, the texture coordinates.
fn check_inputs(inputs: &[StageVariable], file: &str) -> Result<(), String> {
    let is_uv = |input: &StageVariable| input.component == Some(Component::Float) && input.numbers == 2;
    // The first input that is no `vec2` is at fault, or the last of several if all of them are.
    let wrong_input = match inputs {
        [] => None,
        [only] if is_uv(only) => None,
        inputs => inputs.iter().find(|input| !is_uv(input)).or(inputs.last()),
    };
    match wrong_input {
        Some(input) => {
            Err(format!("{file} reads `{}`; only texture coordinates are given, as one `in vec2`", input.name))
        }
        None => Ok(()),
    }
}

/// Checks that a fragment shader writes as many outputs as its pass has targets, each of the type of its target.
fn check_outputs(manifest: &Manifest, pass: &Pass, outputs: &[StageVariable], file: &str) -> Result<(), String> {
    let (count, targets) = (outputs.len(), pass.targets.len());
    if count != targets {
        return Err(format!("the shader writes {count} colours, and the pass has {targets} targets"));
    }
    for (number, (output, (target, _level))) in (0_u32..).zip(outputs.iter().zip(&pass.targets)) {
        let name = &output.name;
        if output.location != number {
            return Err(format!("{file} writes `{name}` at location {}; targets are 0, 1 and so on", output.location));
        }
        let format = manifest.images.get(target).and_then(|image| format_of(&image.format));
        let target_component = format.map_or(Component::Float, format_component);
        if output.component != Some(target_component) {
            let kind = |component: Component| match component {
                Component::Float => "floats",
                Component::Int => "signed integers",
                Component::Uint => "unsigned integers",
            };
            let declared = output.component.map_or("something else than numbers", kind);
            return Err(format!("{file} writes `{name}` as {declared}, and {target} has {}", kind(target_component)));
        }
    }
    Ok(())
}
