//! Billboard reflections: impostor quads that each pixel's mirror ray is traced against (Schmidt 2013, section 5.3, listings 2 and
//! 3). The pass adds what the listings lack, a test of the depth buffer for occlusion, and a blur. The method `ibr` draws its
//! planes with this pass, too.

use super::scene_data::{SceneData, check_at_most};
use super::{GBuffer, LIT_COLOR, Reflection, camera_block};
use crate::error::Result;
use crate::gpu::programs::{Billboard, BillboardConstants};
use crate::gpu::shader::{BillboardBlock, ImpostorData};
use crate::gpu::{Frame, Gpu, Image, PixelPipeline, Sampled, ShaderStage, Target};
use glam::Mat4;
use ssct_ground::math::constants::{
    self, BLUR_DISTANCE, BLUR_NONE, BLUR_ROUGHNESS, ORDER_NEAREST, ORDER_PRINTED, ORDER_UNBROKEN,
};
use ssct_ground::parameter::choices;
use ssct_ground::scene::{Camera, Impostor};

/// The most impostors that a scene can have for this pass.
pub const MAX_IMPOSTORS: usize = constants::MAX_IMPOSTORS as usize;

choices! {
    /// Which of several billboards on a ray shows.
    pub enum Order {
        /// The order of listing 2: the last of the list, and none after the first that lies behind the pixel.
        Printed(ORDER_PRINTED) = "printed",
        /// The last of the list that lies ahead.
        Unbroken(ORDER_UNBROKEN) = "unbroken",
        /// The nearest, blended over those behind it by its alpha, and from behind none.
        Nearest(ORDER_NEAREST) = "nearest",
    }
}

choices! {
    /// What hides a billboard.
    pub enum Occlusion {
        /// Nothing, as published (figure 41).
        None = "none",
        /// What the depth buffer shows on the way to it.
        Depth = "depth",
    }
}

choices! {
    /// How wide a reflected ray is where it meets a billboard.
    pub enum Blur {
        /// No width, whatever the roughness, as published.
        None(BLUR_NONE) = "none",
        /// The width of the cone of the surface's roughness, which begins at the surface.
        Roughness(BLUR_ROUGHNESS) = "roughness",
        /// The width of that cone if it began at the viewer, so that what is farther away is blurred more.
        Distance(BLUR_DISTANCE) = "distance",
    }
}

/// How billboards are drawn.
#[derive(Debug, Clone, Copy)]
pub struct Drawing {
    /// Which of several billboards on a ray shows.
    pub order: Order,
    /// What hides a billboard.
    pub occlusion: Occlusion,
    /// How wide a ray is at a billboard.
    pub blur: Blur,
    /// The brightness of the glow beside an edge, as a share of the image's colour there, and the reach of the glow in
    /// metres. Only a pass that was made with a glow draws it.
    pub glow: (f32, f32),
    /// Whether the images' colours are multiplied by their alpha already; read with [`Order::Nearest`] only.
    pub premultiplied: bool,
}

/// Pipeline and image of one size.
pub struct BillboardPass {
    pipeline: PixelPipeline<Billboard<'static>>,
    reflection: Image,
    label: &'static str,
}

impl BillboardPass {
    /// Makes the pass and its image of a size in pixels. `glow` says whether the pass can draw a glow ([`Drawing::glow`]).
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2], glow: bool) -> Result<Self> {
        Ok(Self {
            pipeline: PixelPipeline::new(gpu, stage, [LIT_COLOR], &BillboardConstants { glow })?,
            reflection: Image::target_in(gpu, stage, "billboard reflection", LIT_COLOR, extent)?,
            label: "billboards",
        })
    }

    /// Returns the pass with another label.
    pub fn labelled(self, label: &'static str) -> Self {
        Self { label, ..self }
    }

    /// Checks that a scene has no more impostors than the pass can take.
    ///
    /// # Errors
    /// [`Usage`](crate::error::Error::Usage) if the scene has more than [`MAX_IMPOSTORS`].
    pub fn check(scene: &SceneData, method: &str) -> Result<()> {
        check_at_most("impostors", scene.impostors.len(), MAX_IMPOSTORS, method)
    }

    /// Records pass "billboards", or the pass of its label, which reflects the first [`MAX_IMPOSTORS`] impostors of a
    /// scene. If `images` is given, its n-th image replaces the image of the n-th impostor.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        scene: &SceneData,
        camera: &Camera,
        images: Option<&[Image]>,
        drawing: Drawing,
    ) -> Result<Reflection<'a>> {
        let camera_data = camera_block(camera, self.reflection.extent());
        let impostors = &scene.impostors[..scene.impostors.len().min(MAX_IMPOSTORS)];
        let image =
            |n: usize, impostor: &Impostor| images.map_or(&scene.textures[impostor.texture], |images| &images[n]);
        let (glow, glow_width_m) = drawing.glow;
        let mut block = BillboardBlock {
            billboardCount: impostors.len() as i32,
            order: drawing.order as i32,
            occlusion: i32::from(drawing.occlusion == Occlusion::Depth),
            blur: drawing.blur as i32,
            premultiplied: i32::from(drawing.premultiplied),
            glow,
            glowWidth: glow_width_m,
            ..BillboardBlock::default()
        };
        let mut textures = [Sampled::trilinear(scene.white.all()); MAX_IMPOSTORS];
        for (n, impostor) in impostors.iter().enumerate() {
            block.Impostor[n] = ImpostorData { ModelMatrix: model_matrix(impostor).to_cols_array_2d() };
            textures[n] = Sampled::trilinear(image(n, impostor).all());
        }
        frame.pixels(
            self.label,
            &self.pipeline,
            [Target::overwrite(self.reflection.all())],
            &Billboard {
                camera: &camera_data,
                BillboardBlock: &block,
                ImpostorTex: textures,
                depth_buffer: Sampled::nearest(gbuffer.depth.all()),
                normal_buffer: Sampled::nearest(gbuffer.normal.all()),
                material_buffer: Sampled::nearest(gbuffer.material.all()),
            },
        )?;
        Ok(Reflection(&self.reflection))
    }
}

/// Returns the matrix from the standard quad (figure 37: 1 × 1 in x and z) to an impostor's rectangle in the world. The
/// quad's texture coordinates run along +x and −z, and (0, 0) is the top left of the impostor's image.
fn model_matrix(impostor: &Impostor) -> Mat4 {
    Mat4::from_cols(
        (2.0 * impostor.half_u).extend(0.0),
        impostor.normal().extend(0.0),
        (-2.0 * impostor.half_v).extend(0.0),
        impostor.centre.extend(1.0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_standard_quad_becomes_the_impostor() {
        let (centre, half_u, half_v) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.0, 0.0, 2.0), Vec3::new(0.0, -0.5, 0.0));
        let matrix = model_matrix(&Impostor { name: String::new(), centre, half_u, half_v, texture: 0 });
        // Texture coordinates (0, 0) are at x = −½, z = ½: the first vertex that the listing intersects.
        let point = |u: f32, v: f32| matrix.transform_point3(Vec3::new(u - 0.5, 0.0, 0.5 - v));
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.25, 0.75)] {
            let place = centre + (2.0 * u - 1.0) * half_u + (2.0 * v - 1.0) * half_v;
            assert!(point(u, v).distance(place) < 1e-6, "{u}, {v}: {} is not {place}", point(u, v));
        }
    }
}
