//! `ibr`: image-based reflections (thesis §3.1.4). A proxy is a box in the scene. The content of the box is drawn and
//! lit into an image on the box's middle plane, and each pixel's mirror ray is tested against these planes. A lookup
//! reads the mip level that fits the width of the ray's cone, so that gloss costs nothing.
//!
//! The boxes are the scene's impostors (`[[impostor]]`) with a depth. Unlike `billboard`, the method needs no image by
//! an artist: a box shows its content as the scene passes light it, seen from the front.

use super::capture::captured_materials;
use super::needs::Need;
use super::{Input, Intermediate, Method, MethodInfo, MethodOutput, SceneInput};
use crate::error::Result;
use crate::gpu::{Frame, FrameContext, Gpu, Image, ImageDesc, image};
use crate::passes::billboard::{BillboardPass, Blur, Drawing, Occlusion, Order};
use crate::passes::gbuffer::GBufferPass;
use crate::passes::lighting::LightingPass;
use crate::passes::{Content, LIT_COLOR};
use ash::vk;
use glam::camera::lh::view::look_to_mat4;
use ssct_ground::parameter::{Parameter, Parameters, Preset, parameters};
use ssct_ground::scene::{Camera, Impostor, Lens, Material};

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    needs: &[Need::Impostors],
    parameters: IbrParams::table,
    ..MethodInfo::scene(
        "ibr",
        "boxes of the scene rendered into images on planes, which rays are tested against",
        "Hermanns 2015, §3.1.4",
        |gpu, request| {
            Ok(Box::new(IbrMethod {
                pass: BillboardPass::new(gpu, request.setup.stage(), request.setup.extent, false)?.labelled("planes"),
                parameters: request.setup.parameters(),
                images: Vec::new(),
                drawn_with: Vec::new(),
            }))
        },
    )
};

parameters! {
    /// Parameters of `ibr`. The thesis gives no numbers.
    pub struct IbrParams {
        /// How far a box reaches before its plane, and behind it.
        ibr_depth: f32 = Parameter::new(0.5)
            .above(0.0, 1000.0)
            .unit("m")
            .sweep(Preset::Published, &[0.1, 2.0])
            .source("Hermanns 2015, §3.1.4 leaves it to an artist"),
        /// Texels along the longer side of an image.
        ibr_side: u32 = Parameter::new(256)
            .within(1, 4096)
            .unit("texels")
            .sweep(Preset::Published, &[64])
            .source("not in Hermanns 2015"),
    }
}

/// The pass, and an image for each box once these are drawn.
struct IbrMethod {
    pass: BillboardPass,
    parameters: IbrParams,
    images: Vec<Image>,
    /// The materials that the images were drawn with.
    drawn_with: Vec<Material>,
}

/// Distance of the camera from the middle of a box, in multiples of the box's greatest half side. At this distance the
/// rays of sight are nearly parallel, as in a projection onto the plane.
const EYE_DISTANCE: f32 = 200.0;

/// Returns a camera far in front of a box that sees no more than the box, `depth_m` metres before and behind its plane.
fn box_camera(proxy: &Impostor, depth_m: f32) -> Camera {
    let (half_width, half_height) = (proxy.half_u.length(), proxy.half_v.length());
    let distance = EYE_DISTANCE * half_width.max(half_height).max(depth_m);
    let eye = proxy.centre + distance * proxy.normal();
    let fov_y_radians = 2.0 * (half_height / distance).atan();
    // `half_v` points to the bottom of the image.
    let up = -proxy.half_v / half_height;
    Camera {
        world_to_view: look_to_mat4(eye, -proxy.normal(), up),
        lens: Lens::perspective(fov_y_radians, distance - depth_m, distance + depth_m),
        aspect: half_width / half_height,
        near_plane: None,
        projection: None,
    }
}

/// Returns width and height of a box's image, in texels, whose longer side has `side` texels.
fn image_size(proxy: &Impostor, side: u32) -> [u32; 2] {
    let [u, v] = [proxy.half_u.length(), proxy.half_v.length()];
    [u, v].map(|length| ((length / u.max(v) * side as f32).round() as u32).clamp(1, side))
}

impl IbrMethod {
    /// Draws the content of a box into an image with premultiplied colours and alpha 0 where no lit surface shows.
    fn draw(&self, context: &mut FrameContext, scene: &SceneInput, proxy: &Impostor) -> Result<Image> {
        let gpu: Gpu = context.gpu().clone();
        let extent = image_size(proxy, self.parameters.ibr_side);
        let camera = box_camera(proxy, self.parameters.ibr_depth);
        let gbuffer = GBufferPass::new(&gpu, extent)?;
        let lighting = LightingPass::without_sky(&gpu)?;
        use vk::ImageUsageFlags as U;
        let (levels, usage) = (image::full_chain(extent), U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST);
        let drawn =
            Image::new(&gpu, &ImageDesc { name: "plane", format: LIT_COLOR, extent, levels, layers: 1, usage })?;
        context.once(|frame| {
            gbuffer.record(frame, scene.data, scene.materials, &camera)?;
            let images = gbuffer.gbuffer();
            lighting.record(frame, &images, gbuffer.albedo(), scene.data, &camera)?;
            frame.copy("plane/0", images.color.level(0), drawn.level(0))?;
            (1..levels).try_for_each(|n| frame.blit(&format!("plane/{n}"), drawn.level(n - 1), drawn.level(n)))
        })?;
        Ok(drawn)
    }
}

impl Method for IbrMethod {
    fn prepare(&mut self, context: &mut FrameContext, scene: &SceneInput) -> Result<()> {
        BillboardPass::check(scene.data, INFO.name)?;
        let materials = captured_materials(scene.materials);
        let proxies = scene.data.impostors();
        if self.images.len() != proxies.len() || self.drawn_with != materials {
            self.images = proxies.iter().map(|p| self.draw(context, scene, p)).collect::<Result<_>>()?;
            self.drawn_with = materials;
        }
        Ok(())
    }

    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        let data = input.scene()?.data;
        let drawing = Drawing {
            order: Order::Nearest,
            occlusion: Occlusion::None,
            blur: Blur::Roughness,
            glow: (0.0, 0.0),
            premultiplied: true,
        };
        let reflection = self.pass.record(frame, &input.gbuffer, data, input.camera, Some(&self.images), drawing)?;
        let first = self.images.first().map(|image| Intermediate { name: "plane", content: Content::Color, image });
        Ok(MethodOutput { intermediates: first.into_iter().collect(), ..MethodOutput::new(reflection) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_image_of_a_box_ends_at_its_sides_and_its_depth_at_its_front_and_back() {
        let (centre, half_u, half_v) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.0, 0.0, 2.0), Vec3::new(0.0, -0.5, 0.0));
        let proxy = Impostor { name: String::new(), centre, half_u, half_v, texture: 0 };
        let camera = box_camera(&proxy, 0.25);
        assert!(camera.is_sound());
        let to_clip = camera.view_to_clip_reversed() * camera.world_to_view;
        // A point: shares of `half_u` and `half_v`, and metres along the normal. Then its place in the image, whose
        // edges are at ±1, and its depth, if checked: 1 at the front of the box and 0 at its back.
        for (u, v, along_normal, x, y, depth) in [
            (1.0, 0.0, 0.0, 1.0, 0.0, None),
            (0.0, 1.0, 0.0, 0.0, -1.0, None),
            (-1.0, -1.0, 0.25, -1.0, 1.0, Some(1.0)),
            (0.0, 0.0, -0.25, 0.0, 0.0, Some(0.0)),
        ] {
            let seen = to_clip.project_point3(centre + u * half_u + v * half_v + along_normal * proxy.normal());
            assert!((seen.x - x).abs() < 0.01 && (seen.y - y).abs() < 0.01, "{u}, {v}: {seen}");
            assert!(depth.is_none_or(|depth: f32| (seen.z - depth).abs() < 0.01), "{seen}");
        }
        assert_eq!(image_size(&proxy, 256), [256, 64]);
    }
}
