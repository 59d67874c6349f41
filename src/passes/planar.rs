//! Planar reflections (thesis §3.1.2): the passes before and after the mirrored scene is drawn. The scene passes draw
//! and light the mirrored scene, as any scene, with a mirrored camera.

use super::{GBuffer, LIT_COLOR, Reflection, camera_block};
use crate::error::Result;
use crate::gpu::programs::{PlanarCopy, PlanarLookup, PlanarMark};
use crate::gpu::shader::PlaneBlock;
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, PixelPipeline, Sampled, ShaderStage, Target};
use ash::vk;
use glam::Vec4;
use ssct_ground::parameter::choices;
use ssct_ground::scene::Camera;

choices! {
    /// How a mirror gets its mirrored scene.
    pub enum MirrorDrawing {
        /// Drawn only where the stencil marks the mirror: the thesis's first method.
        Stencil = "stencil",
        /// Drawn whole into a render target, which is a texture on the mirror: its second.
        Target = "target",
    }
}

/// The most planes that one frame mirrors the scene at. Each plane draws the scene once more.
pub const MAX_PLANES: u32 = 8;

/// Pipelines and the image of one size.
pub struct PlanarPass {
    mark: GraphicsPipeline<PlanarMark<'static>>,
    lookup: PixelPipeline<PlanarLookup<'static>>,
    copy: PixelPipeline<PlanarCopy<'static>>,
    reflection: Image,
}

impl PlanarPass {
    /// Makes the pass and its image of a size in pixels. `stencil` is the format of the depth with the stencil to mark.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2], stencil: vk::Format) -> Result<Self> {
        Ok(Self {
            mark: GraphicsPipeline::marking(gpu, stencil)?,
            lookup: PixelPipeline::new(gpu, stage, [LIT_COLOR], &())?,
            copy: PixelPipeline::new(gpu, stage, [LIT_COLOR], &())?,
            reflection: Image::target_in(gpu, stage, "planar reflection", LIT_COLOR, extent)?,
        })
    }

    /// The reflection, which the passes below write.
    pub fn reflection(&self) -> Reflection<'_> {
        Reflection(&self.reflection)
    }

    /// Records pass "mirror clear", which clears the reflection.
    pub fn record_clear(&self, frame: &mut Frame) -> Result<()> {
        frame.clear("mirror clear", self.reflection.all(), [0.0; 4])
    }

    /// Records pass "mirror mark", which marks the pixels of a plane in the stencil of `marked`. The plane is unit
    /// normal and offset in world space: a point p lies in it if dot(normal, p) + offset = 0.
    pub fn record_mark(
        &self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        camera: &Camera,
        plane: Vec4,
        marked: &Image,
    ) -> Result<()> {
        let block = camera_block(camera, self.reflection.extent());
        frame.mark(
            "mirror mark",
            &self.mark,
            marked.all(),
            &PlanarMark {
                camera: &block,
                depth_buffer: Sampled::nearest(gbuffer.depth.all()),
                material_buffer: Sampled::nearest(gbuffer.material.all()),
                mirror: &plane_block(camera, plane),
            },
        )
    }

    /// Records pass "mirror copy", which copies the mirrored scene into the reflection, wherever it was drawn.
    pub fn record_copy(&self, frame: &mut Frame, mirrored: &GBuffer) -> Result<()> {
        frame.pixels(
            "mirror copy",
            &self.copy,
            [Target::kept(self.reflection.all())],
            &PlanarCopy {
                mirrored_depth: Sampled::nearest(mirrored.depth.all()),
                mirrored_color: Sampled::nearest(mirrored.color.level(0)),
            },
        )
    }

    /// Records pass "mirror lookup", which shows the mirrored scene as a texture on the pixels of a plane (world space).
    pub fn record_lookup(
        &self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        camera: &Camera,
        plane: Vec4,
        mirrored: &GBuffer,
    ) -> Result<()> {
        let block = camera_block(camera, self.reflection.extent());
        frame.pixels(
            "mirror lookup",
            &self.lookup,
            [Target::kept(self.reflection.all())],
            &PlanarLookup {
                camera: &block,
                depth_buffer: Sampled::nearest(gbuffer.depth.all()),
                material_buffer: Sampled::nearest(gbuffer.material.all()),
                mirrored_depth: Sampled::nearest(mirrored.depth.all()),
                mirrored_color: Sampled::nearest(mirrored.color.level(0)),
                mirror: &plane_block(camera, plane),
            },
        )
    }
}

fn plane_block(camera: &Camera, plane: Vec4) -> PlaneBlock {
    PlaneBlock { plane: camera.plane_in_view(plane).to_array() }
}
