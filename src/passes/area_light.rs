//! Highlights of lights with an extent (thesis §3.1.1): which share of each pixel's reflection lobe the
//! light fills, in closed form. `area_light/share.glsl` says how, `tests/suite/area_light.rs` how well.

use super::scene_data::{SceneData, at_most};
use super::{GBuffer, LIT_COLOR, Reflection, camera_block};
use crate::error::Result;
use crate::gpu::shader::{AREA_LIGHT_AREA_LIGHT_FRAG, AreaLightBlock, AreaLightData};
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, Resource, Target};
use crate::scene::{AreaLight, AreaShape, Camera};

/// The most area lights that a scene can have for this pass; the size of the list in
/// `area_light/area_light.frag`.
pub const MAX_AREA_LIGHTS: usize = 16;

/// Pipeline and image of one size.
pub struct AreaLightPass {
    pipeline: GraphicsPipeline,
    reflection: Image,
}

impl AreaLightPass {
    /// An image of a size in pixels.
    pub fn new(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        Ok(Self {
            pipeline: GraphicsPipeline::fullscreen(gpu, &AREA_LIGHT_AREA_LIGHT_FRAG, &[LIT_COLOR])?,
            reflection: Image::target(gpu, "area lights", LIT_COLOR, extent)?,
        })
    }

    /// Whether a scene has no more area lights than the pass can take.
    ///
    /// # Errors
    /// [`Usage`](crate::error::Error::Usage) if it has more than [`MAX_AREA_LIGHTS`].
    pub fn check(scene: &SceneData) -> Result<()> {
        at_most("area lights", scene.area_lights.len(), MAX_AREA_LIGHTS, "area-light")
    }

    /// Pass "area lights".
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        scene: &SceneData,
        camera: &Camera,
    ) -> Result<Reflection<'a>> {
        let camera_data = camera_block(camera, self.reflection.extent());
        let lights = light_block(&scene.area_lights, camera);
        frame.fullscreen(
            "area lights",
            &self.pipeline,
            &[Target::overwrite(self.reflection.all())],
            &[
                ("camera", Resource::Uniform(bytemuck::bytes_of(&camera_data))),
                ("area", Resource::Uniform(bytemuck::bytes_of(&lights))),
                ("depth_buffer", Resource::nearest(gbuffer.depth.all())),
                ("normal_buffer", Resource::nearest(gbuffer.normal.all())),
                ("material_buffer", Resource::nearest(gbuffer.material.all())),
            ],
            &[],
        )?;
        Ok(Reflection(&self.reflection))
    }
}

/// Lights in view space.
fn light_block(lights: &[AreaLight], camera: &Camera) -> AreaLightBlock {
    let mut block = AreaLightBlock { count: lights.len().min(MAX_AREA_LIGHTS) as u32, ..AreaLightBlock::default() };
    let place = |p| camera.world_to_view.transform_point3(p);
    let along = |v| camera.world_to_view.transform_vector3(v).extend(0.0).to_array();
    for (data, light) in block.lights.iter_mut().zip(lights) {
        // The kinds are those of `area_light/area_light.frag`.
        let (kind, a, b, c) = match light.shape {
            AreaShape::Sphere { centre, radius } => (0.0, place(centre).extend(radius), [0.0; 4], [0.0; 4]),
            AreaShape::Capsule { a, b, radius } => {
                (1.0, place(a).extend(radius), place(b).extend(0.0).to_array(), [0.0; 4])
            }
            AreaShape::Rectangle { centre, half_u, half_v } => {
                (2.0, place(centre).extend(0.0), along(half_u), along(half_v))
            }
        };
        *data = AreaLightData { a: a.to_array(), b, c, radiance: light.radiance.extend(kind).to_array() };
    }
    block
}
