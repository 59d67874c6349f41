//! The poster's pre-filtered G-buffer: linear depth, normal and colour, as mip chains by the hardware's
//! filter, or as volumes whose slices are ever wider Gaussians of the original at its full size.

use super::{FilteredGBuffer, GBuffer, PosterFilter, camera_block};
use crate::error::Result;
use crate::gpu::shader::{POSTER_BLUR_ACROSS_FRAG, POSTER_BLUR_DOWN_FRAG, POSTER_LINEAR_DEPTH_FRAG, PosterBlurBlock};
use crate::gpu::{Frame, FrameContext, Gpu, GraphicsPipeline, Image, ImageDesc, ImageSlice, Resource, Target, image};
use crate::scene::Camera;
use ash::vk;

/// Slices of a volume at most: the widest is as wide as a texel of the mip chain's level 7. Each costs as
/// much memory as the whole G-buffer.
pub const MAX_SLICES: u32 = 8;

// Depth, normal, colour: those of the G-buffer, so that they can be copied.
const FORMATS: [vk::Format; 3] =
    [vk::Format::R32_SFLOAT, vk::Format::R16G16B16A16_SFLOAT, vk::Format::R16G16B16A16_SFLOAT];
const NAMES: [&str; 3] = ["filtered depth", "filtered normal", "filtered color"];

/// Pipelines and images of one size.
pub struct FilteredGBufferPass {
    linear_depth: GraphicsPipeline,
    images: Images,
}

enum Images {
    /// Depth and normal; the colour's chain is the G-buffer's own.
    Mip(Box<[Image; 2]>),
    Volume(Box<Volumes>),
}

struct Volumes {
    across: GraphicsPipeline,
    down: GraphicsPipeline,
    /// Between the two directions.
    between: [Image; 3],
    volumes: [Image; 3],
}

impl FilteredGBufferPass {
    /// For a size in pixels.
    ///
    /// # Errors
    /// [`crate::error::Error::Usage`] on a device that can't filter 32-bit depth.
    pub fn new(gpu: &Gpu, extent: [u32; 2], filter: PosterFilter) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        gpu.require_linear_filter(FORMATS[0])?;
        let usage = U::COLOR_ATTACHMENT | U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST;
        let levels = image::full_chain(extent);
        let desc = |n: usize| ImageDesc { name: NAMES[n], format: FORMATS[n], extent, levels: 1, layers: 1, usage };
        let images = match filter {
            PosterFilter::Mip => {
                let chain = |n| Image::new(gpu, &ImageDesc { levels, ..desc(n) });
                Images::Mip(Box::new([chain(0)?, chain(1)?]))
            }
            PosterFilter::Volume => {
                let volume = |n| Image::volume(gpu, &desc(n), levels.min(MAX_SLICES));
                let plain = |n| Image::new(gpu, &desc(n));
                let volumes = [volume(0)?, volume(1)?, volume(2)?];
                // A sample in the middle of a slice weighs its neighbours with 0, and the next slice is not written yet
                // in the first frame: what memory held before may be no number, and 0 times that is none either.
                FrameContext::new(gpu)?
                    .once(|frame| volumes.iter().try_for_each(|v| frame.clear("volume clear", v.all(), [0.0; 4])))?;
                Images::Volume(Box::new(Volumes {
                    across: GraphicsPipeline::fullscreen(gpu, &POSTER_BLUR_ACROSS_FRAG, &FORMATS)?,
                    down: GraphicsPipeline::fullscreen(gpu, &POSTER_BLUR_DOWN_FRAG, &FORMATS)?,
                    between: [plain(0)?, plain(1)?, plain(2)?],
                    volumes,
                }))
            }
        };
        let linear_depth = GraphicsPipeline::fullscreen(gpu, &POSTER_LINEAR_DEPTH_FRAG, &FORMATS[..1])?;
        Ok(Self { linear_depth, images })
    }

    /// Passes "linear depth" and "filter/0", then "filter/1" to the coarsest level or slice.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer<'a>,
        camera: &Camera,
    ) -> Result<FilteredGBuffer<'a>> {
        match &self.images {
            Images::Mip(chains) => {
                let [depth, normal] = chains.as_ref();
                self.linear_depth(frame, gbuffer, camera, depth.level(0))?;
                frame.copy("filter/0 normal", gbuffer.normal.all(), normal.level(0))?;
                for (name, chain) in [("depth", depth), ("normal", normal), ("color", gbuffer.color)] {
                    for level in 1..chain.levels() {
                        frame.blit(&format!("filter/{level} {name}"), chain.level(level - 1), chain.level(level))?;
                    }
                }
                Ok(FilteredGBuffer { depth, normal, color: gbuffer.color })
            }
            Images::Volume(v) => {
                let [depth, normal, color] = &v.volumes;
                self.linear_depth(frame, gbuffer, camera, depth.slice(0))?;
                frame.copy("filter/0 normal", gbuffer.normal.all(), normal.slice(0))?;
                frame.copy("filter/0 color", gbuffer.color.level(0), color.slice(0))?;
                for slice in 1..depth.depth() {
                    v.blur(frame, slice)?;
                }
                Ok(FilteredGBuffer { depth, normal, color })
            }
        }
    }

    fn linear_depth(&self, frame: &mut Frame, gbuffer: &GBuffer, camera: &Camera, to: ImageSlice) -> Result<()> {
        let block = camera_block(camera, to.extent());
        let resources = [
            ("camera", Resource::Uniform(bytemuck::bytes_of(&block))),
            ("depth_buffer", Resource::nearest(gbuffer.depth.all())),
        ];
        frame.fullscreen("linear depth", &self.linear_depth, &[Target::overwrite(to)], &resources, &[])
    }
}

impl Volumes {
    /// A slice from the one below it.
    fn blur(&self, frame: &mut Frame, slice: u32) -> Result<()> {
        let inverse_size = self.volumes[0].extent().map(|v| 1.0 / v as f32);
        let step = tap_distance(slice);
        let push = |direction: [f32; 2]| PosterBlurBlock {
            inverse_size,
            direction: [direction[0] * step * inverse_size[0], direction[1] * step * inverse_size[1]],
            slice: (slice as f32 - 0.5) / self.volumes[0].depth() as f32,
            ..PosterBlurBlock::default()
        };
        let names = ["depth_source", "normal_source", "color_source"];
        let volumes = [0, 1, 2].map(|n| (names[n], Resource::trilinear(self.volumes[n].all())));
        let plain = [0, 1, 2].map(|n| (names[n], Resource::trilinear(self.between[n].all())));
        let between = [0, 1, 2].map(|n| Target::overwrite(self.between[n].all()));
        let slices = [0, 1, 2].map(|n| Target::overwrite(self.volumes[n].slice(slice)));
        let (h, v) = (push([1.0, 0.0]), push([0.0, 1.0]));
        frame.fullscreen(&format!("filter/{slice}h"), &self.across, &between, &volumes, bytemuck::bytes_of(&h))?;
        frame.fullscreen(&format!("filter/{slice}v"), &self.down, &slices, &plain, bytemuck::bytes_of(&v))
    }
}

/// Variance of the seven taps of thesis §4.3.2, in squares of their distance.
const TAP_VARIANCE: f32 = 2.0 * (0.233 * 1.0 + 0.028 * 4.0 + 0.002 * 9.0);

/// Pixels between the taps that make a slice from the one below it, so that each slice is as wide as the
/// texels of its mip level: a box of 2^n pixels has the variance 4^n / 12, and variances add up.
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
