//! The bindings of a folder's shaders, checked against the manifest of the method.

use super::loose_uniforms::LOOSE;
use super::manifest::{InputKind, LevelOf, Manifest, Pass};
use super::published;
use super::reflect::{self, BlockLayout, Variable, VariableKind};
use super::shader::{self, CompiledPass};
use super::source::ImageSource;
use super::values::{Feed, FilledField, FrameState};
use super::{inputs, kinds};
use ssct::gpu::Sampler;
use ssct_ground::{Error, Result};
use ssct_scenes::ProjectionKind;
use std::cell::RefCell;
use std::ops::Range;

/// Compiles every shader and checks it against the manifest, without a device.
///
/// # Errors
/// [`Malformed`](ssct_ground::Error::Malformed) with file and line.
pub fn check(manifest: &Manifest) -> Result<()> {
    let mut unfed = Vec::new();
    for pass in &manifest.passes {
        let compiled = shader::compile(manifest, pass)?;
        unfed.push((pass, PassBindings::read(manifest, pass, &compiled)?.1));
    }
    check_fed(manifest, unfed)
}

/// Refuses shaders with names that nothing feeds; `unfed` has each pass with these names of its shader. The error is
/// [`Malformed`](ssct_ground::Error::Malformed), and its one sentence lists all of the names.
fn check_fed(manifest: &Manifest, mut unfed: Vec<(&Pass, Vec<String>)>) -> Result<()> {
    unfed.retain(|(_, missing)| !missing.is_empty());
    let Some((first, _)) = unfed.first() else { return Ok(()) };
    let clause = |(pass, missing): &(&Pass, Vec<String>)| {
        format!("pass {:?}: nothing feeds {} of {}", pass.name, missing.join(", "), file_name(pass))
    };
    let clauses: Vec<String> = unfed.iter().map(clause).collect();
    let them = if unfed.iter().map(|(_, missing)| missing.len()).sum::<usize>() == 1 { "it" } else { "them" };
    let message = format!("{}; name {them} under [inputs] or [values]", clauses.join("; "));
    Err(manifest.error(&first.span, message))
}

/// The name by which messages call the shader of a pass.
fn file_name(pass: &Pass) -> String {
    pass.shader.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Checks that a method for orthographic cameras is fed nothing that only a perspective has.
///
/// # Errors
/// [`Usage`](ssct_ground::Error::Usage) for a value or an image that only a perspective has.
pub fn check_projection(manifest: &Manifest, projection: ProjectionKind) -> Result<()> {
    let is_angle = |given: &Feed| given.is_named("fov-y") || given.is_named("half-view");
    let is_of_perspective = |pass: &Pass| {
        let mut values = pass.values.values().map(|(given, _)| given);
        let mut images = pass.inputs.values().map(|input| &input.what);
        values.any(is_angle) || images.any(|what| *what == InputKind::Image(ImageSource::Visibility))
    };
    match manifest.passes.iter().find(|pass| is_of_perspective(pass)) {
        Some(pass) if projection.is_orthographic() => Err(Error::Usage(format!(
            "the method {}: its pass {:?} is fed fov-y, half-view or visibility, which only a perspective has, and the \
             camera is orthographic; view-to-clip is a matrix of either",
            manifest.name, pass.name
        ))),
        _ => Ok(()),
    }
}

/// The inputs that a pass's shader binds, in the order of its bindings, and its push constants.
pub struct PassBindings {
    pub inputs: Vec<BoundInput>,
    pub push: Vec<FilledField>,
    pub push_size: usize,
}

pub enum BoundInput {
    Sampled(ImageSource, Sampler, LevelOf),
    /// The image's name, its level, and whether the shader only reads the image.
    Stored(String, LevelOf, bool),
    /// The buffer's name, whether the shader only reads the buffer, and the bytes that the buffer must have.
    Buffer(String, bool, u32),
    /// The fields of a block, and the size of the block in bytes.
    Uniform(Vec<FilledField>, usize),
}

impl PassBindings {
    /// Checks a pass's shader against the manifest.
    ///
    /// # Errors
    /// [`Malformed`](ssct_ground::Error::Malformed) with the line of the manifest.
    pub fn new(manifest: &Manifest, pass: &Pass, compiled: &CompiledPass) -> Result<Self> {
        let (bindings, missing) = Self::read(manifest, pass, compiled)?;
        check_fed(manifest, vec![(pass, missing)])?;
        Ok(bindings)
    }

    /// Returns the bindings of a pass's shader, and every name in the shader that nothing feeds.
    fn read(manifest: &Manifest, pass: &Pass, compiled: &CompiledPass) -> Result<(Self, Vec<String>)> {
        let shader = PassShader { manifest, pass, compiled, file: file_name(pass), missing: RefCell::default() };
        kinds::check_stage(manifest, pass, &compiled.interface, &shader.file)
            .map_err(|m| shader.wrong(&pass.span, &m))?;
        let mut inputs = Vec::new();
        for variable in &compiled.interface.variables {
            inputs.extend(shader.bound(variable)?);
        }
        let (push, push_size) = match &compiled.interface.push {
            Some((block, layout)) => (shader.filled(block, layout)?, layout.size as usize),
            None => (Vec::new(), 0),
        };
        Ok((Self { inputs, push, push_size }, shader.missing.into_inner()))
    }
}

/// A pass's shader, with the manifest that the shader is checked against.
struct PassShader<'a> {
    manifest: &'a Manifest,
    pass: &'a Pass,
    compiled: &'a CompiledPass,
    /// The shader's name in messages.
    file: String,
    /// Names of the shader that nothing feeds.
    missing: RefCell<Vec<String>>,
}

impl PassShader<'_> {
    /// An error about this pass, at a place of the manifest.
    fn wrong(&self, span: &Range<usize>, message: &str) -> Error {
        self.manifest.error(span, format!("pass {:?}: {message}", self.pass.name))
    }

    /// The error about a variable of the shader that has no name and that nothing feeds.
    fn nameless_unfed_error(&self, name: &str) -> Error {
        let file = &self.file;
        let message = format!(
            "nothing feeds {name:?} of {file}: {}; say what it is under [inputs], as in {name:?} = \"depth:reversed\"",
            reflect::nameless(name)
        );
        self.wrong(&self.pass.span, &message)
    }

    /// Adds a name of the shader to the list of names that nothing feeds.
    fn note_unfed(&self, what: String) {
        self.missing.borrow_mut().push(what);
    }

    /// The values that fill a block. Fields that the shader does not read need no value, and loose uniforms may have initial values of
    /// their own.
    fn filled(&self, block: &str, layout: &BlockLayout) -> Result<Vec<FilledField>> {
        let mut fields = Vec::new();
        for field in &layout.fields {
            let full = format!("{block}.{}", field.name);
            let given = [full.as_str(), field.name.as_str()].into_iter().find_map(|name| self.pass.values.get(name));
            let own = self.compiled.own.iter().find(|(name, _)| *name == field.name && block.starts_with(LOOSE));
            let (feed, span) = match (given, own) {
                (Some((feed, span)), _) => (feed.clone(), span),
                (None, Some((_, Some(numbers)))) => (Feed::Numbers(numbers.clone()), &self.pass.span),
                (None, _) if !field.is_read => continue,
                (None, Some((name, None))) => {
                    let message = format!(
                        "the value that {name} of {} has of its own is more than numbers; give it under [values]",
                        self.file
                    );
                    return Err(self.wrong(&self.pass.span, &message));
                }
                (None, None) => {
                    let hint = published::hint(block, &field.name).map_or(String::new(), |hint| format!(" ({hint})"));
                    self.note_unfed(format!("the field {full}{hint}"));
                    continue;
                }
            };
            let filled = FilledField::new(field, feed);
            fields.push(filled.map_err(|m| self.wrong(span, &format!("{full} of {}: {m}", self.file)))?);
        }
        Ok(fields)
    }

    /// The input that feeds a variable; `None` if nothing feeds it.
    fn bound(&self, v: &Variable) -> Result<Option<BoundInput>> {
        if v.count > 1 {
            let message = format!("{} of {} is an array of images or blocks, which cannot be fed", v.name, self.file);
            return Err(self.wrong(&self.pass.span, &message));
        }
        if let VariableKind::Uniform(layout) = &v.kind {
            return Ok(Some(BoundInput::Uniform(self.filled(&v.block, layout)?, layout.size as usize)));
        }
        let named = [v.name.as_str(), v.block.as_str()].into_iter().find_map(|name| self.pass.inputs.get(name));
        let kind = if matches!(v.kind, VariableKind::Storage(_)) { "buffer" } else { "image" };
        let Some(input) = named else {
            if v.is_nameless {
                return Err(self.nameless_unfed_error(&v.name));
            }
            self.note_unfed(format!("the {kind} {}", v.name));
            return Ok(None);
        };
        let is = |what: String| self.wrong(input.span(), &format!("{} of {} is {what}", v.name, self.file));
        let images = &self.manifest.images;
        Ok(Some(match (&v.kind, &input.what) {
            (VariableKind::Storage(bytes), InputKind::Buffer(buffer)) => {
                BoundInput::Buffer(buffer.clone(), v.read_only, *bytes)
            }
            (VariableKind::Storage(_), _) => return Err(is("a buffer, and is fed an image".to_owned())),
            (_, InputKind::Buffer(_)) => return Err(is("an image, and is fed a buffer".to_owned())),
            (VariableKind::Stored(kind), InputKind::Image(ImageSource::Own(image))) => {
                kinds::check_stored(kind, image, images).map_err(is)?;
                let level = if input.level == LevelOf::All { LevelOf::Number(0) } else { input.level };
                BoundInput::Stored(image.clone(), level, v.read_only)
            }
            (VariableKind::Sampled(kind), InputKind::Image(source)) => {
                kinds::check_sampled(kind, source, images).map_err(is)?;
                BoundInput::Sampled(source.clone(), inputs::sampler(source, input.sampler), input.level)
            }
            (_, InputKind::Image(_)) => {
                return Err(is("stored to, and is fed an image that is not the method's own".to_owned()));
            }
        }))
    }
}

/// The specialization constants that the manifest gives, each as its id and the bits of its value.
pub fn constants(pass: &Pass, compiled: &CompiledPass, state: &FrameState) -> Vec<(u32, u32)> {
    let given = |c: &ssct::gpu::interface::Constant| {
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

/// Refuses names under `[inputs]` and `[values]` that no shader of the method reads.
pub fn check_all_read(manifest: &Manifest, compiled: &[CompiledPass]) -> Result<()> {
    let reads = |pass: usize, name: &str| {
        let interface = &compiled[pass].interface;
        let bound = interface.variables.iter().any(|v| v.name == name || v.block == name);
        let constant = interface.constants.iter().any(|c| c.name == name);
        let has_field = |block: &str, layout: &BlockLayout| {
            layout.fields.iter().any(|field| field.name == name || format!("{block}.{}", field.name) == name)
        };
        let in_block = interface.variables.iter().any(|v| match &v.kind {
            VariableKind::Uniform(layout) => has_field(&v.block, layout),
            _ => false,
        });
        let in_push = interface.push.as_ref().is_some_and(|(block, layout)| has_field(block, layout));
        bound || constant || in_block || in_push
    };
    let all = 0..manifest.passes.len();
    let names = |pass: &Pass| -> Vec<(String, Range<usize>)> {
        let inputs = pass.inputs.iter().map(|(name, input)| (name.clone(), input.span().clone()));
        inputs.chain(pass.values.iter().map(|(name, (_, span))| (name.clone(), span.clone()))).collect()
    };
    for pass in &manifest.passes {
        for (name, span) in names(pass) {
            // A name at the top of the manifest holds for every pass, and one pass that reads it is enough.
            let passes = all
                .clone()
                .filter(|k| names(&manifest.passes[*k]).iter().any(|(n, place)| *n == name && *place == span));
            if !passes.clone().any(|k| reads(k, &name)) {
                return Err(manifest.error(&span, format!("no shader reads {name}")));
            }
        }
    }
    Ok(())
}
