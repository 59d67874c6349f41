//! The bindings of a folder's shaders, checked against the manifest of the method.

use super::loose_uniforms::LOOSE;
use super::manifest::{InputKind, LevelOf, Manifest, Pass};
use super::published;
use super::reflect::{self, BlockLayout, ShaderInterface, Variable, VariableKind};
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
pub fn check(manifest: &Manifest) -> Result<()> {
    let mut unfed = Vec::new();
    for pass in &manifest.passes {
        let compiled = shader::compile(manifest, pass)?;
        let (_, missing) = PassBindings::read(manifest, pass, &compiled)?;
        unfed.push((pass, missing));
    }
    check_fed(manifest, unfed)
}

/// Refuses shaders with names that nothing feeds. `unfed` has pairs of a pass and such names of its shader. The error
/// is [`Malformed`](ssct_ground::Error::Malformed), and its one sentence lists all of the names.
fn check_fed(manifest: &Manifest, mut unfed: Vec<(&Pass, Vec<String>)>) -> Result<()> {
    unfed.retain(|(_, missing)| !missing.is_empty());
    let Some((first, _)) = unfed.first() else { return Ok(()) };
    let clause = |(pass, missing): &(&Pass, Vec<String>)| {
        format!("pass {:?}: nothing feeds {} of {}", pass.name, missing.join(", "), file_name(pass))
    };
    let clauses: Vec<String> = unfed.iter().map(clause).collect();
    let pronoun = if unfed.iter().map(|(_, missing)| missing.len()).sum::<usize>() == 1 { "it" } else { "them" };
    let message = format!("{}; name {pronoun} under [inputs] or [values]", clauses.join("; "));
    Err(manifest.error(&first.span, message))
}

/// The name of a pass's shader in messages: the name of its file.
fn file_name(pass: &Pass) -> String {
    pass.shader.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Checks that a method for orthographic cameras is fed nothing that only a perspective has.
pub fn check_projection(manifest: &Manifest, projection: ProjectionKind) -> Result<()> {
    let is_angle = |feed: &Feed| feed.is_named("fov-y") || feed.is_named("half-view");
    let needs_perspective = |pass: &Pass| {
        let mut values = pass.values.values().map(|(feed, _)| feed);
        let mut images = pass.inputs.values().map(|input| &input.what);
        values.any(is_angle) || images.any(|what| *what == InputKind::Image(ImageSource::Visibility))
    };
    match manifest.passes.iter().find(|pass| needs_perspective(pass)) {
        Some(pass) if projection.is_orthographic() => Err(Error::Usage(format!(
            "the method {}: its pass {:?} is fed fov-y, half-view or visibility, which only a perspective has, and the \
             camera is orthographic; view-to-clip is a matrix of either",
            manifest.name, pass.name
        ))),
        _ => Ok(()),
    }
}

/// The inputs that a pass's shader binds, and its push constants.
pub struct PassBindings {
    /// The inputs in the order of their bindings.
    pub inputs: Vec<BoundInput>,
    /// The fields of the push constants.
    pub push: Vec<FilledField>,
    /// The size of the push constants in bytes.
    pub push_size: usize,
}

/// The image, the buffer or the values for one binding.
pub enum BoundInput {
    /// A sampled image.
    Sampled { source: ImageSource, sampler: Sampler, level: LevelOf },
    /// A storage image of the method's own.
    Stored { name: String, level: LevelOf, read_only: bool },
    /// A buffer, which must have at least `bytes` bytes.
    Buffer { name: String, read_only: bool, bytes: u32 },
    /// A uniform block of `bytes` bytes.
    Uniform { fields: Vec<FilledField>, bytes: usize },
}

impl PassBindings {
    /// Checks a pass's shader against the manifest.
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
            inputs.extend(shader.bind(variable)?);
        }
        let (push, push_size) = match &compiled.interface.push {
            Some((block, layout)) => (shader.fill(block, layout)?, layout.size as usize),
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
    /// Makes an error about this pass, at a place of the manifest.
    fn wrong(&self, span: &Range<usize>, message: &str) -> Error {
        self.manifest.error(span, format!("pass {:?}: {message}", self.pass.name))
    }

    /// Makes the error about a variable without a name that nothing feeds; `name` consists of its set and binding.
    fn nameless_unfed_error(&self, name: &str) -> Error {
        let file = &self.file;
        let message = format!(
            "nothing feeds {name:?} of {file}: {}; say what it is under [inputs], as in {name:?} = \"depth:reversed\"",
            reflect::explain_nameless(name)
        );
        self.wrong(&self.pass.span, &message)
    }

    /// Adds a name of the shader to the list of names that nothing feeds.
    fn note_unfed(&self, what: String) {
        self.missing.borrow_mut().push(what);
    }

    /// Returns the fields of a block with the values that fill them. Fields that the shader does not read need no
    /// value, and loose uniforms may have initial values of their own.
    fn fill(&self, block: &str, layout: &BlockLayout) -> Result<Vec<FilledField>> {
        let mut fields = Vec::new();
        for field in &layout.fields {
            let full_name = format!("{block}.{}", field.name);
            let given =
                [full_name.as_str(), field.name.as_str()].into_iter().find_map(|name| self.pass.values.get(name));
            let initial =
                self.compiled.initial_values.iter().find(|(name, _)| *name == field.name && block.starts_with(LOOSE));
            let (feed, span) = match (given, initial) {
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
                    self.note_unfed(format!("the field {full_name}{hint}"));
                    continue;
                }
            };
            let filled = FilledField::new(field, feed);
            fields.push(filled.map_err(|m| self.wrong(span, &format!("{full_name} of {}: {m}", self.file)))?);
        }
        Ok(fields)
    }

    /// Returns the input that feeds a variable, by the name of the variable or of its block. `None` if nothing feeds
    /// it, and then its name is added to the list of such names.
    fn bind(&self, variable: &Variable) -> Result<Option<BoundInput>> {
        let Variable { name: variable_name, block, kind, read_only, .. } = variable;
        if variable.count > 1 {
            let file = &self.file;
            let message = format!("{variable_name} of {file} is an array of images or blocks, which cannot be fed");
            return Err(self.wrong(&self.pass.span, &message));
        }
        if let VariableKind::Uniform(layout) = kind {
            return Ok(Some(BoundInput::Uniform { fields: self.fill(block, layout)?, bytes: layout.size as usize }));
        }
        let Some(input) = [variable_name, block].into_iter().find_map(|name| self.pass.inputs.get(name)) else {
            if variable.is_nameless {
                return Err(self.nameless_unfed_error(variable_name));
            }
            let kind_word = if matches!(kind, VariableKind::Storage(_)) { "buffer" } else { "image" };
            self.note_unfed(format!("the {kind_word} {variable_name}"));
            return Ok(None);
        };
        let mismatch = |what: String| self.wrong(input.span(), &format!("{variable_name} of {} is {what}", self.file));
        let images = &self.manifest.images;
        Ok(Some(match (kind, &input.what) {
            (VariableKind::Storage(bytes), InputKind::Buffer(name)) => {
                BoundInput::Buffer { name: name.clone(), read_only: *read_only, bytes: *bytes }
            }
            (VariableKind::Storage(_), _) => return Err(mismatch("a buffer, and is fed an image".to_owned())),
            (_, InputKind::Buffer(_)) => return Err(mismatch("an image, and is fed a buffer".to_owned())),
            (VariableKind::Stored(kind), InputKind::Image(ImageSource::Own(name))) => {
                kinds::check_stored(kind, name, images).map_err(mismatch)?;
                let level = if input.level == LevelOf::All { LevelOf::Number(0) } else { input.level };
                BoundInput::Stored { name: name.clone(), level, read_only: *read_only }
            }
            (VariableKind::Sampled(kind), InputKind::Image(source)) => {
                kinds::check_sampled(kind, source, images).map_err(mismatch)?;
                let sampler = inputs::sampler(source, input.sampler);
                BoundInput::Sampled { source: source.clone(), sampler, level: input.level }
            }
            (_, InputKind::Image(_)) => {
                return Err(mismatch("stored to, and is fed an image that is not the method's own".to_owned()));
            }
        }))
    }
}

/// Returns the specialization constants to which the manifest gives values, as pairs of an id and the bits of the
/// value.
pub fn constants(pass: &Pass, compiled: &CompiledPass, state: &FrameState) -> Vec<(u32, u32)> {
    let id_and_bits = |c: &ssct::gpu::interface::Constant| {
        let (feed, _) = pass.values.get(&c.name)?;
        let number = feed.numbers(state, 1).first().copied()?;
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
    compiled.interface.constants.iter().filter_map(id_and_bits).collect()
}

/// True if a shader has a variable, a block, a constant or a field of this name; a field may be named with its block.
fn has_name(interface: &ShaderInterface, name: &str) -> bool {
    let has_field = |block: &str, layout: &BlockLayout| {
        layout.fields.iter().any(|field| field.name == name || format!("{block}.{}", field.name) == name)
    };
    let is_variable_named = |v: &Variable| {
        v.name == name
            || v.block == name
            || matches!(&v.kind, VariableKind::Uniform(layout) if has_field(&v.block, layout))
    };
    interface.variables.iter().any(is_variable_named)
        || interface.constants.iter().any(|c| c.name == name)
        || interface.push.as_ref().is_some_and(|(block, layout)| has_field(block, layout))
}

/// Refuses names under `[inputs]` and `[values]` that no shader of the method reads.
pub fn check_all_read(manifest: &Manifest, compiled: &[CompiledPass]) -> Result<()> {
    // The names of a pass's inputs and values, each with its place in the manifest.
    let names = |pass: &Pass| -> Vec<(String, Range<usize>)> {
        let inputs = pass.inputs.iter().map(|(name, input)| (name.clone(), input.span().clone()));
        inputs.chain(pass.values.iter().map(|(name, (_, span))| (name.clone(), span.clone()))).collect()
    };
    for pass in &manifest.passes {
        for entry in names(pass) {
            // A name at the top of the manifest is given to every pass, of which at least one must read it.
            let mut passes = manifest.passes.iter().zip(compiled).filter(|(pass, _)| names(pass).contains(&entry));
            let (name, span) = &entry;
            if !passes.any(|(_, compiled)| has_name(&compiled.interface, name)) {
                return Err(manifest.error(span, format!("no shader reads {name}")));
            }
        }
    }
    Ok(())
}
