//! The environment: an analytic sky with clouds, sun and hills, as a function of direction and as a cube map in Vulkan's layout.
//! Sky surfaces (windows) show the environment, and rays that leave the scene may return it.

use crate::math::atan2;
use crate::math::noise::{fractal, smoothstep};
use glam::{IVec2, Vec2, Vec3, Vec3Swizzles};

/// Unit vector towards the sun. The light of the atrium comes from this direction.
pub const SUN: Vec3 = Vec3::new(0.279_448, 0.931_493_4, -0.232_873_4);

/// A cube map of the light from infinitely far away.
#[derive(Debug, Clone, PartialEq)]
pub struct SkyCube {
    /// Width and height of a face in texels.
    pub side: u32,
    /// Linear colours of the six faces in Vulkan's order, one after the other, rows from the top.
    pub texels: Vec<Vec3>,
}

/// The linear radiance from a direction (of any length but zero); each channel is in 0…1.
pub fn radiance(direction: Vec3) -> Vec3 {
    let d = direction.normalize_or(Vec3::Y);
    let azimuth = atan2(d.z, d.x) / std::f32::consts::TAU + 0.5;
    let ridge = 0.004 + 0.035 * fractal(Vec2::new(azimuth * 9.0, 0.5), IVec2::new(9, 1), 4, 211);
    let land = smoothstep(ridge + 0.004, ridge - 0.004, d.y);
    // Only the few directions that see both air and ground need both.
    let color = match land {
        0.0 => air(d),
        1.0 => ground(d, ridge),
        _ => air(d).lerp(ground(d, ridge), land),
    };
    color.clamp(Vec3::ZERO, Vec3::ONE)
}

/// The sky's colour in the unit direction d: blue above, pale at the horizon, with soft clouds and the sun.
fn air(d: Vec3) -> Vec3 {
    let height = d.y.max(0.0);
    let zenith = Vec3::new(0.10, 0.26, 0.62);
    let horizon = Vec3::new(0.68, 0.78, 0.88);
    let blue = horizon.lerp(zenith, 1.0 - (1.0 - height).powi(4));
    let towards_sun = d.dot(SUN).max(0.0);
    let glow = Vec3::new(1.0, 0.92, 0.75) * (0.25 * towards_sun.powi(24));
    let plane = d.xz() / (height + 0.12) * 1.6 + 512.0; // a flat layer; 512 keeps coordinates within the noise's period
    let cover = fractal(plane, IVec2::splat(1024), 6, 223);
    let cloud = smoothstep(0.50, 0.72, cover) * smoothstep(0.0, 0.18, height);
    let cloud_color = Vec3::new(0.93, 0.93, 0.94).lerp(Vec3::new(0.62, 0.66, 0.72), smoothstep(0.62, 0.85, cover));
    let disc = smoothstep(0.9992, 0.9996, d.dot(SUN));
    (blue + glow).lerp(cloud_color, 0.85 * cloud).lerp(Vec3::new(1.0, 0.98, 0.92), disc)
}

/// The land's colour in the unit direction d: meadows below, and hills in haze up to the height `ridge`.
fn ground(d: Vec3, ridge: f32) -> Vec3 {
    let below = (-d.y).max(0.0);
    let plane = d.xz() / (below + 0.06) + 512.0; // flat land; 512 keeps coordinates within the noise's period
    let patches = fractal(plane, IVec2::splat(1024), 4, 227);
    let meadow = Vec3::new(0.10, 0.15, 0.05).lerp(Vec3::new(0.24, 0.22, 0.10), patches);
    let haze = Vec3::new(0.36, 0.44, 0.48);
    meadow.lerp(haze, smoothstep(-0.25, ridge, d.y) * 0.75)
}

/// The direction of a point on a face of a cube map. It is not normalised: its greatest component is ±1.
///
/// `face` is 0 to 5 in Vulkan's order +x −x +y −y +z −z; u and v run 0…1 from the face's top left. This is the inverse
/// of the Vulkan specification's table "Cube map face and coordinate selection": u = ½ + ½ s_c/|r|, v = ½ + ½ t_c/|r|.
pub fn face_direction(face: usize, u: f32, v: f32) -> Vec3 {
    let (s, t) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    match face {
        0 => Vec3::new(1.0, -t, -s),
        1 => Vec3::new(-1.0, -t, s),
        2 => Vec3::new(s, 1.0, t),
        3 => Vec3::new(s, -1.0, -t),
        4 => Vec3::new(s, -t, 1.0),
        _ => Vec3::new(-s, -t, -1.0),
    }
}

/// The sky as six faces in Vulkan's order, each `size` × `size` texels of linear RGBA with alpha 1, rows from the top.
pub fn cube_map(size: u32) -> [Vec<[f32; 4]>; 6] {
    let color = |face: usize, index: u32| {
        let texel = Vec2::new((index % size) as f32, (index / size) as f32);
        let position = (texel + 0.5) / size as f32;
        radiance(face_direction(face, position.x, position.y)).extend(1.0).to_array()
    };
    let mut faces: [Vec<[f32; 4]>; 6] = Default::default();
    std::thread::scope(|threads| {
        for (face, texels) in faces.iter_mut().enumerate() {
            threads.spawn(move || texels.extend((0..size * size).map(|index| color(face, index))));
        }
    });
    faces
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table of the Vulkan specification, not inverted: the face that a direction selects, and s and t on it.
    fn selected(r: Vec3) -> (usize, f32, f32) {
        let a = r.abs();
        let (face, sc, tc, ma) = if a.z >= a.x && a.z >= a.y {
            if r.z >= 0.0 { (4, r.x, -r.y, a.z) } else { (5, -r.x, -r.y, a.z) }
        } else if a.y >= a.x {
            if r.y >= 0.0 { (2, r.x, r.z, a.y) } else { (3, r.x, -r.z, a.y) }
        } else if r.x >= 0.0 {
            (0, -r.z, -r.y, a.x)
        } else {
            (1, r.z, -r.y, a.x)
        };
        (face, 0.5 * sc / ma + 0.5, 0.5 * tc / ma + 0.5)
    }

    #[test]
    fn directions_of_texels_select_the_same_texel() {
        for face in 0..6 {
            for j in 0..8 {
                for i in 0..8 {
                    let (u, v) = ((i as f32 + 0.5) / 8.0, (j as f32 + 0.5) / 8.0);
                    let (f, s, t) = selected(face_direction(face, u, v) * 3.0);
                    assert_eq!(f, face);
                    assert!((s - u).abs() < 1e-6 && (t - v).abs() < 1e-6, "{face} {u} {v}: {s} {t}");
                }
            }
        }
    }

    #[test]
    fn the_forward_face_shows_the_world_as_the_camera_does() {
        // The world is left-handed: looking along +z, +x is on the right and +y at the top.
        assert_eq!(face_direction(4, 1.0, 0.5), Vec3::new(1.0, 0.0, 1.0));
        assert_eq!(face_direction(4, 0.5, 0.0), Vec3::new(0.0, 1.0, 1.0));
    }

    #[test]
    fn radiance_is_between_black_and_one_and_brighter_above_than_below() {
        let faces = cube_map(32);
        for texel in faces.iter().flatten() {
            assert!(texel.iter().all(|x| (0.0..=1.0).contains(x)), "{texel:?}");
            assert_eq!(texel[3], 1.0);
        }
        let mean = |face: usize| faces[face].iter().map(|t| t[2]).sum::<f32>() / 1024.0;
        assert!(mean(2) > 2.0 * mean(3), "{} above, {} below", mean(2), mean(3));
        assert!(radiance(SUN).min_element() > 0.9);
    }

    #[test]
    fn the_sky_has_no_seam_around_the_horizon() {
        for elevation in [-0.5_f32, 0.02, 0.05, 0.4] {
            let west = radiance(Vec3::new(-1.0, elevation, 1e-5));
            let also_west = radiance(Vec3::new(-1.0, elevation, -1e-5));
            assert!(west.abs_diff_eq(also_west, 0.01), "{elevation}: {west} and {also_west}");
        }
        assert!((SUN.length() - 1.0).abs() < 1e-6);
        assert_eq!(cube_map(8), cube_map(8));
    }
}
