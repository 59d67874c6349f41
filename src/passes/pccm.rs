//! The pass of `pccm`, which blends the colours of two cube maps, each looked up with a correction of parallax by its
//! proxy box (Schmidt 2013, section 5.2, listing 1, and section 6). For `local-map` it leaves the correction out.

use super::{CubeMap, GBuffer, LIT_COLOR, Reflection, camera_block};
use crate::error::Result;
use crate::gpu::shader::{LocalCubeMap, PccmBlock};
use crate::gpu::{Frame, Gpu, Image, PixelPipeline, Sampled, ShaderStage, Target, programs};
use ssct_ground::scene::{Camera, Probe, ProjectionKind};

/// Pipeline and image of one size.
pub struct PccmPass {
    pipeline: PixelPipeline<programs::Pccm<'static>>,
    reflection: Image,
    label: &'static str,
}

impl PccmPass {
    /// Makes the pass for a size in pixels and a kind of projection, with the correction of parallax or without.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2], kind: ProjectionKind, corrected: bool) -> Result<Self> {
        let constants = programs::PccmConstants { corrected, orthographic: kind.is_orthographic() };
        let label = if corrected { "pccm" } else { "local map" };
        Ok(Self {
            pipeline: PixelPipeline::new(gpu, stage, [LIT_COLOR], &constants)?,
            reflection: Image::target_in(gpu, stage, label, LIT_COLOR, extent)?,
            label,
        })
    }

    /// Records pass "pccm" or "local map" with two cube maps, which may be the same. The reflection does not fade.
    pub fn record(
        &self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        camera: &Camera,
        maps: [(&Probe, CubeMap); 2],
    ) -> Result<Reflection<'_>> {
        let camera = camera_block(camera, gbuffer.depth.extent());
        let [first_map, second_map] = maps.map(|(_, map)| Sampled::trilinear(map.0.all()));
        let block = PccmBlock { maps: maps.map(|(probe, _)| local_cube_map(probe)) };
        let program = programs::Pccm {
            camera: &camera,
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            normal_buffer: Sampled::nearest(gbuffer.normal.all()),
            material_buffer: Sampled::nearest(gbuffer.material.all()),
            pccm: &block,
            first_map,
            second_map,
        };
        frame.pixels(self.label, &self.pipeline, [Target::overwrite(self.reflection.all())], &program)?;
        Ok(Reflection(&self.reflection))
    }
}

/// Returns the place and the proxy box of a cube map, in the world and in metres.
fn local_cube_map(probe: &Probe) -> LocalCubeMap {
    LocalCubeMap {
        position: probe.position.extend(1.0).to_array(),
        box_min: probe.bounds.min.extend(1.0).to_array(),
        box_max: probe.bounds.max.extend(1.0).to_array(),
    }
}
