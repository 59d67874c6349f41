//! A method from a folder, at one size on one device.

use super::MANIFEST;
use super::inputs::{self, Inputs};
use super::manifest::{
    Alpha, HitEncoding, ImageSection, InputKind, LevelOf, Manifest, Pass, PassReach, PassStage, format_of,
};
use super::shader::{self, CompiledPass};
use super::source::ImageSource;
use super::values::{Filled, FrameState};
use crate::error::{Error, Result};
use crate::gpu::loose::{LooseProgram, Reach};
use crate::gpu::memory::{Buffer, MemoryPlace};
use crate::gpu::program::Sampled;
use crate::gpu::programs::{CustomHits, CustomReflection};
use crate::gpu::shader::{CustomHitsBlock, CustomOutputBlock};
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, ImageDesc, ImageSlice, Resource, Sampler, Target, image};
use crate::math::constants::{
    ALPHA_FADE, ALPHA_NONE, ALPHA_PREMULTIPLIED, HITS_PIXEL, HITS_UV, HITS_UV_DEPTH, HITS_UV_MASKED, HITS_VIEW,
};
use crate::methods::{Input, Intermediate, Making, Method, Setup, Traced};
use crate::parameter::{Parameter, Values};
use crate::passes::hi_z::HiZPass;
use crate::passes::{Content, HITS, Hits, LIT_COLOR, Reflection};
use crate::scene::Camera;
use ash::vk;
use glam::Vec3;
use std::cell::{Cell, OnceCell, RefCell};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;
use std::time::{Duration, Instant, SystemTime};

/// How often files are looked at, where they are.
const PERIOD: Duration = Duration::from_millis(300);

/// Compiles every shader and holds it against the manifest, without a device.
///
/// # Errors
/// [`Error::Malformed`] with file and line.
pub fn check(manifest: &Manifest) -> Result<()> {
    manifest.passes.iter().try_for_each(|pass| {
        let compiled = shader::compile(&manifest.name, &manifest.include, pass)?;
        Plan::new(manifest, pass, &compiled).map(|_| ())
    })
}

/// The method, as its files were when it was made, and as they were each time they changed since.
pub struct CustomMethod {
    first: Version,
    reload: Option<Reload>,
}

/// One version of the files, and the one after it.
struct Version {
    running: Running,
    next: OnceCell<Box<Version>>,
}

/// What makes the method anew when its files change.
struct Reload {
    gpu: Gpu,
    folder: PathBuf,
    setup: Setup,
    hits: bool,
    looked: Cell<Instant>,
    seen: RefCell<Vec<Option<SystemTime>>>,
}

impl CustomMethod {
    /// At a setup. `watched`, it is made anew when its files change.
    pub fn new(
        gpu: &Gpu,
        manifest: &Manifest,
        parameters: &[Parameter],
        making: &Making,
        watched: bool,
    ) -> Result<Self> {
        let running = Running::new(gpu, manifest, parameters, &making.setup, making.hits)?;
        let reload = watched.then(|| Reload {
            gpu: gpu.clone(),
            folder: manifest.folder.clone(),
            setup: making.setup.clone(),
            hits: making.hits,
            looked: Cell::new(Instant::now()),
            seen: RefCell::new(stamps(&running.files)),
        });
        Ok(Self { first: Version { running, next: OnceCell::new() }, reload })
    }

    fn last(&self) -> &Version {
        let mut version = &self.first;
        while let Some(next) = version.next.get() {
            version = next;
        }
        version
    }
}

impl Method for CustomMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<Traced<'a>> {
        if let Some(reload) = &self.reload {
            let last = self.last();
            if let Some(running) = reload.changed(&last.running) {
                let _ = last.next.set(Box::new(Version { running, next: OnceCell::new() }));
            }
        }
        self.last().running.record(frame, input)
    }
}

impl Reload {
    /// The method anew, if its files changed since they were last looked at and it can be made of them. Parameters stay as
    /// they were declared.
    fn changed(&self, now: &Running) -> Option<Running> {
        if self.looked.get().elapsed() < PERIOD {
            return None;
        }
        self.looked.set(Instant::now());
        let seen = stamps(&now.files);
        if *self.seen.borrow() == seen {
            return None;
        }
        *self.seen.borrow_mut() = seen;
        let made = Manifest::read(&self.folder)
            .and_then(|manifest| Running::new(&self.gpu, &manifest, &now.parameters, &self.setup, self.hits));
        match made {
            Ok(running) => {
                *self.seen.borrow_mut() = stamps(&running.files);
                Some(running)
            }
            Err(error) => {
                tracing::warn!("{error}; the method stays as it was");
                None
            }
        }
    }
}

/// When each file was last written.
fn stamps(files: &[PathBuf]) -> Vec<Option<SystemTime>> {
    files.iter().map(|file| std::fs::metadata(file).and_then(|m| m.modified()).ok()).collect()
}

/// Pipelines and images of one version of the files.
struct Running {
    passes: Vec<Recorded>,
    inputs: Inputs,
    images: BTreeMap<String, OwnImage>,
    buffers: BTreeMap<String, (Buffer, Option<u32>)>,
    output: Finish,
    manifest: Manifest,
    parameters: Vec<Parameter>,
    values: Values,
    fade: bool,
    hits: bool,
    files: Vec<PathBuf>,
    /// Names of the images, in their order.
    names: Vec<&'static str>,
    /// Frames since the first, and what the last one was seen from.
    frames: Cell<u32>,
    before: Cell<Option<Camera>>,
}

/// An image of the method's own: one, or two that take turns.
struct OwnImage {
    images: Vec<Image>,
    clear: bool,
}

/// A pass with its pipeline.
struct Recorded {
    pass: Pass,
    program: LooseProgram,
    plan: Plan,
}

/// What a pass's shader binds, in the order of its bindings.
struct Plan {
    bound: Vec<Bound>,
    push: Vec<Filled>,
    push_size: usize,
}

enum Bound {
    Sampled(ImageSource, Sampler, LevelOf),
    Stored(String, LevelOf, bool),
    Buffer(String, bool),
    Uniform(Vec<Filled>, usize),
}

/// What makes a reflection of what the method made, and hits, if they are wanted.
struct Finish {
    reflection: Option<(GraphicsPipeline<CustomReflection<'static>>, Image, i32)>,
    hits: Option<(HiZPass, GraphicsPipeline<CustomHits<'static>>, Image, i32)>,
}

impl Plan {
    fn new(manifest: &Manifest, pass: &Pass, compiled: &CompiledPass) -> Result<Self> {
        let file = pass.shader.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let unfed = |what: &str, name: &str| {
            let message = format!(
                "pass {:?}: nothing feeds the {what} {name} of {file}; name it under [inputs] or [values]",
                pass.name
            );
            manifest.error(&pass.at, message)
        };
        let mut read: Vec<&str> = Vec::new();
        let mut bound = Vec::new();
        let mut filled = |block: &str| -> Result<(Vec<Filled>, usize)> {
            let Some(layout) = compiled.interface.blocks.get(block) else {
                return Err(manifest
                    .error(&pass.at, format!("pass {:?}: the block {block} of {file} is not understood", pass.name)));
            };
            let mut named = |field: &str| {
                let full = format!("{block}.{field}");
                let key = [full.as_str(), field].into_iter().find_map(|name| pass.values.get_key_value(name));
                key.map(|(name, (given, _))| {
                    read.push(name);
                    given
                })
            };
            let mut fields = Vec::new();
            for (name, offset, rust, size) in &layout.fields {
                let Some(given) = named(name) else { return Err(unfed("field", &format!("{block}.{name}"))) };
                let at = pass.values.get(name).map_or(pass.at.clone(), |(_, at)| at.clone());
                fields.push(Filled::new(*offset, rust, *size, given.clone()).map_err(|m| {
                    manifest.error(&at, format!("pass {:?}: {block}.{name} of {file}: {m}", pass.name))
                })?);
            }
            Ok((fields, layout.size as usize))
        };
        let mut inputs_read: Vec<&str> = Vec::new();
        for b in &compiled.interface.bindings {
            if b.count > 1 {
                let message =
                    format!("pass {:?}: {} of {file} is an array of images, which cannot be fed", pass.name, b.name);
                return Err(manifest.error(&pass.at, message));
            }
            if b.kind == "UniformBuffer" {
                let (fields, size) = filled(&b.block)?;
                bound.push(Bound::Uniform(fields, size));
                continue;
            }
            let kind = if b.kind == "StorageBuffer" { "buffer" } else { "image" };
            let key = [b.name.as_str(), b.block.as_str()].into_iter().find_map(|name| pass.inputs.get_key_value(name));
            let Some((name, input)) = key else { return Err(unfed(kind, &b.name)) };
            inputs_read.push(name);
            let mismatch = |what: &str| {
                let message = format!("pass {:?}: {} of {file} is {what}", pass.name, b.name);
                manifest.error(input.at(), message)
            };
            bound.push(match (b.kind, &input.what) {
                ("StorageBuffer", InputKind::Buffer(buffer)) => Bound::Buffer(buffer.clone(), b.read_only),
                ("StorageBuffer", _) => return Err(mismatch("a buffer, and is fed an image")),
                (_, InputKind::Buffer(_)) => return Err(mismatch("an image, and is fed a buffer")),
                ("StorageImage", InputKind::Image(ImageSource::Own(image))) => {
                    let level = if input.level == LevelOf::All { LevelOf::Number(0) } else { input.level };
                    Bound::Stored(image.clone(), level, b.read_only)
                }
                ("StorageImage", _) => {
                    return Err(mismatch("stored to, and is fed an image that is not the method's own"));
                }
                (_, InputKind::Image(source)) => {
                    Bound::Sampled(source.clone(), inputs::sampler(source, input.sampler), input.level)
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
        Ok(Self { bound, push, push_size })
    }
}

/// Id and bits of the specialization constants that the manifest gives.
fn constants(pass: &Pass, compiled: &CompiledPass, state: &FrameState) -> Vec<(u32, u32)> {
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
fn unread(manifest: &Manifest, compiled: &[CompiledPass]) -> Result<()> {
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

impl Running {
    fn new(gpu: &Gpu, manifest: &Manifest, parameters: &[Parameter], setup: &Setup, hits: bool) -> Result<Self> {
        let extent = setup.extent;
        let effect = setup.effect();
        let mut images = BTreeMap::new();
        for (name, section) in &manifest.images {
            images.insert(name.clone(), OwnImage::new(gpu, name, section, extent)?);
        }
        let mut buffers = BTreeMap::new();
        for (name, section) in &manifest.buffers {
            use vk::BufferUsageFlags as U;
            let pixels = f64::from(extent[0]) * f64::from(extent[1]);
            let bytes = section.bytes + (section.bytes_per_pixel * pixels).ceil() as u64;
            let usage = U::STORAGE_BUFFER | U::INDIRECT_BUFFER | U::TRANSFER_DST;
            let bytes = bytes.next_multiple_of(4).max(16);
            buffers.insert(name.clone(), (Buffer::new(gpu, name, bytes, usage, MemoryPlace::Device)?, section.fill));
        }
        let camera = Camera::new(Vec3::ZERO, Vec3::Z, Default::default(), 1.0);
        let still = FrameState {
            camera: &camera,
            before: &camera,
            extent,
            pass_extent: extent,
            level: 0,
            frame: 0,
            is_first: true,
            roughness: 1.0,
            fade: effect.fade,
            hits,
            captures: &[],
            conventions: manifest.conventions,
            values: &setup.values,
            parameters,
        };
        let mut compiled = Vec::new();
        let mut passes = Vec::new();
        for pass in &manifest.passes {
            let made = shader::compile(&manifest.name, &manifest.include, pass)?;
            let plan = Plan::new(manifest, pass, &made)?;
            let constants = constants(pass, &made, &still);
            let program = match pass.stage {
                PassStage::Compute => LooseProgram::compute(gpu, made.shader, &constants)?,
                PassStage::Fragment => {
                    let format = |(name, _): &(String, LevelOf)| match is_unwanted(manifest, name, hits) {
                        true => vk::Format::UNDEFINED,
                        false => images[name].images[0].format(),
                    };
                    let formats: Vec<_> = pass.targets.iter().map(format).collect();
                    let outputs = made.interface.outputs.len();
                    if outputs != formats.len() {
                        let message = format!(
                            "pass {:?}: the shader writes {outputs} colours, and the pass has {} targets",
                            pass.name,
                            formats.len()
                        );
                        return Err(manifest.error(&pass.at, message));
                    }
                    LooseProgram::fragment(gpu, made.shader, &constants, &formats)?
                }
            };
            passes.push(Recorded { pass: pass.clone(), program, plan });
            compiled.push(made);
        }
        unread(manifest, &compiled)?;
        let mut sources: Vec<ImageSource> = Vec::new();
        for bound in passes.iter().flat_map(|p| &p.plan.bound) {
            if let Bound::Sampled(source, ..) = bound {
                sources.push(source.clone());
            }
        }
        Ok(Self {
            inputs: Inputs::new(gpu, extent, &sources, manifest.conventions)?,
            output: Finish::new(gpu, manifest, extent, hits)?,
            passes,
            images,
            buffers,
            manifest: manifest.clone(),
            parameters: parameters.to_vec(),
            values: setup.values.clone(),
            fade: effect.fade,
            hits,
            files: std::iter::once(manifest.folder.join(MANIFEST))
                .chain(compiled.into_iter().flat_map(|c| c.files))
                .collect(),
            names: manifest.images.keys().map(|name| name.clone().leak() as &'static str).collect(),
            frames: Cell::new(0),
            before: Cell::new(None),
        })
    }

    /// The image of a method's own in a frame of this turn.
    fn own(&self, name: &str, turn: usize) -> &Image {
        let images = &self.images[name].images;
        &images[turn % images.len()]
    }

    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<Traced<'a>> {
        let before = self.before.replace(Some(*input.camera));
        let number = self.frames.replace(self.frames.get().wrapping_add(1));
        let turn = number as usize % 2;
        let extent = input.gbuffer.depth.extent();
        if before.is_none() {
            self.inputs.begin(frame)?;
        }
        for (name, image) in &self.images {
            let fresh = before.is_none() && image.images.len() > 1;
            for (k, held) in image.images.iter().enumerate() {
                if fresh || (image.clear && k == turn % image.images.len()) {
                    frame.clear(&format!("clear {name}"), held.all(), [0.0; 4])?;
                }
            }
        }
        for (name, (buffer, fill)) in &self.buffers {
            if let Some(word) = fill {
                frame.fill(&format!("fill {name}"), buffer, *word)?;
            }
        }
        let earlier = before.unwrap_or(*input.camera);
        self.inputs.record(frame, input, &earlier)?;
        let places: Vec<Vec3> = input.captures.map_or(Vec::new(), |c| c.places.iter().map(Cell::get).collect());
        let roughness = input.scene.map_or(1.0, |s| s.materials.iter().map(|m| m.roughness).fold(0.0, f32::max));
        let state = |pass_extent: [u32; 2], level: u32| FrameState {
            camera: input.camera,
            before: &earlier,
            extent,
            pass_extent,
            level,
            frame: number,
            is_first: before.is_none(),
            roughness,
            fade: self.fade,
            hits: self.hits,
            captures: &places,
            conventions: self.manifest.conventions,
            values: &self.values,
            parameters: &self.parameters,
        };
        for recorded in &self.passes {
            let [first, last] = recorded.pass.levels.unwrap_or([0, 0]);
            for level in first..=last {
                if !self.record_level(frame, input, recorded, (level, turn), &state)? {
                    break;
                }
            }
        }
        self.inputs.keep(frame, input, turn)?;
        self.finish(frame, input, turn, &state(extent, 0))
    }

    /// Records a pass for a level; whether the images have it.
    fn record_level<'a, 's>(
        &'a self,
        frame: &mut Frame,
        input: &Input<'a, '_>,
        Recorded { pass, program, plan }: &'a Recorded,
        (level, turn): (u32, usize),
        state: &impl Fn([u32; 2], u32) -> FrameState<'s>,
    ) -> Result<bool> {
        let slice = |name: &str, of: LevelOf, turn: usize| -> Option<ImageSlice<'a>> {
            let image = self.own(name, turn);
            let number = match of {
                LevelOf::All => return Some(image.all()),
                LevelOf::Number(n) => n,
                LevelOf::Current(less) => level.checked_sub(less)?,
            };
            (number < image.levels()).then(|| image.level(number))
        };
        let mut targets = Vec::new();
        for (name, of) in &pass.targets {
            let Some(slice) = slice(name, *of, turn) else { return self.has_no_level(pass, name) };
            targets.push(slice);
        }
        let (pass_extent, reach) = match &pass.reach {
            PassReach::Targets => (targets[0].extent(), None),
            PassReach::Threads(name, of) => {
                let Some(slice) = slice(name, *of, turn) else { return self.has_no_level(pass, name) };
                let [width, height] = slice.extent();
                ([width, height], Some(Reach::Threads([width, height, 1])))
            }
            PassReach::Workgroups(groups) => (input.gbuffer.depth.extent(), Some(Reach::Workgroups(*groups))),
            PassReach::Indirect(name) => (input.gbuffer.depth.extent(), Some(Reach::Said(&self.buffers[name].0))),
        };
        if let Some(other) = targets.iter().find(|t| t.extent() != pass_extent) {
            let message =
                format!("pass {:?}: its targets are {pass_extent:?} and {:?} pixels large", pass.name, other.extent());
            return Err(self.manifest.error(&pass.at, message));
        }
        let state = state(pass_extent, level);
        let block = |fields: &[Filled], size: usize| {
            let mut bytes = vec![0; size];
            fields.iter().for_each(|f| f.write(&mut bytes, &state));
            bytes
        };
        let blocks: Vec<Vec<u8>> = plan
            .bound
            .iter()
            .map(|b| if let Bound::Uniform(fields, size) = b { block(fields, *size) } else { Vec::new() })
            .collect();
        let mut resources = Vec::with_capacity(plan.bound.len());
        for (bound, bytes) in plan.bound.iter().zip(&blocks) {
            resources.push(match bound {
                Bound::Uniform(..) => Resource::Uniform(bytes),
                Bound::Buffer(name, true) => Resource::ReadBuffer(&self.buffers[name].0),
                Bound::Buffer(name, false) => Resource::Buffer(&self.buffers[name].0),
                Bound::Stored(name, of, read_only) => {
                    let Some(slice) = slice(name, *of, turn) else { return self.has_no_level(pass, name) };
                    if *read_only { Resource::Loaded(slice) } else { Resource::Storage(slice) }
                }
                Bound::Sampled(source, sampler, of) => {
                    let slice = match source {
                        ImageSource::Own(name) => match slice(name, *of, turn) {
                            Some(slice) => slice,
                            None => return self.has_no_level(pass, name),
                        },
                        ImageSource::Previous(inner) => match &**inner {
                            ImageSource::Own(name) => self.own(name, turn + 1).all(),
                            _ => self.inputs.slice(source, input, turn)?,
                        },
                        ImageSource::Sky => match input.sky {
                            Some(sky) => {
                                resources.push(Resource::Sampled(Sampled(sky.all(), *sampler)));
                                continue;
                            }
                            None => {
                                return Err(Error::Usage("the method reads the sky, which is not known here".into()));
                            }
                        },
                        _ => self.inputs.slice(source, input, turn)?,
                    };
                    Resource::Sampled(Sampled(slice, *sampler))
                }
            });
        }
        let push = block(&plan.push, plan.push_size);
        let name = if pass.levels.is_some() { format!("{}/{level}", pass.name) } else { pass.name.clone() };
        match reach {
            None => {
                let target = |(slice, (image, _)): (ImageSlice<'a>, &(String, LevelOf))| {
                    let unwanted = is_unwanted(&self.manifest, image, self.hits);
                    if unwanted { Target::unwanted() } else { Target::overwrite(slice) }
                };
                let targets: Vec<Target> = targets.into_iter().zip(&pass.targets).map(target).collect();
                frame.draw_loose(&name, program, &targets, resources, &push)?;
            }
            Some(reach) => frame.dispatch_loose(&name, program, resources, &push, reach)?,
        }
        Ok(true)
    }

    /// A level that an image lacks ends a pass over levels, and is an error elsewhere.
    fn has_no_level(&self, pass: &Pass, image: &str) -> Result<bool> {
        if pass.levels.is_some() {
            return Ok(false);
        }
        Err(self.manifest.error(&pass.at, format!("pass {:?}: the image {image} has no such level", pass.name)))
    }

    fn finish<'a>(
        &'a self,
        frame: &mut Frame,
        input: &Input<'a, '_>,
        turn: usize,
        state: &FrameState,
    ) -> Result<Traced<'a>> {
        let extent = input.gbuffer.depth.extent();
        let resolution = extent.map(|v| v as f32);
        let made = self.own(&self.manifest.output.reflection, turn);
        let material = Sampled::nearest(input.gbuffer.material.all());
        let reflection = match &self.output.reflection {
            None => made,
            Some((pipeline, image, alpha)) => {
                let block = CustomOutputBlock { resolution, alpha: *alpha, ..CustomOutputBlock::default() };
                let sampled = if made.extent() == extent {
                    Sampled::nearest(made.level(0))
                } else {
                    Sampled::trilinear(made.level(0))
                };
                let program = CustomReflection { reflection_buffer: sampled, material_buffer: material, given: &block };
                frame.fullscreen("reflection", pipeline, [Target::overwrite(image.all())], &program)?;
                image
            }
        };
        let hits = match (&self.output.hits, &self.manifest.output.hits) {
            (Some((depth, pipeline, image, encoding)), Some(name)) => {
                let standard = depth.record(frame, &input.gbuffer)?;
                let to_clip = state.view_to_clip(input.camera);
                let block = CustomHitsBlock {
                    view_to_clip: to_clip.as_mat4().to_cols_array_2d(),
                    resolution,
                    encoding: *encoding,
                    ..CustomHitsBlock::default()
                };
                let program = CustomHits {
                    hit_buffer: Sampled::nearest(self.own(name, turn).level(0)),
                    material_buffer: material,
                    depth_buffer: Sampled::nearest(standard.0.level(0)),
                    given: &block,
                };
                frame.fullscreen("hits", pipeline, [Target::overwrite(image.all())], &program)?;
                Some(Hits(image))
            }
            _ => None,
        };
        let shown = |(name, image): (&&'static str, &'a OwnImage)| {
            let image = &image.images[turn % image.images.len()];
            is_float(image.format()).then_some(Intermediate { name, content: Content::Color, image })
        };
        let intermediates = self.names.iter().zip(self.images.values()).filter_map(shown).collect();
        Ok(Traced { hits, intermediates, ..Traced::new(Reflection(reflection)) })
    }
}

/// Whether an image is there for hits alone, and hits are not wanted: then it is drawn to by nobody.
fn is_unwanted(manifest: &Manifest, image: &str, hits: bool) -> bool {
    let reads = |source: &ImageSource| match source {
        ImageSource::Own(name) => name == image,
        ImageSource::Previous(of) => **of == ImageSource::Own(image.to_owned()),
        _ => false,
    };
    let is_read = manifest.passes.iter().flat_map(|p| p.inputs.values()).any(|i| match &i.what {
        InputKind::Image(source) => reads(source),
        InputKind::Buffer(_) => false,
    });
    !hits && manifest.output.hits.as_deref() == Some(image) && !is_read
}

/// Whether a format's numbers can be looked at as a colour.
fn is_float(format: vk::Format) -> bool {
    use vk::Format as F;
    !matches!(format, F::R32_UINT | F::R32G32_UINT | F::R32G32B32A32_UINT | F::R32_SINT)
}

impl OwnImage {
    fn new(gpu: &Gpu, name: &str, section: &ImageSection, extent: [u32; 2]) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let extent = extent.map(|v| ((v as f32 * section.scale).ceil() as u32).max(1));
        let format = format_of(&section.format).unwrap_or(LIT_COLOR);
        let all = image::full_chain(extent);
        let levels = if section.levels == 0 { all } else { section.levels.min(all) };
        let usage = U::COLOR_ATTACHMENT | U::SAMPLED | U::STORAGE | U::TRANSFER_SRC | U::TRANSFER_DST;
        let desc = ImageDesc { name, format, extent, levels, layers: 1, usage };
        let count = if section.history { 2 } else { 1 };
        let images = (0..count).map(|_| Image::new(gpu, &desc)).collect::<Result<_>>()?;
        Ok(Self { images, clear: section.clear })
    }
}

impl Finish {
    fn new(gpu: &Gpu, manifest: &Manifest, extent: [u32; 2], hits: bool) -> Result<Self> {
        let output = &manifest.output;
        let section = &manifest.images[&output.reflection];
        let is_ours =
            output.alpha == Alpha::Fade && section.scale == 1.0 && format_of(&section.format) == Some(LIT_COLOR);
        let alpha = match output.alpha {
            Alpha::Fade => ALPHA_FADE,
            Alpha::Premultiplied => ALPHA_PREMULTIPLIED,
            Alpha::None => ALPHA_NONE,
        };
        let reflection = (!is_ours)
            .then(|| -> Result<_> {
                let image = Image::target(gpu, "reflection", LIT_COLOR, extent)?;
                Ok((GraphicsPipeline::fullscreen(gpu, [LIT_COLOR])?, image, alpha))
            })
            .transpose()?;
        let encoding = match output.hits_are {
            HitEncoding::Uv => HITS_UV,
            HitEncoding::UvMasked => HITS_UV_MASKED,
            HitEncoding::UvDepth => HITS_UV_DEPTH,
            HitEncoding::Pixel => HITS_PIXEL,
            HitEncoding::ViewPosition => HITS_VIEW,
        };
        let hits = (hits && output.hits.is_some())
            .then(|| -> Result<_> {
                let image = Image::target(gpu, "hits", HITS, extent)?;
                Ok((HiZPass::depth_alone(gpu, extent)?, GraphicsPipeline::fullscreen(gpu, [HITS])?, image, encoding))
            })
            .transpose()?;
        Ok(Self { reflection, hits })
    }
}
