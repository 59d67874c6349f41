//! Compares the world reference's own first hits with the G-buffer and the lit colour of the device: two
//! implementations of geometry, materials, normals and light that share no code.

use glam::{DVec3, Vec3};
use ssct::gpu::{DeviceQuery, Gpu, Pixels};
use ssct::methods::{METHODS, Setup, Wants};
use ssct_lab::stage::{Globals, Shot, Stage, image};
use ssct_scenes::{Camera, Encoding, GBufferData, Material, Scene, Surface, Texture};
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world_hits::{WorldHit, world_hits};

/// Size of the images in pixels.
const SIZE: [u32; 2] = [240, 135];

/// The corridor of the rooms as the reference and the device see it.
struct ReferenceAndDevice {
    first_hits: FirstHits,
    /// The points that the G-buffer shows.
    shown: FirstHits,
    camera: Camera,
    gbuffer: GBufferData,
    hits: Vec<WorldHit>,
}

/// Returns the corridor of the rooms, with a strength of normal maps and with or without images.
fn see_rooms(normal_deviation: f32, has_maps: bool) -> ReferenceAndDevice {
    let scene = crate::common::built_in("rooms");
    let view = scene.view("corridor").expect("a view of the rooms");
    let globals = Globals { roughness: Some(0.0), reflectivity: 1.0, normal_deviation: Some(normal_deviation) };
    let mut materials = globals.materials(&scene, view);
    if !has_maps {
        materials.iter_mut().for_each(|m| (m.albedo_map, m.normal_map) = (None, None));
    }
    see(&scene, materials)
}

/// Returns the corridor of a scene, with some materials.
fn see(scene: &Scene, materials: Vec<Material>) -> ReferenceAndDevice {
    let gpu = Gpu::open(&DeviceQuery::default()).expect("a Vulkan device");
    let camera = scene.view("corridor").expect("a view of the rooms").camera(scene, SIZE);
    let mut stage = Stage::new(&gpu, scene).expect("device memory");
    let shot =
        Shot::new(&mut stage, &METHODS[0], &Setup::new(SIZE), Wants::IMAGE, camera, materials.clone()).expect("a shot");
    image::render(&mut stage, &shot, false).expect("a frame");
    let images = shot.gbuffer.gbuffer();
    let [depth, normal, material, color] =
        [images.depth.all(), images.normal.all(), images.material.all(), images.color.level(0)]
            .map(|slice| stage.context.read(slice).expect("a readback"));
    let vectors = |p: &Pixels| p.texels().map(|t| Vec3::from_slice(t)).collect();
    let gbuffer = GBufferData {
        width: SIZE[0],
        height: SIZE[1],
        camera,
        depth: depth.values,
        normal: vectors(&normal),
        reflectivity: material.texels().map(|t| t[0]).collect(),
        roughness: material.texels().map(|t| t[1]).collect(),
        color: vectors(&color),
        surface: vec![Surface::Lit; (SIZE[0] * SIZE[1]) as usize],
    };
    let world = World::new(scene, &materials);
    let first_hits = FirstHits::trace(&world, &camera, SIZE);
    let shown = FirstHits::shown(&world, &gbuffer);
    let hits = world_hits(&world, &gbuffer, &shown);
    ReferenceAndDevice { first_hits, shown, camera, gbuffer, hits }
}

/// Returns whether a pixel and its eight neighbours lie on one smooth surface. On a plane, 1/z is linear in the image,
/// so that its second differences are small away from silhouettes and edges.
fn inside_a_surface(seen: &ReferenceAndDevice, x: u32, y: u32) -> bool {
    if x == 0 || y == 0 || x + 1 == SIZE[0] || y + 1 == SIZE[1] {
        return false;
    }
    let inverse_z = |dx: i32, dy: i32| {
        let index = seen.gbuffer.index((x as i32 + dx) as u32, (y as i32 + dy) as u32);
        1.0 / seen.first_hits.view_z_m[index]
    };
    let second_difference = |dx, dy| (inverse_z(dx, dy) + inverse_z(-dx, -dy) - 2.0 * inverse_z(0, 0)).abs();
    inverse_z(0, 0) > 0.0
        && [(1, 0), (0, 1), (1, 1), (1, -1)].iter().all(|&(dx, dy)| second_difference(dx, dy) < 1e-4 * inverse_z(0, 0))
}

/// Away from silhouettes, where more than half of the pixels lie, the device's depth differs from the reference's by
/// less than 1e-4 of the depth. A wrong projection or transform would differ everywhere.
#[test]
fn depth_agrees_within_one_in_ten_thousand_away_from_silhouettes() {
    let seen = see_rooms(0.0, false);
    let clip_to_view = seen.camera.view_to_clip_reversed().as_dmat4().inverse();
    let (mut compared, mut worst) = (0, 0.0_f64);
    for index in 0..seen.gbuffer.depth.len() {
        let (x, y) = (index as u32 % SIZE[0], index as u32 / SIZE[0]);
        if !inside_a_surface(&seen, x, y) {
            continue;
        }
        let z = clip_to_view.project_point3(DVec3::new(0.0, 0.0, f64::from(seen.gbuffer.depth[index]))).z;
        worst = worst.max((z / seen.first_hits.view_z_m[index] - 1.0).abs());
        compared += 1;
    }
    eprintln!("{compared} pixels, greatest relative difference of depth {worst:.2e}");
    assert!(compared > SIZE[0] as usize * SIZE[1] as usize / 2, "{compared} pixels compared");
    assert!(worst < 1e-4, "{worst}");
}

/// Returns for each pixel the greatest difference of a channel of the lit colour, in rising order.
fn differences(seen: &ReferenceAndDevice) -> Vec<f32> {
    let pairs = seen.gbuffer.color.iter().zip(&seen.first_hits.lit);
    let mut differences: Vec<f32> = pairs.map(|(gpu, cpu)| (*gpu - *cpu).abs().max_element()).collect();
    differences.sort_by(f32::total_cmp);
    differences
}

/// Returns the share of differences within a tolerance.
fn share_within(tolerance: f32, differences: &[f32]) -> f64 {
    differences.iter().filter(|d| **d <= tolerance).count() as f64 / differences.len() as f64
}

/// Without images, the lit colour differs by less than 0.001 in 99.5 % of the pixels. Light and shadow are computed
/// twice, in a shader and on the host, so that a factor may be missing in one of them.
#[test]
fn lit_colour_without_images_agrees_within_half_floats() {
    // The colour is a 16-bit float, which rounds by 0.0005 near 1. Larger differences lie at silhouettes.
    let differences = differences(&see_rooms(0.0, false));
    let (median, share) = (differences[differences.len() / 2], share_within(1e-3, &differences));
    eprintln!("median {median:.1e}, within 0.001: {share:.4}");
    assert!(median < 3e-4, "{median}");
    assert!(share > 0.995, "{share}");
}

/// With emission and a map of roughness, lit colour and roughness agree in 90 % of the pixels or more. Surfaces with
/// one side that are turned away vanish for both. Each feature is read in two places, which may use different channels.
#[test]
fn emission_roughness_maps_and_single_sides_agree() {
    let mut scene = crate::common::built_in("rooms");
    // The map has four texels in a row. It multiplies the emission by 1, ½, 0 and 0, and the roughness by 1, 1, 0.2 and
    // 0.2.
    let texel = |x: u32| if x < 2 { [255, 255, 255, if x == 0 { 255 } else { 128 }] } else { [255, 51, 255, 0] };
    let rgba = (0..4).flat_map(texel).collect();
    let map = Some(scene.textures.len());
    scene.textures.push(Texture { name: "map".into(), width: 4, height: 1, rgba, encoding: Encoding::Linear });
    let mut materials = scene.materials.clone();
    for material in &mut materials {
        (material.albedo_map, material.normal_map) = (map, None);
        (material.emission, material.roughness, material.roughness_map) = (0.5, 0.5, map);
    }
    let see_with = |materials: &[Material], tolerance: f32| {
        let seen = see(&scene, materials.to_vec());
        (share_within(tolerance, &differences(&seen)), seen)
    };
    let mut plain = materials.clone();
    plain.iter_mut().for_each(|m| (m.albedo_map, m.roughness_map) = (None, None));
    // The albedo buffer stores emission in 102 steps, so that it is rounded by up to 5e-3.
    let (alike, _) = see_with(&plain, 5e-3);
    assert!(alike > 0.99, "{alike}");
    // With the map, the two differ by their filters, as in the test below.
    let (alike, whole) = see_with(&materials, 0.08);
    assert!(alike > 0.9, "{alike}");
    let pairs = || whole.gbuffer.roughness.iter().zip(&whole.first_hits.receivers);
    let alike = pairs().filter(|(gpu, cpu)| cpu.is_some_and(|r| (r.roughness - f64::from(**gpu)).abs() < 0.05)).count();
    assert!(alike * 10 > 9 * whole.gbuffer.roughness.len(), "{alike}");
    assert!(pairs().any(|(gpu, _)| *gpu < 0.15) && pairs().any(|(gpu, _)| *gpu > 0.45), "the map has both");
    // All triangles are turned round: with two sides they are still seen, and with one side most are not.
    for mesh in &mut scene.meshes {
        mesh.indices.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
        mesh.vertices.iter_mut().for_each(|v| v.normal = v.normal.map(|n| -n));
    }
    let covered_pixels = |seen: &ReferenceAndDevice| seen.gbuffer.depth.iter().filter(|d| **d > 0.0).count();
    assert_eq!(covered_pixels(&see(&scene, materials.clone())), covered_pixels(&whole));
    materials.iter_mut().for_each(|m| m.single_sided = true);
    let turned_away = see(&scene, materials);
    assert!(
        covered_pixels(&turned_away) < covered_pixels(&whole) / 2,
        "{} of {}",
        covered_pixels(&turned_away),
        covered_pixels(&whole)
    );
    let [gpu, cpu] =
        [covered_pixels(&turned_away), turned_away.first_hits.view_z_m.iter().filter(|z| z.is_finite()).count()];
    assert!(gpu.abs_diff(cpu) * 100 <= SIZE[0] as usize * SIZE[1] as usize, "{gpu} {cpu}");
}

/// With images, the median difference is below 0.012, and 97 % of the pixels are within 0.08. Texture coordinates or
/// colour spaces that differ would show in most pixels.
#[test]
fn lit_colour_with_images_agrees_but_for_their_filtering() {
    // The GPU reads mip levels over the pixel's footprint, and the reference reads the finest level at the pixel's
    // centre. At this size, they differ by the contrast of the images' details.
    for deviation in [0.0, 1.0] {
        let differences = differences(&see_rooms(deviation, true));
        let (median, share) = (differences[differences.len() / 2], share_within(0.08, &differences));
        eprintln!("deviation {deviation}: median {median:.4}, within 0.08: {share:.4}");
        assert!(median < 0.012, "{median}");
        assert!(share > 0.97, "{share}");
    }
}

/// Without normal maps, 99 % of the normals agree within a cosine of 0.999 99; with maps, three quarters agree within
/// 0.98. A tangent of the wrong sign would mirror every bump.
#[test]
fn normals_agree_and_face_the_camera() {
    // With normal maps, the device reads mip levels and the reference the finest level.
    for (deviation, has_maps, percentile, least_cosine) in [(0.0, false, 1, 0.999_99), (1.0, true, 25, 0.98)] {
        let seen = see_rooms(deviation, has_maps);
        let world_to_view = seen.camera.world_to_view.as_dmat4();
        let mut cosines: Vec<f64> = (0..seen.gbuffer.depth.len())
            .filter_map(|i| {
                let cpu = world_to_view.transform_vector3(seen.first_hits.receivers[i]?.normal);
                seen.gbuffer.reflects(i).then(|| cpu.dot(seen.gbuffer.normal[i].as_dvec3().normalize()))
            })
            .collect();
        cosines.sort_by(f64::total_cmp);
        let percentile_cosine = cosines[cosines.len() * percentile / 100];
        eprintln!("deviation {deviation}: {percentile} % of the cosines below {percentile_cosine:.6}");
        assert!(percentile_cosine > least_cosine, "{percentile_cosine}");
    }
}

/// Rays from the points of the G-buffer do not hit the flat surface on which they start: no end lies within 1e-5 m
/// above it. Points from rounded depths lie beside the surface, where a ray would meet it at once.
#[test]
fn mirror_rays_do_not_meet_the_surface_that_they_leave() {
    let seen = see_rooms(0.0, true);
    let (mut rays, mut visible, mut furthest_off) = (0, 0, 0.0_f64);
    for (i, hit) in seen.hits.iter().enumerate() {
        let (Some(start), Some(surface)) = (seen.shown.receivers[i], seen.first_hits.receivers[i]) else { continue };
        rays += 1;
        if let WorldHit::Hit { position, visible: is_visible, .. } = *hit {
            visible += u32::from(is_visible);
            let height_above = |point: DVec3| (point - surface.position).dot(surface.geometric_normal);
            // A curved surface's normals lean over its flat triangles, which may then be met.
            let flat = surface.normal.dot(surface.geometric_normal) > 0.999_999;
            if flat && (start.position - surface.position).length() < 0.01 {
                furthest_off = furthest_off.max(height_above(start.position).abs());
                assert!(height_above(position) > 1e-5, "pixel {i} hits itself: {position} from {}", start.position);
            }
        }
    }
    eprintln!("{rays} rays start within {furthest_off:.1e} m of their surface; {visible} ends are visible");
    assert!(furthest_off < 1e-5, "the G-buffer's positions lie on the triangles");
    assert!(rays > 10_000 && visible > rays / 2);
}
