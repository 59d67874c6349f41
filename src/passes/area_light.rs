//! Highlights of lights with an extent (thesis §3.1.1): the share of each pixel's reflection lobe that the light fills, in closed
//! form. `area_light/share.glsl` has the formulas, and `tests/suite/area_light.rs` tests their accuracy.

use super::scene_data::{SceneData, check_at_most};
use super::{GBuffer, LIT_COLOR, Reflection, camera_block};
use crate::error::Result;
use crate::gpu::shader::{AreaLightBlock, AreaLightData};
use crate::gpu::{Frame, Gpu, Image, PixelPipeline, Sampled, ShaderStage, Target, programs};
use ssct_ground::math::constants::{self, SHAPE_CAPSULE, SHAPE_CUBOID, SHAPE_CYLINDER, SHAPE_RECTANGLE, SHAPE_SPHERE};
use ssct_ground::scene::{AreaLight, AreaShape, Camera};

/// The most area lights that a scene can have for this pass.
pub const MAX_AREA_LIGHTS: usize = constants::MAX_AREA_LIGHTS as usize;

/// Pipeline and image of one size.
pub struct AreaLightPass {
    pipeline: PixelPipeline<programs::AreaLight<'static>>,
    reflection: Image,
}

impl AreaLightPass {
    /// Makes the pass and its image of a size in pixels.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2]) -> Result<Self> {
        Ok(Self {
            pipeline: PixelPipeline::new(gpu, stage, [LIT_COLOR], &())?,
            reflection: Image::target_in(gpu, stage, "area lights", LIT_COLOR, extent)?,
        })
    }

    /// Checks that a scene has no more area lights than the pass can take.
    ///
    /// # Errors
    /// [`Usage`](crate::error::Error::Usage) if the scene has more than [`MAX_AREA_LIGHTS`].
    pub fn check(scene: &SceneData) -> Result<()> {
        check_at_most("area lights", scene.area_lights.len(), MAX_AREA_LIGHTS, "area-light")
    }

    /// Records pass "area lights".
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        scene: &SceneData,
        camera: &Camera,
    ) -> Result<Reflection<'a>> {
        let camera_data = camera_block(camera, self.reflection.extent());
        let lights = light_block(&scene.area_lights, camera);
        frame.pixels(
            "area lights",
            &self.pipeline,
            [Target::overwrite(self.reflection.all())],
            &programs::AreaLight {
                camera: &camera_data,
                area: &lights,
                depth_buffer: Sampled::nearest(gbuffer.depth.all()),
                normal_buffer: Sampled::nearest(gbuffer.normal.all()),
                material_buffer: Sampled::nearest(gbuffer.material.all()),
            },
        )?;
        Ok(Reflection(&self.reflection))
    }
}

/// Returns the first [`MAX_AREA_LIGHTS`] lights in view space and metres, packed as `area_light.frag` reads them.
fn light_block(lights: &[AreaLight], camera: &Camera) -> AreaLightBlock {
    let mut block = AreaLightBlock { count: lights.len().min(MAX_AREA_LIGHTS) as u32, ..AreaLightBlock::default() };
    let place = |point| camera.world_to_view.transform_point3(point);
    let along = |vector| camera.world_to_view.transform_vector3(vector).extend(0.0).to_array();
    for (data, light) in block.lights.iter_mut().zip(lights) {
        let (kind, a, b, c) = match light.shape {
            AreaShape::Sphere { centre, radius } => (SHAPE_SPHERE, place(centre).extend(radius), [0.0; 4], [0.0; 4]),
            AreaShape::Capsule { a, b, radius } => {
                (SHAPE_CAPSULE, place(a).extend(radius), place(b).extend(0.0).to_array(), [0.0; 4])
            }
            AreaShape::Cylinder { a, b, radius } => {
                (SHAPE_CYLINDER, place(a).extend(radius), place(b).extend(0.0).to_array(), [0.0; 4])
            }
            AreaShape::Cuboid { centre, half_u, half_v, half_w } => {
                (SHAPE_CUBOID, place(centre).extend(half_w), along(half_u), along(half_v))
            }
            AreaShape::Rectangle { centre, half_u, half_v } => {
                (SHAPE_RECTANGLE, place(centre).extend(0.0), along(half_u), along(half_v))
            }
        };
        *data = AreaLightData { a: a.to_array(), b, c, radiance: light.radiance.extend(kind as f32).to_array() };
    }
    block
}
