//! What the shaders of a folder's method bind, held against its manifest.

use super::inputs;
use super::manifest::{InputKind, LevelOf, Manifest, Pass};
use super::shader::{self, CompiledPass};
use super::source::ImageSource;
use super::values::{Filled, FrameState};
use crate::error::Result;
use crate::gpu::Sampler;
use std::ops::Range;

/// Compiles every shader and holds it against the manifest, without a device.
///
/// # Errors
/// [`Error::Malformed`] with file and line.
pub fn check(manifest: &Manifest) -> Result<()> {
    manifest.passes.iter().try_for_each(|pass| {
        let compiled = shader::compile(&manifest.name, &manifest.include, pass)?;
        PassBindings::new(manifest, pass, &compiled).map(|_| ())
    })
}

/// What a pass's shader binds, in the order of its bindings.
pub struct PassBindings {
    pub inputs: Vec<BoundInput>,
    pub push: Vec<Filled>,
    pub push_size: usize,
}

pub enum BoundInput {
    Sampled(ImageSource, Sampler, LevelOf),
    Stored(String, LevelOf, bool),
    Buffer(String, bool),
    Uniform(Vec<Filled>, usize),
}

impl PassBindings {
    pub fn new(manifest: &Manifest, pass: &Pass, compiled: &CompiledPass) -> Result<Self> {
        let file = pass.shader.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let unfed = |what: &str, name: &str| {
            let message = format!(
                "pass {:?}: nothing feeds the {what} {name} of {file}; name it under [inputs] or [values]",
                pass.name
            );
            manifest.error(&pass.at, message)
        };
        let mut inputs = Vec::new();
        let filled = |block: &str| -> Result<(Vec<Filled>, usize)> {
            let Some(layout) = compiled.interface.blocks.get(block) else {
                return Err(manifest
                    .error(&pass.at, format!("pass {:?}: the block {block} of {file} is not understood", pass.name)));
            };
            let named = |field: &str| {
                let full = format!("{block}.{field}");
                [full.as_str(), field].into_iter().find_map(|name| pass.values.get(name))
            };
            let mut fields = Vec::new();
            for (name, offset, rust, size) in &layout.fields {
                let Some((given, at)) = named(name) else { return Err(unfed("field", &format!("{block}.{name}"))) };
                fields.push(
                    Filled::new(*offset, rust, *size, given.clone()).map_err(|m| {
                        manifest.error(at, format!("pass {:?}: {block}.{name} of {file}: {m}", pass.name))
                    })?,
                );
            }
            Ok((fields, layout.size as usize))
        };
        for b in &compiled.interface.bindings {
            if b.count > 1 {
                let message =
                    format!("pass {:?}: {} of {file} is an array of images, which cannot be fed", pass.name, b.name);
                return Err(manifest.error(&pass.at, message));
            }
            if b.kind == "UniformBuffer" {
                let (fields, size) = filled(&b.block)?;
                inputs.push(BoundInput::Uniform(fields, size));
                continue;
            }
            let kind = if b.kind == "StorageBuffer" { "buffer" } else { "image" };
            let named = [b.name.as_str(), b.block.as_str()].into_iter().find_map(|name| pass.inputs.get(name));
            let Some(input) = named else { return Err(unfed(kind, &b.name)) };
            let mismatch = |what: &str| {
                let message = format!("pass {:?}: {} of {file} is {what}", pass.name, b.name);
                manifest.error(input.at(), message)
            };
            inputs.push(match (b.kind, &input.what) {
                ("StorageBuffer", InputKind::Buffer(buffer)) => BoundInput::Buffer(buffer.clone(), b.read_only),
                ("StorageBuffer", _) => return Err(mismatch("a buffer, and is fed an image")),
                (_, InputKind::Buffer(_)) => return Err(mismatch("an image, and is fed a buffer")),
                ("StorageImage", InputKind::Image(ImageSource::Own(image))) => {
                    let level = if input.level == LevelOf::All { LevelOf::Number(0) } else { input.level };
                    BoundInput::Stored(image.clone(), level, b.read_only)
                }
                ("StorageImage", _) => {
                    return Err(mismatch("stored to, and is fed an image that is not the method's own"));
                }
                (_, InputKind::Image(source)) => {
                    BoundInput::Sampled(source.clone(), inputs::sampler(source, input.sampler), input.level)
                }
            });
        }
        let (push, push_size) = match &compiled.interface.push {
            Some(push) => {
                let (fields, _) = filled(&push.block)?;
                (fields, push.size as usize)
            }
            None => (Vec::new(), 0),
        };
        Ok(Self { inputs, push, push_size })
    }
}

/// Id and bits of the specialization constants that the manifest gives.
pub fn constants(pass: &Pass, compiled: &CompiledPass, state: &FrameState) -> Vec<(u32, u32)> {
    let given = |c: &crate::gpu::glsl::Constant| {
        let (given, _) = pass.values.get(&c.name)?;
        let number = given.numbers(state, 1).first().copied()?;
        Some((
            c.id,
            match c.ty {
                "f32" => (number as f32).to_bits(),
                "i32" => (number as i32) as u32,
                "bool" => u32::from(number != 0.0),
                _ => number as u32,
            },
        ))
    };
    compiled.interface.constants.iter().filter_map(given).collect()
}

/// Names under `[inputs]` and `[values]` that no shader of the method reads.
pub fn unread(manifest: &Manifest, compiled: &[CompiledPass]) -> Result<()> {
    let reads = |pass: usize, name: &str| {
        let interface = &compiled[pass].interface;
        let bound = interface.bindings.iter().any(|b| b.name == name || b.block == name);
        let constant = interface.constants.iter().any(|c| c.name == name);
        let field = |(block, layout): (&String, &crate::gpu::glsl::Block)| {
            layout.fields.iter().any(|(field, ..)| field == name || format!("{block}.{field}") == name)
        };
        bound || constant || interface.blocks.iter().any(field)
    };
    let all = 0..manifest.passes.len();
    let names = |pass: &Pass| -> Vec<(String, Range<usize>)> {
        let inputs = pass.inputs.iter().map(|(name, input)| (name.clone(), input.at().clone()));
        inputs.chain(pass.values.iter().map(|(name, (_, at))| (name.clone(), at.clone()))).collect()
    };
    for pass in &manifest.passes {
        for (name, at) in names(pass) {
            // What stands at the top holds for every pass, and is read if one of them reads it.
            let of =
                all.clone().filter(|k| names(&manifest.passes[*k]).iter().any(|(n, place)| *n == name && *place == at));
            if !of.clone().any(|k| reads(k, &name)) {
                return Err(manifest.error(&at, format!("no shader reads {name}")));
            }
        }
    }
    Ok(())
}
