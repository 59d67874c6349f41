//! A method from a folder, at one size on one device.

use super::MANIFEST;
use super::bindings::{self, BoundInput, PassBindings};
use super::finish::Finish;
use super::inputs::Inputs;
use super::manifest::{ImageSection, InputKind, LevelOf, Manifest, Pass, PassDomain, PassStage, format_of};
use super::shader;
use super::source::ImageSource;
use super::values::{FilledField, FrameState};
use ash::vk;
use glam::Vec3;
use ssct::error::{Error, Result};
use ssct::gpu::loose::{DispatchSize, LooseProgram};
use ssct::gpu::memory::{Buffer, MemoryPlace};
use ssct::gpu::program::Sampled;
use ssct::gpu::{Frame, Gpu, Image, ImageDesc, ImageSlice, Resource, Target, image};
use ssct::methods::{Input, Intermediate, Method, MethodOutput, MethodRequest, Setup};
use ssct::passes::{Content, Hits, LIT_COLOR, Reflection};
use ssct_ground::parameter::{Parameter, Values};
use ssct_scenes::Camera;
use std::cell::{Cell, OnceCell, RefCell};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant, SystemTime};

/// The least time between two checks of the method's files, if the files are watched.
const PERIOD: Duration = Duration::from_millis(300);

/// The method in all its versions: one for its files as they were when the method was made, and one for each change of
/// the files since then.
pub struct CustomMethod {
    first: Version,
    reload: Option<Reload>,
}

/// One version of the method, and the version after it.
struct Version {
    running: RunningVersion,
    next: OnceCell<Box<Version>>,
}

/// Makes the method anew when its files change.
struct Reload {
    gpu: Gpu,
    folder: PathBuf,
    setup: Setup,
    hits: bool,
    /// The time of the last check of the files.
    last_check: Cell<Instant>,
    /// The time at which each file had been written when the last check was made.
    last_stamps: RefCell<Vec<Option<SystemTime>>>,
}

impl CustomMethod {
    /// Makes the method at a setup. If `watched`, it is made anew when its files change.
    pub fn new(
        gpu: &Gpu,
        manifest: &Manifest,
        parameters: &[Parameter],
        request: &MethodRequest,
        watched: bool,
    ) -> Result<Self> {
        let running = RunningVersion::new(gpu, manifest, parameters, &request.setup, request.hits)?;
        let reload = watched.then(|| Reload {
            gpu: gpu.clone(),
            folder: manifest.folder.clone(),
            setup: request.setup.clone(),
            hits: request.hits,
            last_check: Cell::new(Instant::now()),
            last_stamps: RefCell::new(stamps(&running.files)),
        });
        Ok(Self { first: Version { running, next: OnceCell::new() }, reload })
    }

    /// The newest version.
    fn last(&self) -> &Version {
        let mut version = &self.first;
        while let Some(next) = version.next.get() {
            version = next;
        }
        version
    }
}

impl Method for CustomMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        if let Some(reload) = &self.reload {
            let last = self.last();
            if let Some(running) = reload.remake(&last.running) {
                let _ = last.next.set(Box::new(Version { running, next: OnceCell::new() }));
            }
        }
        self.last().running.record(frame, input)
    }
}

impl Reload {
    /// Makes the method anew if its files changed since the last check; `None` if they did not, or have a fault. The
    /// parameters are those that were declared when the method was made.
    fn remake(&self, running: &RunningVersion) -> Option<RunningVersion> {
        if self.last_check.get().elapsed() < PERIOD {
            return None;
        }
        self.last_check.set(Instant::now());
        let written = stamps(&running.files);
        if *self.last_stamps.borrow() == written {
            return None;
        }
        *self.last_stamps.borrow_mut() = written;
        let remade = Manifest::read(&self.folder).map_err(Error::from).and_then(|manifest| {
            RunningVersion::new(&self.gpu, &manifest, &running.parameters, &self.setup, self.hits)
        });
        match remade {
            Ok(running) => {
                *self.last_stamps.borrow_mut() = stamps(&running.files);
                Some(running)
            }
            Err(error) => {
                tracing::warn!("{error}; the method stays as it was");
                None
            }
        }
    }
}

/// Returns the time at which each file was last written; `None` if it is not known.
fn stamps(files: &[PathBuf]) -> Vec<Option<SystemTime>> {
    files.iter().map(|file| std::fs::metadata(file).and_then(|m| m.modified()).ok()).collect()
}

/// Pipelines and images of one version of the files.
struct RunningVersion {
    passes: Vec<PreparedPass>,
    inputs: Inputs,
    images: BTreeMap<String, OwnImage>,
    /// The buffers by their names, each with the word that fills it at the beginning of a frame.
    buffers: BTreeMap<String, (Buffer, Option<u32>)>,
    output: Finish,
    manifest: Manifest,
    parameters: Vec<Parameter>,
    values: Values,
    fade: bool,
    hits: bool,
    files: Vec<PathBuf>,
    /// Names of the method's own images, in their order.
    names: Vec<&'static str>,
    /// Number of frames so far.
    frames: Cell<u32>,
    /// The camera of the last frame.
    before: Cell<Option<Camera>>,
}

/// An image of the method's own. With a history, it is two images, one of which each frame writes in turn.
struct OwnImage {
    images: Vec<Image>,
    clear: Option<f32>,
}

/// A pass with its pipeline.
struct PreparedPass {
    pass: Pass,
    program: LooseProgram,
    bindings: PassBindings,
}

impl RunningVersion {
    /// Compiles the shaders, checks them, and makes pipelines, images and buffers. `hits` says whether hits are wanted.
    fn new(gpu: &Gpu, manifest: &Manifest, parameters: &[Parameter], setup: &Setup, hits: bool) -> Result<Self> {
        let Setup { extent, projection, .. } = *setup;
        bindings::check_projection(manifest, projection)?;
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
        let initial_state = FrameState {
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
            let compiled_pass = shader::compile(manifest, pass)?;
            let bindings = PassBindings::new(manifest, pass, &compiled_pass)?;
            for bound in &bindings.inputs {
                if let BoundInput::Buffer { name, bytes, .. } = bound
                    && let Some((buffer, _)) = buffers.get(name)
                    && buffer.size() < u64::from(*bytes)
                {
                    let message = format!(
                        "pass {:?}: the shader's block has {bytes} bytes, and the buffer {name} has {}",
                        pass.name,
                        buffer.size()
                    );
                    return Err(manifest.error(&pass.span, message).into());
                }
            }
            let constants = bindings::constants(pass, &compiled_pass, &initial_state);
            let program = match pass.stage {
                PassStage::Compute => LooseProgram::compute(gpu, compiled_pass.shader, &constants)?,
                PassStage::Fragment => {
                    let format = |(name, _): &(String, LevelOf)| match is_unwanted(manifest, name, hits) {
                        true => vk::Format::UNDEFINED,
                        false => images[name].images[0].format(),
                    };
                    let formats: Vec<_> = pass.targets.iter().map(format).collect();
                    LooseProgram::fragment(gpu, compiled_pass.shader, &constants, &formats)?
                }
            };
            passes.push(PreparedPass { pass: pass.clone(), program, bindings });
            compiled.push(compiled_pass);
        }
        bindings::check_all_read(manifest, &compiled)?;
        let mut sources: Vec<ImageSource> = Vec::new();
        for bound in passes.iter().flat_map(|p| &p.bindings.inputs) {
            if let BoundInput::Sampled { source, .. } = bound {
                sources.push(source.clone());
            }
        }
        Ok(Self {
            inputs: Inputs::new(gpu, (extent, projection), &sources, manifest.conventions)?,
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

    /// Returns the method's own image with a name. An image with a history exists twice, and `turn` chooses one of the
    /// two.
    fn own_image(&self, name: &str, turn: usize) -> &Image {
        let images = &self.images[name].images;
        &images[turn % images.len()]
    }

    /// Records one frame: clears, the sources, the passes level by level, and the outputs.
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        let before = self.before.replace(Some(*input.camera));
        let number = self.frames.replace(self.frames.get().wrapping_add(1));
        let turn = number as usize % 2;
        let extent = input.gbuffer.depth.extent();
        if before.is_none() {
            self.inputs.clear_kept(frame)?;
        }
        for (name, image) in &self.images {
            // The first frame clears both copies of an image with a history.
            let clears_all = before.is_none() && image.images.len() > 1;
            for (index, copy) in image.images.iter().enumerate() {
                let this_frame = image.clear.filter(|_| index == turn % image.images.len());
                if let Some(number) = this_frame.or(clears_all.then_some(0.0)) {
                    frame.clear(&format!("clear {name}"), copy.all(), [number; 4])?;
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
        // Interleaved passes are recorded together, level by level.
        for interleaved in self.passes.chunk_by(|_, next| next.pass.interleaved) {
            let [first, last] = interleaved[0].pass.levels.unwrap_or([0, 0]);
            'levels: for level in first..=last {
                for pass in interleaved {
                    if !self.record_level(frame, input, pass, (level, turn), &state)? {
                        break 'levels;
                    }
                }
            }
        }
        self.inputs.keep(frame, input, turn)?;
        let output = &self.manifest.output;
        let reflection = self.output.reflection(frame, input, self.own_image(&output.reflection, turn))?;
        let hits = match &output.hits {
            Some(name) => self.output.hits(frame, input, self.own_image(name, turn), &state(extent, 0))?,
            None => None,
        };
        let shown = |(name, image): (&&'static str, &'a OwnImage)| {
            let image = &image.images[turn % image.images.len()];
            content(image.format()).map(|content| Intermediate { name, content, image })
        };
        let own = self.names.iter().zip(self.images.values()).filter_map(shown);
        // If an own image and a source have one name, the own image is shown, since the author of the method means it.
        let sources = self.inputs.intermediates(extent).filter(|image| !self.images.contains_key(image.name));
        let intermediates = sources.chain(own).collect();
        Ok(MethodOutput { hits: hits.map(Hits), intermediates, ..MethodOutput::new(Reflection(reflection)) })
    }

    /// Records a pass for the level `level`; returns false if the pass runs over levels and an image lacks this one.
    /// `turn` chooses one of an image's copies. `state` makes the values of the frame for an extent and a level.
    fn record_level<'a, 's>(
        &'a self,
        frame: &mut Frame,
        input: &Input<'a, '_>,
        PreparedPass { pass, program, bindings }: &'a PreparedPass,
        (level, turn): (u32, usize),
        state: &impl Fn([u32; 2], u32) -> FrameState<'s>,
    ) -> Result<bool> {
        let slice = |name: &str, wanted_level: LevelOf, turn: usize| -> Option<ImageSlice<'a>> {
            let image = self.own_image(name, turn);
            let number = match wanted_level {
                LevelOf::All => return Some(image.all()),
                LevelOf::Number(n) => n,
                LevelOf::Current(less) => level.checked_sub(less)?,
            };
            (number < image.levels()).then(|| image.level(number))
        };
        let mut targets = Vec::new();
        for (name, wanted_level) in &pass.targets {
            let Some(slice) = slice(name, *wanted_level, turn) else { return self.skip_or_fail(pass, name) };
            targets.push(slice);
        }
        let (pass_extent, dispatch_size) = match &pass.domain {
            PassDomain::Targets => (targets[0].extent(), None),
            PassDomain::Threads(name, wanted_level) => {
                let Some(slice) = slice(name, *wanted_level, turn) else { return self.skip_or_fail(pass, name) };
                let [width, height] = slice.extent();
                ([width, height], Some(DispatchSize::Threads([width, height, 1])))
            }
            PassDomain::Workgroups(groups) => (input.gbuffer.depth.extent(), Some(DispatchSize::Workgroups(*groups))),
            PassDomain::Indirect(name) => {
                (input.gbuffer.depth.extent(), Some(DispatchSize::Indirect(&self.buffers[name].0)))
            }
        };
        if let Some(other) = targets.iter().find(|t| t.extent() != pass_extent) {
            let message =
                format!("pass {:?}: its targets are {pass_extent:?} and {:?} pixels large", pass.name, other.extent());
            return Err(self.manifest.error(&pass.span, message).into());
        }
        let state = state(pass_extent, level);
        let block = |fields: &[FilledField], size: usize| {
            let mut bytes = vec![0; size];
            fields.iter().for_each(|f| f.write(&mut bytes, &state));
            bytes
        };
        let blocks: Vec<Vec<u8>> = bindings
            .inputs
            .iter()
            .map(|b| if let BoundInput::Uniform { fields, bytes } = b { block(fields, *bytes) } else { Vec::new() })
            .collect();
        let mut resources = Vec::with_capacity(bindings.inputs.len());
        for (bound, block_bytes) in bindings.inputs.iter().zip(&blocks) {
            resources.push(match bound {
                BoundInput::Uniform { .. } => Resource::Uniform(block_bytes),
                BoundInput::Buffer { name, read_only: true, .. } => Resource::ReadBuffer(&self.buffers[name].0),
                BoundInput::Buffer { name, .. } => Resource::Buffer(&self.buffers[name].0),
                BoundInput::Stored { name, level: wanted_level, read_only } => {
                    let Some(slice) = slice(name, *wanted_level, turn) else { return self.skip_or_fail(pass, name) };
                    if *read_only { Resource::Loaded(slice) } else { Resource::Storage(slice) }
                }
                BoundInput::Sampled { source, sampler, level: wanted_level } => {
                    let slice = match source {
                        ImageSource::Own(name) => match slice(name, *wanted_level, turn) {
                            Some(slice) => slice,
                            None => return self.skip_or_fail(pass, name),
                        },
                        // The copy that this frame does not write is that of the frame before.
                        ImageSource::Previous(original) => match &**original {
                            ImageSource::Own(name) => self.own_image(name, turn + 1).all(),
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
        let push = block(&bindings.push, bindings.push_size);
        let name = if pass.levels.is_some() { format!("{}/{level}", pass.name) } else { pass.name.clone() };
        match dispatch_size {
            None => {
                let target = |(slice, (image, _)): (ImageSlice<'a>, &(String, LevelOf))| {
                    let unwanted = is_unwanted(&self.manifest, image, self.hits);
                    if unwanted { Target::unwanted() } else { Target::overwrite(slice) }
                };
                let targets: Vec<Target> = targets.into_iter().zip(&pass.targets).map(target).collect();
                frame.draw_loose(&name, program, &targets, resources, &push)?;
            }
            Some(dispatch_size) => frame.dispatch_loose(&name, program, resources, &push, dispatch_size)?,
        }
        Ok(true)
    }

    /// Decides what happens if `image` lacks the level that a pass needs. A pass over levels ends there, and false is
    /// returned; for any other pass it is an error.
    fn skip_or_fail(&self, pass: &Pass, image: &str) -> Result<bool> {
        if pass.levels.is_some() {
            return Ok(false);
        }
        let message = format!("pass {:?}: the image {image} has no such level", pass.name);
        Err(self.manifest.error(&pass.span, message).into())
    }
}

/// True if an image exists only for hits, and hits are not wanted. Then no pass draws to the image.
fn is_unwanted(manifest: &Manifest, image: &str, hits: bool) -> bool {
    let reads = |source: &ImageSource| match source {
        ImageSource::Own(name) => name == image,
        ImageSource::Previous(original) => **original == ImageSource::Own(image.to_owned()),
        _ => false,
    };
    let is_read = manifest.passes.iter().flat_map(|p| p.inputs.values()).any(|i| match &i.what {
        InputKind::Image(source) => reads(source),
        InputKind::Buffer(_) => false,
    });
    !hits && manifest.output.hits.as_deref() == Some(image) && !is_read
}

/// Returns how an image of a format is shown: as a colour, or as one number; `None` for whole numbers and for pairs.
fn content(format: vk::Format) -> Option<Content> {
    use vk::Format as F;
    match format {
        F::R8_UNORM | F::R16_SFLOAT | F::R32_SFLOAT => Some(Content::Share),
        F::R8G8_UNORM | F::R16G16_SFLOAT | F::R32G32_SFLOAT => None,
        F::R32_UINT | F::R32G32_UINT | F::R32G32B32A32_UINT | F::R32_SINT => None,
        _ => Some(Content::Color),
    }
}

impl OwnImage {
    /// Makes the image of a section of the manifest, for a frame of `extent` pixels.
    fn new(gpu: &Gpu, name: &str, section: &ImageSection, extent: [u32; 2]) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let extent = extent.map(|v| ((v as f32 * section.scale).ceil() as u32).max(1));
        let format = format_of(&section.format).unwrap_or(LIT_COLOR);
        let most_levels = image::full_chain(extent);
        let levels = if section.levels == 0 { most_levels } else { section.levels.min(most_levels) };
        let plain = U::COLOR_ATTACHMENT | U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST;
        // Devices need not store to images that are encoded as sRGB.
        let usage = if format == vk::Format::R8G8B8A8_SRGB { plain } else { plain | U::STORAGE };
        let desc = ImageDesc { name, format, extent, levels, layers: 1, usage };
        let count = if section.history { 2 } else { 1 };
        let images = (0..count).map(|_| Image::new(gpu, &desc)).collect::<Result<_>>()?;
        Ok(Self { images, clear: section.clear.number() })
    }
}
