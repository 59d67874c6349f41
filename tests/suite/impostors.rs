//! Compares the built-in impostors with the triangles: each shows, texel by texel, the colour that a ray along its
//! normal finds in the lit scene, and is not mirrored.

use glam::{DVec3, Vec3};
use ssct::passes::scene_data::MAX_LIGHTS;
use ssct_geometry::bvh::WorldRay;
use ssct_ground::math::srgb_to_linear;
use ssct_scenes::{Encoding, Impostor, Material, Scene, library};
use ssct_truth::reference::surface::World;

/// The number of points along each side of an image that are compared.
const GRID: u32 = 24;

/// Returns the linear colour and the alpha of a texel of an impostor.
fn texel(scene: &Scene, impostor: &Impostor, x: u32, y: u32) -> (Vec3, u8) {
    let texture = &scene.textures[impostor.texture];
    let rgba = &texture.rgba[4 * (y * texture.width + x) as usize..][..4];
    (Vec3::from_array([0, 1, 2].map(|channel| srgb_to_linear(f32::from(rgba[channel]) / 255.0))), rgba[3])
}

/// Compares an impostor's image with the colours that rays find, which start `reach` metres in front of its rectangle.
/// Returns the mean difference of linear channels, and the share of the rays that find nothing although the image is
/// opaque. If `mirrored` is true, the image is read from right to left.
fn difference(world: &World, impostor: &Impostor, reach: f32, mirrored: bool) -> (f32, f32) {
    let texture = &world.scene.textures[impostor.texture];
    // The direction is slightly askew, so that no ray runs along a box or a plane that is parallel to an axis.
    let askew = 1e-5 * (impostor.half_u.normalize() + impostor.half_v.normalize());
    let direction = (askew - impostor.normal()).as_dvec3().normalize();
    let (mut sum, mut hit_count, mut missed) = (0.0, 0.0, 0.0_f32);
    for sample in 0..GRID * GRID {
        let (x, y) = ((sample % GRID) * texture.width / GRID, (sample / GRID) * texture.height / GRID);
        let u = 2.0 * (x as f32 + 0.5) / texture.width as f32 - 1.0;
        let v = 2.0 * (y as f32 + 0.5) / texture.height as f32 - 1.0;
        let (colour, alpha) = texel(world.scene, impostor, if mirrored { texture.width - 1 - x } else { x }, y);
        if alpha < 255 {
            continue;
        }
        let place = impostor.centre + u * impostor.half_u + v * impostor.half_v;
        let ray = WorldRay {
            origin: (place + reach * impostor.normal()).as_dvec3(),
            direction,
            t_min: 0.0,
            t_max: f64::from(2.0 * reach),
        };
        match world.closest(&ray) {
            Some(hit) => {
                let ray_color: DVec3 = world.color(&ray, &world.point(&ray, &hit));
                sum += (ray_color.as_vec3() - colour).abs().element_sum() / 3.0;
                hit_count += 1.0;
            }
            None => missed += 1.0,
        }
    }
    assert!(hit_count > 50.0, "{}: only {hit_count} points, {missed} missed", impostor.name);
    (sum / hit_count, missed / (hit_count + missed))
}

/// Each impostor of each built-in scene differs from the rays' colours by less than 0.05 in the mean, and by over 1.3
/// times as much if it is mirrored. Its image is made apart from the geometry, and may be shifted or mirrored against
/// it.
#[test]
fn impostors_show_what_stands_there() {
    for name in library::names() {
        let scene = crate::common::built_in(name);
        assert!(scene.lights.len() <= MAX_LIGHTS, "{name}");
        // The images of impostors have no bumps of normal maps.
        let flat = |m: &Material| Material { normal_deviation: 0.0, ..m.clone() };
        let materials: Vec<Material> = scene.materials.iter().map(flat).collect();
        let world = World::new(&scene, &materials);
        for impostor in &scene.impostors {
            let texture = &scene.textures[impostor.texture];
            assert_eq!(texture.encoding, Encoding::Srgb);
            assert!(impostor.half_u.dot(impostor.half_v).abs() < 1e-4, "{impostor:?}");
            let ratio = impostor.half_u.length() / impostor.half_v.length();
            assert!((texture.width as f32 / texture.height as f32 / ratio - 1.0).abs() < 0.03, "{impostor:?}");
            // Rays start in front of parts that stand out of the rectangle: the side of a car, the sills of a front.
            let reach = if impostor.name == "car" { 1.2 } else { 0.4 };
            let (error, missed) = difference(&world, impostor, reach, false);
            let (mirrored, _) = difference(&world, impostor, reach, true);
            println!("{name} {}: {error:.4}, missed {missed:.3}, mirrored {mirrored:.4}", impostor.name);
            assert!(error < 0.05 && missed < 0.02, "{name} {}: {error}, missed {missed}", impostor.name);
            assert!(mirrored > 1.3 * error, "{name} {}: {mirrored} mirrored, {error} not", impostor.name);
        }
    }
}

/// Two signs and the car have transparent texels in 2 % to 60 % of their images, and the materials of the signs have
/// masks with holes. Without them an impostor would reflect a rectangle.
#[test]
fn cut_signs_are_transparent_around_their_shape_as_their_geometry_is() {
    let street = crate::common::built_in("street");
    for name in ["hotel-sign", "bar-sign", "car"] {
        let impostor = street.impostors.iter().find(|i| i.name == name).expect("the sign");
        let texels = street.textures[impostor.texture].rgba.chunks(4);
        let empty = texels.clone().filter(|t| t[3] == 0).count() as f32 / texels.len() as f32;
        assert!((0.02..0.6).contains(&empty), "{name}: {empty}");
    }
    for name in ["hotel", "bar"] {
        let material = street.materials.iter().find(|m| m.name == name).expect("a material");
        let mask = &street.textures[material.alpha_mask.expect("a mask")];
        assert!(mask.rgba.chunks(4).any(|t| t[0] == 0), "{name}");
    }
}
