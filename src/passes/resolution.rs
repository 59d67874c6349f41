//! Reflections at a lower resolution (thesis §4.4): makes a smaller G-buffer, and scales a reflection up to full size.

use super::triangle_scene::TRIANGLE;
use super::{GBuffer, LIT_COLOR, MATERIAL, NORMAL, Reflection, camera_block};
use crate::error::Result;
use crate::gpu::shader::{DownsampleBlock, UpsampleBlock};
use crate::gpu::{Frame, Gpu, Image, ImageDesc, PixelPipeline, Sampled, ShaderStage, Target, image, programs};
use ash::vk;
use ssct_ground::scene::{Camera, ProjectionKind};

const REFLECTION: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
/// Format of the smaller depth: no depth format, since a shader writes it as a colour.
const DEPTH: vk::Format = vk::Format::R32_SFLOAT;

/// Returns width and height of the smaller G-buffer: those of the full one, divided and rounded up.
pub fn divided(extent: [u32; 2], divisor: u32) -> [u32; 2] {
    extent.map(|v| v.div_ceil(divisor))
}

/// Makes a smaller G-buffer of a full one.
pub struct DownsamplePass {
    pipeline: PixelPipeline<programs::Downsample<'static>>,
    divisor: u32,
    depth: Image,
    normal: Image,
    material: Image,
    color: Image,
    /// The pipeline that also writes which triangle each pixel shows, and the image for it; `None` if not wanted.
    numbered: Option<(PixelPipeline<programs::DownsampleNumbered<'static>>, Image)>,
    label: &'static str,
}

impl DownsamplePass {
    /// Makes the pass for G-buffers of a size in pixels, with blocks of `divisor` × `divisor` pixels.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2], divisor: u32) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let extent = divided(extent, divisor);
        let small_image = |name, format, levels, more| {
            let usage = more | stage.target_usage() | U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST;
            Image::new(gpu, &ImageDesc { name, format, extent, levels, layers: 1, usage })
        };
        Ok(Self {
            pipeline: PixelPipeline::new(gpu, stage, [DEPTH, NORMAL, MATERIAL, LIT_COLOR], &())?,
            divisor,
            depth: small_image("small depth", DEPTH, 1, U::empty())?,
            normal: small_image("small normal", NORMAL, 1, U::STORAGE)?,
            material: small_image("small material", MATERIAL, 1, U::STORAGE)?,
            color: small_image("small color", LIT_COLOR, image::full_chain(extent), U::STORAGE)?,
            numbered: None,
            label: "downsample",
        })
    }

    /// Returns the pass for G-buffers that say which triangle each pixel shows ([`GBuffer::triangle`]). A small pixel
    /// then also gets the triangle of its block's first pixel, and rays among triangles begin on it. A small pixel has
    /// that pixel's depth, so that rays from its own point would begin beside the surface.
    pub fn numbered(self, gpu: &Gpu, stage: ShaderStage) -> Result<Self> {
        let pipeline = PixelPipeline::new(gpu, stage, [DEPTH, NORMAL, MATERIAL, LIT_COLOR, TRIANGLE], &())?;
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::STORAGE;
        let extent = self.depth.extent();
        let desc = ImageDesc { name: "small triangle", format: TRIANGLE, extent, levels: 1, layers: 1, usage };
        Ok(Self { numbered: Some((pipeline, Image::new(gpu, &desc)?)), ..self })
    }

    /// Returns the pass with another label, for a second G-buffer in a frame.
    pub fn labelled(self, label: &'static str) -> Self {
        Self { label, ..self }
    }

    /// Records pass "downsample", or the pass of its label, and returns the smaller G-buffer.
    pub fn record<'a>(&'a self, frame: &mut Frame, gbuffer: &GBuffer) -> Result<GBuffer<'a>> {
        let [depth, normal, material] = [&self.depth, &self.normal, &self.material].map(|image| image.all());
        let targets = [depth, normal, material, self.color.level(0)].map(Target::overwrite);
        let [depth_buffer, normal_buffer, material_buffer, color_buffer] =
            [gbuffer.depth.all(), gbuffer.normal.all(), gbuffer.material.all(), gbuffer.color.level(0)]
                .map(Sampled::nearest);
        let block = &DownsampleBlock { divisor: self.divisor as i32 };
        let triangle = match (&self.numbered, gbuffer.triangle) {
            (Some((pipeline, small)), Some(triangle)) => {
                let [depth, normal, material, color] = targets;
                let targets = [depth, normal, material, color, Target::overwrite(small.all())];
                let triangle_buffer = triangle.all();
                let program = programs::DownsampleNumbered {
                    depth_buffer,
                    normal_buffer,
                    material_buffer,
                    color_buffer,
                    triangle_buffer,
                    block,
                };
                frame.pixels(self.label, pipeline, targets, &program)?;
                Some(small)
            }
            _ => {
                let program =
                    programs::Downsample { depth_buffer, normal_buffer, material_buffer, color_buffer, block };
                frame.pixels(self.label, &self.pipeline, targets, &program)?;
                None
            }
        };
        Ok(GBuffer {
            depth: &self.depth,
            normal: &self.normal,
            material: &self.material,
            color: &self.color,
            triangle,
            reflectors: gbuffer.reflectors,
        })
    }
}

/// Scales a reflection to full size.
pub struct UpsamplePass {
    pipeline: PixelPipeline<programs::Upsample<'static>>,
    divisor: u32,
    reflection: Image,
}

impl UpsamplePass {
    /// Makes the pass for a full size in pixels, a kind of projection, and blocks of `divisor` × `divisor` pixels.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2], kind: ProjectionKind, divisor: u32) -> Result<Self> {
        let constants = programs::UpsampleConstants { orthographic: kind.is_orthographic() };
        Ok(Self {
            pipeline: PixelPipeline::new(gpu, stage, [REFLECTION], &constants)?,
            divisor,
            reflection: Image::target_in(gpu, stage, "upsampled reflection", REFLECTION, extent)?,
        })
    }

    /// Records pass "upsample", which scales `small` up to the size of the G-buffer.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        camera: &Camera,
        small: Reflection,
    ) -> Result<Reflection<'a>> {
        let camera = camera_block(camera, self.reflection.extent());
        frame.pixels(
            "upsample",
            &self.pipeline,
            [Target::overwrite(self.reflection.all())],
            &programs::Upsample {
                camera: &camera,
                depth_buffer: Sampled::nearest(gbuffer.depth.all()),
                normal_buffer: Sampled::nearest(gbuffer.normal.all()),
                material_buffer: Sampled::nearest(gbuffer.material.all()),
                small_reflection: Sampled::nearest(small.0.all()),
                block: &UpsampleBlock { divisor: self.divisor as i32 },
            },
        )?;
        Ok(Reflection(&self.reflection))
    }
}
