//! Copies the normals of one face into its layer of the captures' normals (`keep_normal.comp`). A compute program does
//! so, since the two formats differ, and not every driver can blit into that of the layers.

use super::GBuffer;
use crate::error::Result;
use crate::gpu::shader::KeepNormalBlock;
use crate::gpu::{ComputePipeline, Frame, Gpu, Image, Sampled, programs};

/// The pipeline.
pub struct KeepNormalPass {
    pipeline: ComputePipeline<programs::KeepNormal<'static>>,
}

impl KeepNormalPass {
    /// Compiles the pipeline.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self { pipeline: ComputePipeline::new(gpu)? })
    }

    /// Records pass "capture/keep normal", which writes a layer of `normals`, an array of RGBA8 snorm images.
    pub fn record(&self, frame: &mut Frame, face: &GBuffer, normals: &Image, layer: u32) -> Result<()> {
        let [width, height] = normals.extent();
        let program = programs::KeepNormal {
            keep: &KeepNormalBlock { layer },
            normal_buffer: Sampled::nearest(face.normal.level(0)),
            normal_image: normals.all(),
        };
        frame.compute("capture/keep normal", &self.pipeline, &program, [width, height, 1])
    }
}
