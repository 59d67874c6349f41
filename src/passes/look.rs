//! Passes for a window that shows the methods' images: [`KeepPass`] makes copies that outlast a frame, and [`LookPass`]
//! makes one picture of the copies.

use super::Content;
use crate::error::Result;
use crate::gpu::shader::{KeepBlock, LookBlock};
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, ImageSlice, Sampled, Target, programs};
use ash::vk;
use ssct_ground::math::constants::*;
use ssct_ground::scene::Lens;

/// Format of the copies, which holds the values of every image that a method makes.
const KEPT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Copies a level of an image into an image of the pass's size.
pub struct KeepPass {
    pipeline: GraphicsPipeline<programs::Keep<'static>>,
    image: Image,
}

impl KeepPass {
    /// Makes the pass and its image of a size in pixels.
    pub fn new(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        Ok(Self {
            pipeline: GraphicsPipeline::fullscreen(gpu, [KEPT])?,
            image: Image::target(gpu, "kept", KEPT, extent)?,
        })
    }

    /// Records pass "keep", which scales a level of an image to the pass's size by taking the nearest texel.
    pub fn record(&self, frame: &mut Frame, level: ImageSlice) -> Result<()> {
        let (from, to) = (level.extent(), self.image.extent());
        let keep = KeepBlock { scale: [0, 1].map(|axis| from[axis] as f32 / to[axis] as f32) };
        frame.fullscreen(
            "keep",
            &self.pipeline,
            [Target::overwrite(self.image.all())],
            &programs::Keep { source: Sampled::nearest(level), keep: &keep },
        )
    }

    /// The copy.
    pub fn image(&self) -> &Image {
        &self.image
    }
}

/// How two pictures are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Compare {
    /// The first alone.
    #[default]
    One = COMPARE_ONE as isize,
    /// The first left of a line, the second right of it.
    Split = COMPARE_SPLIT as isize,
    /// The magnitude of the difference between the two.
    Difference = COMPARE_DIFFERENCE as isize,
}

/// How numbers are shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone {
    /// The kind of the numbers.
    pub content: Content,
    /// One channel as grey; `None` shows all.
    pub channel: Option<u32>,
    /// Exponent of the power of two by which the numbers are multiplied.
    pub exposure_stops: f32,
    /// The number that is shown black, and the number that is shown white.
    pub range: [f32; 2],
}

impl Tone {
    /// Linear colour as the finished image shows it: unchanged, from 0 to 1.
    pub const DISPLAY: Self = Self { content: Content::Color, channel: None, exposure_stops: 0.0, range: [0.0, 1.0] };
}

/// How one or two pictures are displayed on the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureDisplay {
    /// Left, top, width and height of the pictures on the screen, in pixels.
    pub area: [u32; 4],
    /// How one or two pictures are shown.
    pub compare: Compare,
    /// Place of the line between two pictures, as a share of the width.
    pub split: f32,
    /// Factor of the difference.
    pub gain: f32,
    /// How the numbers of the pictures are shown.
    pub tone: Tone,
    /// The lens of the camera, by which depths are shown.
    pub lens: Lens,
}

/// The pipeline that draws to a screen's format.
pub struct LookPass {
    pipeline: GraphicsPipeline<programs::Look<'static>>,
}

impl LookPass {
    /// Makes the pass for screens of a format, which must be an sRGB format so that it encodes the colours.
    pub fn new(gpu: &Gpu, screen: vk::Format) -> Result<Self> {
        Ok(Self { pipeline: GraphicsPipeline::fullscreen(gpu, [screen])? })
    }

    /// Records pass "look", which draws to `screen`. Pictures have the area's size; a single picture is given twice.
    pub fn record(
        &self,
        frame: &mut Frame,
        screen: &Image,
        look: &PictureDisplay,
        pictures: [&Image; 2],
    ) -> Result<()> {
        let parameters = LookBlock {
            area: look.area.map(|v| v as i32),
            compare: look.compare as i32,
            split: (look.split * look.area[2] as f32).round() as i32,
            content: content_code(look.tone.content),
            channel: look.tone.channel.map_or(-1, |c| c as i32),
            exposure: look.tone.exposure_stops.exp2(),
            range_low: look.tone.range[0],
            range_high: look.tone.range[1],
            gain: look.gain,
            near_plane: look.lens.near_m,
            far_plane: look.lens.far_m,
            is_linear: i32::from(look.lens.kind().is_orthographic()),
            ..LookBlock::default()
        };
        frame.fullscreen(
            "look",
            &self.pipeline,
            [Target::overwrite(screen.all())],
            &programs::Look {
                first: Sampled::nearest(pictures[0].all()),
                second: Sampled::nearest(pictures[1].all()),
                look: &parameters,
            },
        )
    }
}

/// Returns the code `CONTENT_*` by which `look.frag` shows images of a content.
fn content_code(content: Content) -> i32 {
    match content {
        Content::Color => CONTENT_COLOR,
        Content::Normal => CONTENT_NORMAL,
        Content::ReversedDepth => CONTENT_REVERSED_DEPTH,
        Content::StandardDepth => CONTENT_STANDARD_DEPTH,
        Content::Share | Content::Material | Content::Hits | Content::LinearDepth => CONTENT_PLAIN,
        Content::Pyramid(_) | Content::Numbers => CONTENT_PLAIN,
        Content::Steps => CONTENT_HEAT,
    }
}
