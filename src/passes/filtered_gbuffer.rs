//! The poster's pre-filtered G-buffer of linear depth, normal and colour. It has either mip chains or volumes. The
//! hardware's filter makes the mip chains, or a filter that averages one surface alone. The slices of a volume are the
//! full-size image, blurred by ever wider Gaussians.

use super::{FilteredGBuffer, GBuffer, PosterFilter, camera_block};
use crate::error::Result;
use crate::gpu::programs::{EdgeAware, LinearDepth, LinearDepthVolume, PosterBlurAcross, PosterBlurDown};
use crate::gpu::shader::{EdgeAwareBlock, PosterBlurBlock};
use crate::gpu::{
    Frame, FrameContext, Gpu, Image, ImageDesc, ImageSlice, PixelPipeline, Sampled, ShaderStage, Target, image,
};
use ash::vk;
use ssct_ground::math::constants::{GAUSSIAN_1, GAUSSIAN_2, GAUSSIAN_3};
use ssct_ground::scene::Camera;

/// The most slices of a volume. The last slice is blurred as widely as level 7 of the mip chain. Each slice costs as
/// much memory as the whole G-buffer.
pub const MAX_SLICES: u32 = 8;

// Formats of depth, normal and colour. Normal and colour have the formats of the G-buffer, so that they can be copied.
const FORMATS: [vk::Format; 3] =
    [vk::Format::R32_SFLOAT, vk::Format::R16G16B16A16_SFLOAT, vk::Format::R16G16B16A16_SFLOAT];
const NAMES: [&str; 3] = ["filtered depth", "filtered normal", "filtered color"];

/// Pipelines and images of one size.
pub struct FilteredGBufferPass {
    linear_depth: LinearDepths,
    images: Images,
    /// The beginning of the names of the passes.
    prefix: &'static str,
}

/// The program of the linear depth, by the kind of image that it writes.
enum LinearDepths {
    Flat(PixelPipeline<LinearDepth<'static>>),
    Volume(PixelPipeline<LinearDepthVolume<'static>>),
}

/// The images of the filtered G-buffer, by the kind of filter.
enum Images {
    /// Mip chains of depth and normal; the chain of the colour is the G-buffer's own.
    Mip(Box<[Image; 2]>),
    Volume(Box<Volumes>),
    EdgeAware(Box<EdgeAwareChains>),
}

struct EdgeAwareChains {
    pipeline: PixelPipeline<EdgeAware<'static>>,
    /// The greatest difference of depths in one surface, as a part of the lesser depth.
    tolerance: f32,
    chains: [Image; 3], // depth, normal and colour
}

struct Volumes {
    across: PixelPipeline<PosterBlurAcross<'static>>,
    down: PixelPipeline<PosterBlurDown<'static>>,
    /// Depth, normal and colour of one slice, blurred along x alone.
    between: [Image; 3],
    volumes: [Image; 3], // depth, normal and colour
}

impl FilteredGBufferPass {
    /// Makes the pass for a size in pixels. The edge-aware filter takes depths for one surface that differ by less than
    /// `tolerance`, as a part of the lesser depth.
    ///
    /// # Errors
    /// [`crate::error::Error::Usage`] on a device that can't filter 32-bit depth.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2], filter: PosterFilter, tolerance: f32) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        gpu.require_linear_filter(FORMATS[0])?;
        let usage = stage.target_usage() | U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST;
        let levels = image::full_chain(extent);
        let desc = |n: usize| ImageDesc { name: NAMES[n], format: FORMATS[n], extent, levels: 1, layers: 1, usage };
        let chain = |n| Image::new(gpu, &ImageDesc { levels, ..desc(n) });
        let images = match filter {
            PosterFilter::Mip => Images::Mip(Box::new([chain(0)?, chain(1)?])),
            PosterFilter::EdgeAware => {
                let pipeline = PixelPipeline::new(gpu, stage, FORMATS, &())?;
                let chains = [chain(0)?, chain(1)?, chain(2)?];
                Images::EdgeAware(Box::new(EdgeAwareChains { pipeline, tolerance, chains }))
            }
            PosterFilter::Volume => {
                let volume = |n| Image::volume(gpu, &desc(n), levels.min(MAX_SLICES));
                let plain = |n| Image::new(gpu, &desc(n));
                let volumes = [volume(0)?, volume(1)?, volume(2)?];
                // A sample in the middle of a slice weighs the next slice by 0. In the first frame this slice is not
                // written yet, and its memory may hold NaN. 0 times NaN is NaN.
                FrameContext::new(gpu)?
                    .once(|frame| volumes.iter().try_for_each(|v| frame.clear("volume clear", v.all(), [0.0; 4])))?;
                Images::Volume(Box::new(Volumes {
                    across: PixelPipeline::new(gpu, stage, FORMATS, &())?,
                    down: PixelPipeline::new(gpu, stage, FORMATS, &())?,
                    between: [plain(0)?, plain(1)?, plain(2)?],
                    volumes,
                }))
            }
        };
        let linear_depth = match &images {
            Images::Volume(_) => LinearDepths::Volume(PixelPipeline::new(gpu, stage, [FORMATS[0]], &())?),
            _ => LinearDepths::Flat(PixelPipeline::new(gpu, stage, [FORMATS[0]], &())?),
        };
        Ok(Self { linear_depth, images, prefix: "" })
    }

    /// Returns the pass with a prefix for the names of its passes, for a second G-buffer in a frame.
    pub fn labelled(self, prefix: &'static str) -> Self {
        Self { prefix, ..self }
    }

    /// Records passes "linear depth" and "filter/0", then "filter/1" to the coarsest level or slice.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer<'a>,
        camera: &Camera,
    ) -> Result<FilteredGBuffer<'a>> {
        let prefix = self.prefix;
        match &self.images {
            Images::Mip(chains) => {
                let [depth, normal] = chains.as_ref();
                self.record_linear_depth(frame, gbuffer, camera, depth.level(0))?;
                frame.copy(&format!("{prefix}filter/0 normal"), gbuffer.normal.all(), normal.level(0))?;
                for (name, chain) in [("depth", depth), ("normal", normal), ("color", gbuffer.color)] {
                    for level in 1..chain.levels() {
                        let label = format!("{prefix}filter/{level} {name}");
                        frame.blit(&label, chain.level(level - 1), chain.level(level))?;
                    }
                }
                Ok(FilteredGBuffer { depth, normal, color: gbuffer.color })
            }
            Images::EdgeAware(chains) => {
                let [depth, normal, color] = &chains.chains;
                self.record_linear_depth(frame, gbuffer, camera, depth.level(0))?;
                frame.copy(&format!("{prefix}filter/0 normal"), gbuffer.normal.all(), normal.level(0))?;
                frame.copy(&format!("{prefix}filter/0 color"), gbuffer.color.level(0), color.level(0))?;
                for level in 1..depth.levels() {
                    chains.record_level(frame, level, prefix)?;
                }
                Ok(FilteredGBuffer { depth, normal, color })
            }
            Images::Volume(volumes) => {
                let [depth, normal, color] = &volumes.volumes;
                self.record_linear_depth(frame, gbuffer, camera, depth.slice(0))?;
                frame.copy(&format!("{prefix}filter/0 normal"), gbuffer.normal.all(), normal.slice(0))?;
                frame.copy(&format!("{prefix}filter/0 color"), gbuffer.color.level(0), color.slice(0))?;
                for slice in 1..depth.depth() {
                    volumes.record_slice(frame, slice, prefix)?;
                }
                Ok(FilteredGBuffer { depth, normal, color })
            }
        }
    }

    /// Records pass "linear depth", which writes view-space z, in metres, to a level or slice `to`.
    fn record_linear_depth(&self, frame: &mut Frame, gbuffer: &GBuffer, camera: &Camera, to: ImageSlice) -> Result<()> {
        let block = camera_block(camera, to.extent());
        let (camera, depth_buffer) = (&block, Sampled::nearest(gbuffer.depth.all()));
        let (name, targets) = (format!("{}linear depth", self.prefix), [Target::overwrite(to)]);
        match &self.linear_depth {
            LinearDepths::Flat(pipeline) => {
                frame.pixels(&name, pipeline, targets, &LinearDepth { camera, depth_buffer })
            }
            LinearDepths::Volume(pipeline) => {
                frame.pixels(&name, pipeline, targets, &LinearDepthVolume { camera, depth_buffer })
            }
        }
    }
}

impl EdgeAwareChains {
    /// Records the pass that makes a level of all three chains from the next finer level.
    fn record_level(&self, frame: &mut Frame, level: u32, prefix: &str) -> Result<()> {
        let [depth_source, normal_source, color_source] =
            self.chains.each_ref().map(|chain| Sampled::nearest(chain.level(level - 1)));
        let edge = &EdgeAwareBlock { tolerance: self.tolerance };
        let targets = self.chains.each_ref().map(|chain| Target::overwrite(chain.level(level)));
        let program = EdgeAware { depth_source, normal_source, color_source, edge };
        frame.pixels(&format!("{prefix}filter/{level}"), &self.pipeline, targets, &program)
    }
}

impl Volumes {
    /// Records the two passes that make a slice of all three volumes by blurring the slice before it along x, then y.
    fn record_slice(&self, frame: &mut Frame, slice: u32, prefix: &str) -> Result<()> {
        let inverse_size = self.volumes[0].extent().map(|side| 1.0 / side as f32);
        let step = tap_distance(slice);
        let block_along = |direction: [f32; 2]| PosterBlurBlock {
            inverse_size,
            direction: [direction[0] * step * inverse_size[0], direction[1] * step * inverse_size[1]],
            slice: (slice as f32 - 0.5) / self.volumes[0].depth() as f32, // the middle of the slice before
            into: slice as i32,
        };
        let across = PosterBlurAcross {
            depth_source: Sampled::trilinear(self.volumes[0].all()),
            normal_source: Sampled::trilinear(self.volumes[1].all()),
            color_source: Sampled::trilinear(self.volumes[2].all()),
            blur: &block_along([1.0, 0.0]),
        };
        let down = PosterBlurDown {
            depth_source: Sampled::trilinear(self.between[0].all()),
            normal_source: Sampled::trilinear(self.between[1].all()),
            color_source: Sampled::trilinear(self.between[2].all()),
            blur: &block_along([0.0, 1.0]),
        };
        let between = self.between.each_ref().map(|image| Target::overwrite(image.all()));
        let slices = self.volumes.each_ref().map(|image| Target::overwrite(image.slice(slice)));
        frame.pixels(&format!("{prefix}filter/{slice}h"), &self.across, between, &across)?;
        frame.pixels(&format!("{prefix}filter/{slice}v"), &self.down, slices, &down)
    }
}

/// Variance of the seven taps of thesis §4.3.2, in squares of the distance between two taps.
const TAP_VARIANCE: f32 = 2.0 * (GAUSSIAN_1 as f32 * 1.0 + GAUSSIAN_2 as f32 * 4.0 + GAUSSIAN_3 as f32 * 9.0);

/// Returns the pixels from tap to tap in the blur that makes a slice from the slice before it. Slice n gets the
/// variance of a box of 2^n pixels, 4^n / 12, and the variances of successive blurs add up.
fn tap_distance(slice: u32) -> f32 {
    let variance = |n: u32| 4_f32.powi(n as i32) / 12.0;
    ((variance(slice) - variance(slice - 1)) / TAP_VARIANCE).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_double_their_width() {
        // In closed form: 4^(n-1) / 4 is the variance that slice n adds.
        for slice in 1..MAX_SLICES {
            let expected = 2_f32.powi(slice as i32 - 2) / TAP_VARIANCE.sqrt();
            assert!((tap_distance(slice) / expected - 1.0).abs() < 1e-6, "{slice}");
        }
    }
}
