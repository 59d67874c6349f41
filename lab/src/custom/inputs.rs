//! Makes the images that shaders read out of the G-buffer. Only images that some pass reads are made, and each of them
//! once a frame.

use super::conventions::Conventions;
use super::manifest::SamplerName;
use super::noise;
use super::source::{CapturePart, Depth, DepthChain, ImageSource, Normal};
use super::values;
use ash::vk;
use ssct::error::{Error, Result};
use ssct::gpu::memory::{Buffer, MemoryPlace};
use ssct::gpu::program::Sampled;
use ssct::gpu::programs::{Convert, Reduce, ReduceConstants};
use ssct::gpu::shader::ConvertBlock;
use ssct::gpu::{
    ComputePipeline, Frame, FrameContext, Gpu, GraphicsPipeline, Image, ImageDesc, ImageSlice, Sampler, ShaderStage,
    Target, image,
};
use ssct::methods::{Input, Intermediate, unified};
use ssct::passes::color_chain::{ChainFilter, ColorChainPass};
use ssct::passes::hi_z::HiZPass;
use ssct::passes::pyramid::PyramidPass;
use ssct::passes::visibility::VisibilityPass;
use ssct::passes::{Content, GBuffer, HiZ as ThesisHiZ, LIT_COLOR, camera_block};
use ssct_ground::conventions::{Axes, NormalEncoding};
use ssct_ground::math::constants::{
    CONVERT_LINEAR_DEPTH, CONVERT_MOTION, CONVERT_REVERSED_DEPTH, CONVERT_VIEW_NORMAL, CONVERT_VIEW_PLACE,
    CONVERT_WORLD_NORMAL, CONVERT_WORLD_PLACE,
};
use ssct_scenes::{Camera, ProjectionKind};

/// The passes that make the sources that a method reads.
pub struct Inputs {
    /// The sources and how each is made; a source stands behind those from which it is made.
    makers: Vec<(ImageSource, SourceMaker)>,
    /// Names of the sources' images, in their order, for the list of intermediate images.
    names: Vec<&'static str>,
    /// The kind of the camera's projection.
    projection: ProjectionKind,
}

/// How a source is made, and the image that then holds it.
enum SourceMaker {
    /// Nothing needs to be made: the source is in the G-buffer, or comes with the input.
    Existing,
    /// The lit colour with its chain.
    Chain(ColorChainPass),
    /// The thesis's depth, alone or with its Hi-Z chain.
    Thesis(HiZPass),
    Visibility(VisibilityPass),
    Pyramid(PyramidPass),
    /// An image of the G-buffer in other conventions.
    Converted {
        pipeline: GraphicsPipeline<Convert<'static>>,
        image: Image,
        /// The code of the conversion, `CONVERT_*`.
        code: i32,
        axes: Axes,
    },
    /// A chain of minima or maxima of the depth `original`.
    Reduced {
        copy: ComputePipeline<Reduce<'static>>,
        reduce: ComputePipeline<Reduce<'static>>,
        chain: Image,
        original: ImageSource,
    },
    Noise(Image),
    /// Two copies of a source: one of the frame before, and one of this frame. They swap their parts in every frame.
    Kept {
        original: ImageSource,
        images: Vec<Image>,
    },
}

impl Inputs {
    /// Makes the passes for `sources`, at a size in pixels and for a projection. Sources from which these are made are
    /// added.
    pub fn new(
        gpu: &Gpu,
        (extent, projection): ([u32; 2], ProjectionKind),
        sources: &[ImageSource],
        conventions: Conventions,
    ) -> Result<Self> {
        let mut inputs = Self { makers: Vec::new(), names: Vec::new(), projection };
        for source in sources {
            inputs.add(gpu, extent, source, conventions)?;
        }
        inputs.names = inputs.makers.iter().map(|(source, _)| stem(source)).collect();
        Ok(inputs)
    }

    /// Adds a source, and before it the sources from which it is made, unless it was added already.
    fn add(&mut self, gpu: &Gpu, extent: [u32; 2], source: &ImageSource, conventions: Conventions) -> Result<()> {
        if self.makers.iter().any(|(known, _)| known == source) {
            return Ok(());
        }
        let convert = |code: i32, axes: Axes, format: vk::Format| -> Result<SourceMaker> {
            Ok(SourceMaker::Converted {
                pipeline: GraphicsPipeline::fullscreen(gpu, [format])?,
                image: Image::target(gpu, &source.to_string(), format, extent)?,
                code,
                axes,
            })
        };
        let float = vk::Format::R32_SFLOAT;
        let maker = match source {
            ImageSource::LitColour
            | ImageSource::Material
            | ImageSource::Sky
            | ImageSource::Captures(_)
            | ImageSource::Own(_) => SourceMaker::Existing,
            ImageSource::LitColourChain { gaussian } => {
                let filter = if *gaussian { ChainFilter::Gaussian } else { ChainFilter::Hardware };
                SourceMaker::Chain(ColorChainPass::new(gpu, ShaderStage::Fragment, extent, LIT_COLOR, filter)?)
            }
            ImageSource::Depth(Depth::Reversed) => SourceMaker::Existing,
            ImageSource::Depth(Depth::Standard) => {
                SourceMaker::Thesis(HiZPass::depth_alone(gpu, ShaderStage::Fragment, extent)?)
            }
            ImageSource::Depth(Depth::Linear) => convert(CONVERT_LINEAR_DEPTH, Axes::Left, float)?,
            ImageSource::Normal(Normal { world, encoding }) => {
                let axes = if *world { conventions.world } else { conventions.view };
                if !world && *encoding == NormalEncoding::Float && axes == Axes::Left {
                    SourceMaker::Existing
                } else {
                    // The codes of a normal's encodings follow that of the first encoding.
                    let first_code = if *world { CONVERT_WORLD_NORMAL } else { CONVERT_VIEW_NORMAL };
                    convert(first_code + *encoding as i32, axes, vk::Format::R16G16B16A16_SFLOAT)?
                }
            }
            ImageSource::Position { world } => {
                let (code, axes) = match world {
                    true => (CONVERT_WORLD_PLACE, conventions.world),
                    false => (CONVERT_VIEW_PLACE, conventions.view),
                };
                convert(code, axes, vk::Format::R32G32B32A32_SFLOAT)?
            }
            ImageSource::ThesisHiZ => SourceMaker::Thesis(HiZPass::new(gpu, ShaderStage::Fragment, extent, true)?),
            ImageSource::Visibility => {
                self.add(gpu, extent, &ImageSource::ThesisHiZ, conventions)?;
                SourceMaker::Visibility(VisibilityPass::new(gpu, ShaderStage::Fragment, extent)?)
            }
            ImageSource::Pyramid => SourceMaker::Pyramid(PyramidPass::for_projection(gpu, extent, self.projection)?),
            ImageSource::Motion => convert(CONVERT_MOTION, Axes::Left, vk::Format::R32G32_SFLOAT)?,
            ImageSource::BlueNoise => SourceMaker::Noise(blue_noise(gpu)?),
            ImageSource::DepthChain(DepthChain { maximum, depth, padded }) => {
                let original = ImageSource::Depth(*depth);
                self.add(gpu, extent, &original, conventions)?;
                let size = if *padded { extent.map(u32::next_power_of_two) } else { extent };
                use vk::ImageUsageFlags as U;
                let name = source.to_string();
                let levels = image::full_chain(size);
                let usage = U::STORAGE | U::SAMPLED | U::TRANSFER_SRC;
                let desc = ImageDesc { name: &name, format: float, extent: size, levels, layers: 1, usage };
                SourceMaker::Reduced {
                    copy: ComputePipeline::with_constants(gpu, &ReduceConstants { maximum: *maximum, copy: true })?,
                    reduce: ComputePipeline::with_constants(gpu, &ReduceConstants { maximum: *maximum, copy: false })?,
                    chain: Image::new(gpu, &desc)?,
                    original,
                }
            }
            ImageSource::Previous(original) => {
                if let ImageSource::Own(_) = **original {
                    // The method keeps its own images.
                    SourceMaker::Existing
                } else {
                    if **original == ImageSource::Depth(Depth::Reversed) {
                        // A depth buffer cannot be copied to the kept image, so shaders read a colour image with its
                        // values.
                        let as_color = ((**original).clone(), convert(CONVERT_REVERSED_DEPTH, Axes::Left, float)?);
                        // The colour image replaces an earlier entry for the depth buffer, so that the colour image is
                        // kept.
                        match self.makers.iter_mut().find(|(known, _)| known == &**original) {
                            Some(known) => *known = as_color,
                            None => self.makers.push(as_color),
                        }
                    }
                    self.add(gpu, extent, original, conventions)?;
                    let (name, format) = (source.to_string(), self.kept_format(original));
                    let image = || Image::target(gpu, &name, format, extent);
                    SourceMaker::Kept { original: (**original).clone(), images: vec![image()?, image()?] }
                }
            }
        };
        self.makers.push((source.clone(), maker));
        Ok(())
    }

    /// Returns the format of the two images that keep `source` for the next frame ([`Self::keep`]). It has all channels
    /// of the image from which they are copied.
    fn kept_format(&self, source: &ImageSource) -> vk::Format {
        match self.makers.iter().find(|(known, _)| known == source) {
            Some((_, SourceMaker::Converted { image, .. })) => image.format(),
            Some((_, SourceMaker::Thesis(_))) => vk::Format::R32G32_SFLOAT,
            _ => match source {
                ImageSource::Depth(_) => vk::Format::R32_SFLOAT,
                ImageSource::Material => vk::Format::R16G16_SFLOAT,
                _ => LIT_COLOR,
            },
        }
    }

    /// Records the passes that make the sources of this frame, each after the sources from which it is made. `before`
    /// is the camera of the frame before.
    pub fn record(&self, frame: &mut Frame, input: &Input, before: &Camera) -> Result<()> {
        let gbuffer = &input.gbuffer;
        let extent = gbuffer.depth.extent();
        for (source, maker) in &self.makers {
            let name = source.to_string();
            match maker {
                SourceMaker::Existing | SourceMaker::Noise(_) | SourceMaker::Kept { .. } => {}
                SourceMaker::Chain(pass) => {
                    pass.record(frame, gbuffer)?;
                }
                SourceMaker::Thesis(pass) => {
                    pass.record(frame, gbuffer)?;
                }
                SourceMaker::Visibility(pass) => {
                    let hi_z = ThesisHiZ(self.image(&ImageSource::ThesisHiZ, input, 0)?);
                    pass.record(frame, hi_z, &input.camera.lens)?;
                }
                SourceMaker::Pyramid(pass) => {
                    pass.record(frame, gbuffer, &unified::parameters(input.camera, extent, false))?;
                }
                SourceMaker::Converted { pipeline, image, code, axes } => {
                    let program = Convert {
                        camera: &camera_block(input.camera, extent),
                        depth_buffer: Sampled::nearest(gbuffer.depth.all()),
                        normal_buffer: Sampled::nearest(gbuffer.normal.all()),
                        convert: &convert_block(input.camera, before, *code, *axes),
                    };
                    frame.fullscreen(&name, pipeline, [Target::overwrite(image.all())], &program)?;
                }
                SourceMaker::Reduced { copy, reduce, chain, original } => {
                    let depth = self.slice(original, input, 0)?;
                    for level in 0..chain.levels() {
                        let below = if level == 0 { depth } else { chain.level(level - 1) };
                        let program = Reduce { below: Sampled::nearest(below), level: chain.level(level) };
                        let pipeline = if level == 0 { copy } else { reduce };
                        let [width, height] = chain.level(level).extent();
                        frame.compute(&format!("{name}/{level}"), pipeline, &program, [width, height, 1])?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Returns the images that this frame made from the G-buffer, whose size is `extent`. Left out are the chain of the
    /// lit colour, copies of the frame before, noise, and images that need not be made.
    pub fn intermediates<'i>(&'i self, extent: [u32; 2]) -> impl Iterator<Item = Intermediate<'i>> + 'i {
        self.makers.iter().zip(&self.names).filter_map(move |((source, maker), name)| {
            let (content, image) = match maker {
                SourceMaker::Existing | SourceMaker::Chain(_) | SourceMaker::Noise(_) | SourceMaker::Kept { .. } => {
                    return None;
                }
                SourceMaker::Thesis(pass) => (Content::StandardDepth, pass.recorded().0),
                SourceMaker::Visibility(pass) => (Content::Share, pass.recorded().0),
                SourceMaker::Pyramid(pass) => (Content::Pyramid(extent), pass.recorded().0),
                SourceMaker::Converted { image, .. } => (content(source), image),
                SourceMaker::Reduced { chain, original: reduced, .. } => (content(reduced), chain),
            };
            Some(Intermediate { name, content, image })
        })
    }

    /// Copies the sources that the next frame reads of this frame. `turn` is 0 and 1 in alternate frames, and says
    /// which copy is replaced.
    pub fn keep(&self, frame: &mut Frame, input: &Input, turn: usize) -> Result<()> {
        for (source, maker) in &self.makers {
            if let SourceMaker::Kept { original, images } = maker {
                frame.blit(&format!("keep {source}"), self.slice(original, input, turn)?, images[turn].all())?;
            }
        }
        Ok(())
    }

    /// Clears the kept copies, since the first frame reads them although there is no frame before it.
    pub fn clear_kept(&self, frame: &mut Frame) -> Result<()> {
        for (source, maker) in &self.makers {
            if let SourceMaker::Kept { images, .. } = maker {
                for image in images {
                    frame.clear(&format!("clear {source}"), image.all(), [0.0; 4])?;
                }
            }
        }
        Ok(())
    }

    /// Returns the image of a source; of a source that is kept for the next frame, the copy of the frame before. `turn`
    /// is 0 and 1 in alternate frames, and is the number of the copy that this frame writes.
    fn image<'i>(&'i self, source: &ImageSource, input: &Input<'i, '_>, turn: usize) -> Result<&'i Image> {
        let GBuffer { depth, normal, material, color, .. } = input.gbuffer;
        let lacks = |what: &str| Error::Usage(format!("the method reads {source}, and there {what}"));
        let maker = self.makers.iter().find(|(known, _)| known == source).map(|(_, maker)| maker);
        Ok(match (maker, source) {
            (Some(SourceMaker::Thesis(pass)), _) => pass.recorded().0,
            (Some(SourceMaker::Visibility(pass)), _) => pass.recorded().0,
            (Some(SourceMaker::Pyramid(pass)), _) => pass.recorded().0,
            (Some(SourceMaker::Converted { image, .. }), _) | (Some(SourceMaker::Noise(image)), _) => image,
            (Some(SourceMaker::Reduced { chain, .. }), _) => chain,
            (Some(SourceMaker::Kept { images, .. }), _) => &images[1 - turn],
            (_, ImageSource::LitColour | ImageSource::LitColourChain { .. }) => color,
            (_, ImageSource::Depth(_)) => depth,
            (_, ImageSource::Normal(_)) => normal,
            (_, ImageSource::Material) => material,
            (_, ImageSource::Captures(part)) => {
                let captures = input.captures.ok_or_else(|| lacks("are no captures"))?;
                match part {
                    CapturePart::Colour => captures.color,
                    CapturePart::Pyramid => captures.pyramid,
                    CapturePart::Normal => captures.normal,
                }
            }
            _ => return Err(lacks("is none")),
        })
    }

    /// Returns the part of a source's image that a shader binds: level 0 of the lit colour without its chain, or else
    /// all.
    pub fn slice<'i>(&'i self, source: &ImageSource, input: &Input<'i, '_>, turn: usize) -> Result<ImageSlice<'i>> {
        if *source == ImageSource::Sky {
            return Err(Error::Usage("the method reads the sky, which is bound apart".into()));
        }
        let image = self.image(source, input, turn)?;
        let has_one_level = matches!(source, ImageSource::LitColour);
        Ok(if has_one_level { image.level(0) } else { image.all() })
    }
}

/// Returns the meaning of a source's numbers, which decides how a picture of them is drawn.
fn content(source: &ImageSource) -> Content {
    match source {
        ImageSource::Depth(Depth::Reversed) => Content::ReversedDepth,
        ImageSource::Depth(Depth::Standard) => Content::StandardDepth,
        ImageSource::Depth(Depth::Linear) => Content::LinearDepth,
        ImageSource::Normal(Normal { encoding: NormalEncoding::Float, .. }) => Content::Normal,
        _ => Content::Numbers,
    }
}

/// Returns the stem of the file name for a source. The project's own methods use the same stem for the same image. The
/// text lives as long as the program.
fn stem(source: &ImageSource) -> &'static str {
    match source {
        ImageSource::ThesisHiZ => "hi-z",
        ImageSource::Depth(Depth::Standard) => "standard-depth",
        _ => source.to_string().replace(':', "-").leak(),
    }
}

/// Returns the sampler that the manifest names or, if it names none, the usual one of the source.
pub fn sampler(source: &ImageSource, named: Option<SamplerName>) -> Sampler {
    match named {
        Some(SamplerName::Nearest) => Sampler::NearestClamp,
        Some(SamplerName::Linear) => Sampler::TrilinearClamp,
        Some(SamplerName::Repeat) => Sampler::Material,
        None if *source == ImageSource::BlueNoise => Sampler::Material,
        None if source.is_smooth() => Sampler::TrilinearClamp,
        None => Sampler::NearestClamp,
    }
}

/// Returns the uniforms of a conversion: `before` is the camera of the frame before, and `code` is that of the
/// conversion, `CONVERT_*`.
fn convert_block(camera: &Camera, before: &Camera, code: i32, axes: Axes) -> ConvertBlock {
    let world_to_clip = |c: &Camera| c.view_to_clip_reversed().as_dmat4() * c.world_to_view.as_dmat4();
    ConvertBlock {
        clip_to_clip_before: (world_to_clip(before) * world_to_clip(camera).inverse()).as_mat4().to_cols_array_2d(),
        axes: values::to_axes(axes).as_mat4().to_cols_array_2d(),
        what: code,
        ..ConvertBlock::default()
    }
}

/// Makes the image of blue noise, so that shaders have two numbers for each texel that depend little on each other. Red
/// has the tile of [`noise::tile`], and green has it moved by a third of its side.
fn blue_noise(gpu: &Gpu) -> Result<Image> {
    use vk::ImageUsageFlags as U;
    let side = noise::RANKS_ACROSS;
    let tile = noise::tile();
    let texel = |index: usize| {
        let (x, y) = (index % side, index / side);
        [tile[index], tile[(y + side / 3) % side * side + (x + side / 3) % side]]
    };
    let bytes: Vec<u8> = (0..side * side).flat_map(texel).collect();
    let extent = [side as u32; 2];
    let format = vk::Format::R8G8_UNORM;
    let desc =
        ImageDesc { name: "blue noise", format, extent, levels: 1, layers: 1, usage: U::SAMPLED | U::TRANSFER_DST };
    let image = Image::new(gpu, &desc)?;
    let mut staging =
        Buffer::new(gpu, "staging", bytes.len() as u64, vk::BufferUsageFlags::TRANSFER_SRC, MemoryPlace::Upload)?;
    staging.bytes_mut()?[..bytes.len()].copy_from_slice(&bytes);
    FrameContext::new(gpu)?.once(|frame| frame.upload("blue noise", &staging, image.level(0)))?;
    Ok(image)
}
