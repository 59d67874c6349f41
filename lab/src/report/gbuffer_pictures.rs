//! The G-buffer as Schmidt shows it (2013, figure 27): positions and normals in world and in view space,
//! albedo, reflectivity, and the lit scene.

use super::images::{Rgb, display, unit_byte};
use crate::error::{Error, Result};
use crate::stage::Intermediates;
use glam::{Mat3, Vec2, Vec3};
use ssct::gpu::Pixels;
use ssct::passes::Content;
use ssct_scenes::Camera;

/// Makes the rows of pictures of Schmidt's figure 27 from the intermediates of a frame and its camera: positions and
/// normals in world space; both in view space; albedo and reflectivity; the lit scene.
///
/// Positions span their own range in each picture: black is their least x, y and z, white the greatest.
pub fn rows(images: &Intermediates, camera: &Camera) -> Result<Vec<Vec<Rgb>>> {
    let find = |stem: &str, wanted: Content| {
        let found =
            images.iter().find(|(name, content, _)| name == stem && *content == wanted).map(|(.., pixels)| pixels);
        found.ok_or_else(|| Error::usage(format!("this frame has no {stem} to make the figure of")))
    };
    let (depth, normal) = (find("depth", Content::ReversedDepth)?, find("normal", Content::Normal)?);
    let lit = find("color-0", Content::Color).or_else(|_| find("color", Content::Color))?;
    let in_view: Vec<Option<Vec3>> = positions(depth, camera);
    let to_world = camera.world_to_view.inverse();
    let in_world: Vec<Option<Vec3>> = in_view.iter().map(|p| p.map(|p| to_world.transform_point3(p))).collect();
    let normals_to_world = Mat3::from_mat4(to_world);
    let size = [depth.width, depth.height];
    let reflectivity = reflectivity(find("material", Content::Material)?);
    Ok(vec![
        vec![position_picture(size, &in_world), normal_picture(normal, normals_to_world)],
        vec![position_picture(size, &in_view), normal_picture(normal, Mat3::IDENTITY)],
        vec![display(find("albedo", Content::Color)?), reflectivity],
        vec![display(lit)],
    ])
}

/// Makes a picture of the reflectivity in a G-buffer's material: black is 0, and white is 1.
pub fn reflectivity(material: &Pixels) -> Rgb {
    Rgb::from_pixels(material, |c| [unit_byte(c[0]); 3])
}

/// Returns the view-space position of each pixel in metres, from its reversed depth; `None` for sky.
fn positions(depth: &Pixels, camera: &Camera) -> Vec<Option<Vec3>> {
    let clip_to_view = camera.view_to_clip_reversed().inverse();
    let size = Vec2::new(depth.width as f32, depth.height as f32);
    let position = |(n, z): (usize, &[f32])| {
        let pixel = Vec2::new((n as u32 % depth.width) as f32, (n as u32 / depth.width) as f32) + 0.5;
        let ndc = (pixel / size * 2.0 - 1.0) * Vec2::new(1.0, -1.0);
        (z[0] > 0.0).then(|| clip_to_view.project_point3(ndc.extend(z[0])))
    };
    depth.texels().enumerate().map(position).collect()
}

/// Makes a picture of positions: black is the least x, y and z of all, white is the greatest, and sky is black.
fn position_picture([width, height]: [u32; 2], positions: &[Option<Vec3>]) -> Rgb {
    let known = positions.iter().flatten();
    let (low, high) = known.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    let color = |p: &Option<Vec3>| {
        p.map_or([0; 3], |p| ((p - low) / (high - low).max(Vec3::splat(1e-6))).to_array().map(unit_byte))
    };
    Rgb { width, height, bytes: positions.iter().flat_map(color).collect() }
}

/// Makes a picture of normals that are rotated by `rotation`: a coordinate of −1 is 0, and 1 is 255. A pixel without a
/// normal is black.
fn normal_picture(normal: &Pixels, rotation: Mat3) -> Rgb {
    Rgb::from_pixels(normal, |c| {
        let n = Vec3::new(c[0], c[1], c[2]);
        if n == Vec3::ZERO { [0; 3] } else { ((rotation * n) * 0.5 + 0.5).to_array().map(unit_byte) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct_scenes::Lens;

    #[test]
    fn positions_are_where_the_camera_sees_them() {
        // One pixel in the middle, 4 m ahead; one that shows the sky.
        let lens = Lens { near_m: 0.5, far_m: 100.0, ..Lens::default() };
        let camera = Camera::new(Vec3::new(3.0, 1.0, -2.0), Vec3::new(3.0, 1.0, 7.0), lens, 1.0);
        let clip = camera.view_to_clip_reversed() * Vec3::new(0.0, 0.0, 4.0).extend(1.0);
        let depth = Pixels { width: 1, height: 1, channels: 1, values: vec![clip.z / clip.w] };
        let found = positions(&depth, &camera);
        assert!(found[0].is_some_and(|p| p.distance(Vec3::new(0.0, 0.0, 4.0)) < 1e-3), "{found:?}");
        let sky = Pixels { values: vec![0.0], ..depth };
        assert_eq!(positions(&sky, &camera), [None]);
    }

    #[test]
    fn the_least_coordinates_are_black_the_greatest_white_and_sky_black() {
        let p = |x: f32| Some(Vec3::new(x, 5.0, -x));
        let picture = position_picture([2, 2], &[p(1.0), p(3.0), None, p(2.0)]);
        assert_eq!(picture.bytes, [0, 0, 255, 255, 0, 0, 0, 0, 0, 128, 0, 128]);
    }
}
