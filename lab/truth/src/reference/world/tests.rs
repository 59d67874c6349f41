//! Tests of the world reference against closed forms.

use super::*;
use crate::reference::surface::tests::rectangle;
use crate::reference::testing;
use ssct_ground::Error;
use ssct_scenes::{Camera, Lens, Material, Mesh, Scene, Surface, Vertex, library};

/// Returns a sphere of radius 8 m around the origin, whose front is inside. Its triangles are so fine that their
/// closest point is 7.9 m away.
fn sphere(material: usize) -> Mesh {
    let (rings, sectors) = (24_u32, 48_u32);
    let mut mesh = Mesh { name: "sphere".into(), material, ..Mesh::default() };
    for i in 0..=rings {
        for j in 0..=sectors {
            let (polar, azimuth) = (
                std::f32::consts::PI * i as f32 / rings as f32,
                std::f32::consts::TAU * (j % sectors) as f32 / sectors as f32,
            );
            let n = Vec3::new(polar.sin() * azimuth.cos(), polar.cos(), polar.sin() * azimuth.sin());
            let vertex =
                Vertex { position: (8.0 * n).to_array(), normal: (-n).to_array(), uv: [0.0; 2], tangent: [0.0; 4] };
            mesh.vertices.push(vertex);
        }
    }
    for i in 0..rings {
        for j in 0..sectors {
            let index = |di: u32, dj: u32| (i + di) * (sectors + 1) + j + dj;
            mesh.indices.extend([index(0, 0), index(1, 0), index(1, 1), index(0, 0), index(1, 1), index(0, 1)]);
        }
    }
    mesh
}

const ALBEDO: Vec3 = Vec3::new(0.9, 0.6, 0.3);

/// Returns a scene of a sphere that shows 0.2 · ALBEDO everywhere, since there is no light.
fn in_a_sphere() -> Scene {
    let materials = vec![Material { albedo: ALBEDO, ..Material::default() }];
    Scene { meshes: vec![sphere(0)], materials, ..Scene::default() }
}

/// Returns a receiver at the origin whose normal is +y, for a camera ray along `incoming`, which may have any length.
fn receiver(incoming: DVec3, roughness: f64) -> Receiver {
    let incoming = incoming.normalize();
    Receiver {
        position: DVec3::ZERO,
        incoming,
        normal: DVec3::Y,
        geometric_normal: DVec3::Y,
        roughness,
        reflectivity: 0.5,
    }
}

/// Returns the first hits of an image of one row with these receivers.
fn one_row(receivers: Vec<Option<Receiver>>) -> FirstHits {
    let n = receivers.len();
    FirstHits { width: n as u32, height: 1, lit: vec![Vec3::splat(0.1); n], view_z_m: vec![1.0; n], receivers }
}

/// Returns a reference without footprints, whose escaping rays are black.
fn reference<'a>(world: &'a World<'a>, first_hits: &'a FirstHits) -> WorldReference<'a> {
    WorldReference::of_centres(world, first_hits, 1)
}

#[test]
fn in_a_sphere_of_one_colour_every_roughness_reflects_that_colour_at_normal_incidence() {
    let scene = in_a_sphere();
    let world = World::new(&scene, &scene.materials);
    let first_hits = one_row([0.0, 0.05, 0.3, 1.0].map(|r| Some(receiver(DVec3::NEG_Y, r))).to_vec());
    let reference = reference(&world, &first_hits);
    let mut state = reference.start();
    reference.add(&mut state, 64);
    let image = reference.image(&state);
    for i in 0..4 {
        assert!((image.reflection[i] - 0.2 * ALBEDO).length() < 1e-6, "{i}: {}", image.reflection[i]);
        assert!(image.standard_error[i].max_element() < 1e-6);
        let composite = Vec3::splat(0.1) + 0.5 * 0.2 * ALBEDO;
        assert!((image.composite[i] - composite).length() < 1e-6);
    }
    assert_eq!(image.samples, [1, 64, 64, 64]);
}

#[test]
fn bounces_in_a_sphere_add_up_to_a_geometric_series() {
    // Rays from the centre meet the sphere at right angles and return through the centre. After n bounces they bring
    // L (1 + r + … + rⁿ⁻¹), for the lit colour L and the reflectivity r.
    let reflectivity = 0.75_f32;
    let mut scene = in_a_sphere();
    scene.materials[0].reflectivity = reflectivity;
    let world = World::new(&scene, &scene.materials);
    let first_hits = one_row(vec![Some(receiver(DVec3::new(0.2, -0.9, 0.1), 0.0))]);
    let mut fingerprints = Vec::new();
    for bounces in 1..=8 {
        let reference = reference(&world, &first_hits).with_bounces(bounces);
        let mut state = reference.start();
        reference.add(&mut state, 16);
        let image = reference.image(&state);
        let expected = 0.2 * ALBEDO * (1.0 - reflectivity.powi(bounces as i32)) / (1.0 - reflectivity);
        assert!((image.reflection[0] - expected).length() < 1e-5, "{bounces}: {}", image.reflection[0]);
        assert!(image.standard_error[0].max_element() < 1e-6);
        fingerprints.push(reference.fingerprint());
    }
    let different: std::collections::BTreeSet<_> = fingerprints.iter().collect();
    assert_eq!(different.len(), fingerprints.len(), "a state of other bounces must not be continued");
}

#[test]
fn the_share_of_the_lobe_below_the_surface_is_dark() {
    // The lobe is cos¹ around an axis at angle θ to the normal. The share (1 + cos θ)/2 of it lies above the surface
    // (the form factor of a tilted element). α = 1 corresponds to cos(ϱ/2)² = ξ.
    let roughness = 2.0 * phong::XI.sqrt().acos();
    assert!((phong::exponent(roughness) - 1.0).abs() < 1e-9);
    let scene = in_a_sphere();
    let world = World::new(&scene, &scene.materials);
    let angles = [0.0_f64, 30.0, 60.0, 80.0, 89.0].map(f64::to_radians);
    let first_hits = one_row(angles.map(|a| Some(receiver(DVec3::new(a.sin(), -a.cos(), 0.0), roughness))).to_vec());
    let reference = reference(&world, &first_hits);
    let mut state = reference.start();
    reference.add(&mut state, 4000);
    let image = reference.image(&state);
    for (i, angle) in angles.iter().enumerate() {
        let expected = (0.2 * ALBEDO).as_dvec3() * (1.0 + angle.cos()) / 2.0;
        let error = image.standard_error[i].as_dvec3() * 4.0 + 1e-6;
        let difference = (image.reflection[i].as_dvec3() - expected).abs();
        assert!(difference.cmple(error).all(), "{i}: {difference} beyond {error}");
    }
}

#[test]
fn the_standard_error_is_that_of_a_coin_and_falls_with_the_square_root() {
    let roughness = 2.0 * phong::XI.sqrt().acos();
    let scene = in_a_sphere();
    let world = World::new(&scene, &scene.materials);
    let first_hits = one_row(vec![Some(receiver(DVec3::new(1.0, -1.0, 0.0), roughness)); 50]);
    let reference = reference(&world, &first_hits);
    let mut state = reference.start();
    assert_eq!(state.overall_standard_error(), f64::INFINITY);
    let share = (1.0 + 0.5_f64.sqrt()) / 2.0;
    let color = (0.2 * ALBEDO).as_dvec3();
    // Each sample is either the colour or black, so its variance is colour² · p (1 − p).
    let rms_color = (color.length_squared() / 3.0).sqrt();
    for n in [100, 400, 1600] {
        let more = n - state.samples();
        reference.add(&mut state, more);
        let expected = rms_color * (share * (1.0 - share) / f64::from(n)).sqrt();
        assert!((state.overall_standard_error() / expected - 1.0).abs() < 0.05, "{n}");
    }
    // The actual errors of the pixels must have the size that the standard errors claim.
    let squared_scores =
        state.means().zip(state.standard_errors()).map(|(mean, error)| ((mean - color * share) / error).x.powi(2));
    let chi: f64 = squared_scores.sum();
    assert!((24.7..86.7).contains(&chi), "χ² {chi} with 50 degrees of freedom, 99.8 % inside");
}

/// Returns a scene of a mirror floor at y = 0 and a wall at z = 5 whose left half is dark and whose right half is
/// bright.
fn floor_and_wall() -> Scene {
    let half_wall = |x: f32, material| rectangle(Vec3::new(x, 0.0, 5.0), 5.0 * Vec3::Y, 5.0 * Vec3::X, material);
    let wall_material = |grey: f32| Material { albedo: Vec3::splat(grey), reflectivity: 0.0, ..Material::default() };
    Scene {
        meshes: vec![
            rectangle(Vec3::new(-5.0, 0.0, 0.0), 10.0 * Vec3::Z, 10.0 * Vec3::X, 0),
            half_wall(-5.0, 1),
            half_wall(0.0, 2),
        ],
        materials: vec![
            Material { albedo: Vec3::ZERO, reflectivity: 0.5, ..Material::default() },
            wall_material(0.25),
            wall_material(1.0),
        ],
        ..Scene::default()
    }
}

#[test]
fn a_mirror_floor_shows_the_wall_upside_down() {
    let scene = floor_and_wall();
    let world = World::new(&scene, &scene.materials);
    let camera = Camera::new(Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 1.0, 5.0), Lens::default(), 1.0);
    let size = 32;
    let first_hits = FirstHits::trace(&world, &camera, [size, size]);
    let reference = reference(&world, &first_hits);
    let mut state = reference.start();
    reference
        .run(&mut state, &SamplingTarget::default(), &mut |_| Ok::<_, ssct_ground::Error>(()))
        .expect("running writes no file");
    assert_eq!(state.overall_standard_error(), 0.0, "mirrors have no error");
    assert_eq!(state.samples(), 16, "one pass is enough for mirrors");
    let image = reference.image(&state);
    let mut mirrored = 0;
    for i in 0..(size * size) as usize {
        let (x, y) = (i as u32 % size, i as u32 / size);
        let Some(receiver) = first_hits.receivers[i] else { continue };
        assert!(y >= size / 2, "the floor is below the horizon");
        assert!(receiver.position.y.abs() < 1e-9 && first_hits.lit[i] == Vec3::ZERO);
        // The ray rises as steeply as it descended to the floor, and hits the wall below 5 m.
        let height = (5.0 - receiver.position.z) / receiver.position.z;
        let across = receiver.position.x / receiver.position.z * 5.0;
        let expected = match (height < 5.0 && across.abs() < 5.0, x < size / 2) {
            (false, _) => 0.0,
            (true, true) => 0.2 * 0.25,
            (true, false) => 0.2,
        };
        assert!((image.reflection[i] - Vec3::splat(expected)).length() < 1e-6, "{x} {y}: {}", image.reflection[i]);
        assert!((image.composite[i] - Vec3::splat(0.5 * expected)).length() < 1e-6);
        mirrored += u32::from(expected > 0.0);
    }
    assert!(mirrored > 100, "{mirrored} pixels show the wall; more are needed");
}

#[test]
fn an_escaped_ray_is_black_or_the_sky() {
    let scene = Scene::default();
    let world = World::new(&scene, &scene.materials);
    let first_hits = one_row(vec![Some(receiver(DVec3::new(0.3, -1.0, 0.2), 0.0)), None]);
    let reflection_with = |escape| {
        let reference = WorldReference { escape, ..reference(&world, &first_hits) };
        let mut state = reference.start();
        reference.add(&mut state, 1);
        reference.image(&state).reflection
    };
    assert_eq!(reflection_with(EscapeRadiance::Black), [Vec3::ZERO; 2]);
    let up = DVec3::new(0.3, 1.0, 0.2).normalize();
    let sky = reflection_with(EscapeRadiance::Environment);
    assert!((sky[0] - sky_color(up).as_vec3()).length() < 1e-5 && sky[1] == Vec3::ZERO);
}

#[test]
fn a_window_in_the_world_shows_the_sky_to_the_reflected_ray() {
    let mut scene = in_a_sphere();
    scene.materials[0].surface = Surface::Sky;
    let world = World::new(&scene, &scene.materials);
    let first_hits = one_row(vec![Some(receiver(DVec3::new(0.3, -1.0, 0.2), 0.0))]);
    let reference = reference(&world, &first_hits);
    let mut state = reference.start();
    reference.add(&mut state, 1);
    let up = DVec3::new(0.3, 1.0, 0.2).normalize();
    assert!((reference.image(&state).reflection[0] - sky_color(up).as_vec3()).length() < 1e-5);
}

/// Returns the scene `rooms`, glossy materials for it, and the camera of its view `corridor`.
fn corridor() -> (Scene, Vec<Material>, Camera) {
    let scene = library::scene("rooms").expect("a built-in scene");
    let view = scene.view("corridor").expect("a view").clone();
    let mut materials = scene.materials_in(&view);
    materials.iter_mut().for_each(|m| m.roughness = 0.2);
    let camera = Camera::new(view.eye, view.look_at, view.lens.unwrap_or(scene.lens), 1.5);
    (scene, materials, camera)
}

#[test]
fn threads_interruptions_and_files_change_no_bit() {
    let (scene, materials, camera) = corridor();
    let world = World::new(&scene, &materials);
    let first_hits = FirstHits::trace(&world, &camera, [24, 16]);
    threads_and_interruptions_change_nothing(&reference(&world, &first_hits));
    let footprint = Some(PrimaryRays::new(&camera, [24, 16]));
    threads_and_interruptions_change_nothing(&WorldReference { footprint, ..reference(&world, &first_hits) });
}

/// Asserts that samples give a state of the same bits on one thread and after an interruption.
fn threads_and_interruptions_change_nothing(reference: &WorldReference) {
    let uninterrupted = {
        let mut state = reference.start();
        reference.add(&mut state, 24);
        state
    };
    assert!(uninterrupted.sampled_pixels() > 200 && uninterrupted.overall_standard_error() > 1e-3);

    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let mut single_threaded = reference.start();
    one_thread.install(|| reference.add(&mut single_threaded, 24));
    assert_eq!(single_threaded, uninterrupted);

    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("deeper/state");
    let (mut state, refusal) = reference.resume(&path);
    assert!(refusal.is_none(), "a missing file must not be an error");
    reference.add(&mut state, 7);
    state.save(&path).expect("a file");
    let (mut state, refusal) = reference.resume(&path);
    assert!(refusal.is_none() && state.samples() == 7);
    reference.add(&mut state, 17);
    assert_eq!(state, uninterrupted);

    let other_reference = WorldReference { seed: 2, ..*reference };
    let mut different = other_reference.start();
    other_reference.add(&mut different, 24);
    assert!(different != uninterrupted);
}

#[test]
fn a_file_is_refused_for_anything_else_or_if_damaged() {
    let (mut scene, mut materials, camera) = corridor();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("state");
    let saved = {
        let world = World::new(&scene, &materials);
        let first_hits = FirstHits::trace(&world, &camera, [12, 8]);
        let reference = reference(&world, &first_hits);
        let mut state = reference.start();
        reference.add(&mut state, 2);
        state.save(&path).expect("a file");

        let intact = std::fs::read(&path).expect("the file");
        let mut flipped = intact.clone();
        flipped[300] ^= 1;
        for damaged in [&intact[..intact.len() - 1], &intact[..40], &[], &flipped[..], &[&intact[..], b"x"].concat()] {
            std::fs::write(&path, damaged).expect("the file");
            assert!(matches!(reference.load(&path), Err(Error::Malformed { .. })), "{} bytes", damaged.len());
            let (fresh, refusal) = reference.resume(&path);
            assert!(fresh.samples() == 0 && refusal.is_some());
        }
        std::fs::write(&path, &intact).expect("the file");
        assert_eq!(reference.load(&path).expect("whole again"), state);
        let footprint = Some(PrimaryRays::new(&camera, [12, 8]));
        for other in [
            WorldReference { seed: 9, ..reference },
            WorldReference { escape: EscapeRadiance::Environment, ..reference },
            WorldReference { footprint, ..reference },
        ] {
            assert!(other.load(&path).is_err());
        }
        state
    };
    let refused = |scene: &Scene, materials: &[Material], camera: &Camera| {
        let world = World::new(scene, materials);
        let first_hits = FirstHits::trace(&world, camera, [12, 8]);
        let loaded = reference(&world, &first_hits).load(&path);
        loaded.ok() != Some(saved.clone())
    };
    assert!(!refused(&scene, &materials, &camera), "a state of equal inputs must be accepted");
    let moved = Camera::new(camera.eye() + Vec3::X * 1e-3, camera.eye() + Vec3::Z, camera.lens, 1.5);
    assert!(refused(&scene, &materials, &moved));
    materials[0].normal_deviation = 0.5;
    assert!(refused(&scene, &materials, &camera));
    materials[0].normal_deviation = 1.0;
    scene.textures[0].rgba[5] ^= 1;
    assert!(refused(&scene, &materials, &camera));
    scene.textures[0].rgba[5] ^= 1;
    assert!(!refused(&scene, &materials, &camera));
    let last = scene.meshes.len() - 1;
    scene.meshes[last].vertices[0].position[1] += 0.01;
    assert!(refused(&scene, &materials, &camera));
}

#[test]
fn a_gbuffer_made_from_the_first_hits_gives_the_same_reflection() {
    let (scene, mut materials, camera) = corridor();
    materials.iter_mut().for_each(|m| (m.roughness, m.normal_deviation) = (0.0, 0.0));
    let world = World::new(&scene, &materials);
    let [width, height] = [30, 20];
    let traced = FirstHits::trace(&world, &camera, [width, height]);
    let receiver_of = |i: usize| traced.receivers[i];
    let indices = || 0..traced.lit.len();
    let gbuffer = testing::traced(&world, &camera, [width, height]);
    let read = FirstHits::from_gbuffer(&gbuffer);
    let image_of = |first_hits: &FirstHits| {
        let reference = reference(&world, first_hits);
        let mut state = reference.start();
        reference.add(&mut state, 1);
        reference.image(&state)
    };
    let (traced_image, read_image) = (image_of(&traced), image_of(&read));
    let is_near = |i: &usize| (traced_image.reflection[*i] - read_image.reflection[*i]).length() < 1e-3;
    let reflecting = indices().filter(|i| receiver_of(*i).is_some()).count();
    let agree = indices().filter(|i| receiver_of(*i).is_some()).filter(is_near).count();
    assert!(reflecting > 300 && agree as f64 > 0.98 * reflecting as f64, "{agree} of {reflecting}");
    for i in indices().filter(|i| receiver_of(*i).is_some()) {
        let view_z_m = traced.view_z_m[i];
        assert!((read.view_z_m[i] - view_z_m).abs() < 1e-5 * view_z_m);
    }
}

/// Tests that points from slightly wrong depths of a G-buffer move to the surfaces beside them, and that points far
/// from any surface stay.
#[test]
fn a_gbuffer_shows_the_surfaces_that_its_depths_lie_beside() {
    let (scene, materials, camera) = corridor();
    let world = World::new(&scene, &materials);
    let traced = FirstHits::trace(&world, &camera, [30, 20]);
    let mut gbuffer = testing::traced(&world, &camera, [30, 20]);
    // Reversed depth is nearly inverse to the distance, so that both have the same relative error.
    for (i, depth) in gbuffer.depth.iter_mut().enumerate() {
        *depth *= if i % 7 == 0 { 0.9 } else { 1.001 };
    }
    let [read, shown] = [FirstHits::from_gbuffer(&gbuffer), FirstHits::shown(&world, &gbuffer)];
    let eye = camera.eye().as_dvec3();
    let (mut moved, mut unmoved) = (0, 0);
    for (i, surface) in traced.receivers.iter().enumerate() {
        let Some(surface) = surface else { continue };
        let position = |hits: &FirstHits| hits.receivers[i].unwrap().position;
        if i % 7 == 0 {
            // Each point stays where the depth puts it, or moves to the next surface near it.
            let (offset_m, distance_m) = (position(&shown).distance(position(&read)), position(&read).distance(eye));
            assert!(offset_m <= distance_m / 128.0, "pixel {i}: {offset_m} m off, {distance_m} m away");
            unmoved += u32::from(offset_m == 0.0);
        } else {
            assert!(
                position(&shown).distance(surface.position) < 1e-6,
                "pixel {i}: {} of {}",
                position(&shown),
                surface.position
            );
            moved += u32::from(position(&read).distance(surface.position) > 1e-4);
        }
    }
    assert!(moved > 200 && unmoved > 30, "{moved} and {unmoved}");
}

#[test]
fn rays_of_centres_are_drawn_by_their_numbers() {
    let (scene, mut materials, camera) = corridor();
    materials[0].roughness = 0.0;
    let world = World::new(&scene, &materials);
    let first_hits = FirstHits::trace(&world, &camera, [24, 16]);
    let reference = WorldReference::of_centres(&world, &first_hits, 5);
    let mut state = reference.start();
    reference.add(&mut state, 6);
    let mut counts = [0, 0];
    for (i, (mean, receiver)) in state.means().zip(&first_hits.receivers).enumerate() {
        let Some(receiver) = receiver else { continue };
        let (stream, samples) = (Stream::new(5, i as u64), if receiver.roughness > 0.0 { 6 } else { 1 });
        let mut sum = DVec3::ZERO;
        for n in 0..samples {
            let random_pair = [stream.uniform(2 * n), stream.uniform(2 * n + 1)];
            let direction = lobe_direction(receiver.mirror(), phong::exponent(receiver.roughness), random_pair);
            let ray = WorldRay { origin: receiver.position, direction, t_min: RAY_START_M, t_max: f64::INFINITY };
            let hit = world.closest(&ray).filter(|_| receiver.is_above(direction));
            sum += hit.map_or(DVec3::ZERO, |hit| world.color(&ray, &world.point(&ray, &hit)));
        }
        assert_eq!(mean, sum / samples as f64, "pixel {i}, to the bit");
        counts[usize::from(samples == 1)] += 1;
    }
    assert!(counts.iter().all(|n| *n > 20), "lobes and mirrors: {counts:?}");
}

#[test]
fn whoever_escapes_sees_the_environment() {
    let scene = Scene::default();
    let world = World::new(&scene, &scene.materials);
    // The pixel is so small that all its rays have one direction.
    let incoming = DVec3::new(0.3, -1.0, 0.2);
    let first_hits = one_row(vec![Some(receiver(incoming, 0.0))]);
    let lens = Lens { opening: ssct_scenes::FieldOfView::Angle(1e-6), ..Lens::default() };
    let camera = Camera::new(Vec3::ZERO, incoming.as_vec3(), lens, 1.0);
    let color_and_samples = |reference: WorldReference| {
        let mut state = reference.start();
        reference.add(&mut state, 1);
        (reference.image(&state).reflection[0], state.sample_counts().next())
    };
    let sky = sky_color(DVec3::new(0.3, 1.0, 0.2).normalize()).as_vec3();
    assert_eq!(color_and_samples(WorldReference::of_centres(&world, &first_hits, 1)), (Vec3::ZERO, Some(1)));
    let (color, samples) = color_and_samples(WorldReference::new(&world, &first_hits, &camera, 1));
    assert!((color - sky).length() < 1e-5 && samples == Some(16), "{color} {sky} {samples:?}");
}

#[test]
fn a_pixel_across_an_edge_shows_the_mean_of_both_sides() {
    let scene = floor_and_wall();
    let world = World::new(&scene, &scene.materials);
    let camera = Camera::new(Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 1.0, 5.0), Lens::default(), 1.0);
    // With an odd number of columns, the edge of the wall's halves runs through the middle column.
    let size = 33;
    let first_hits = FirstHits::trace(&world, &camera, [size, size]);
    let image = |reference: WorldReference, samples: &[u32]| {
        let mut state = reference.start();
        samples.iter().for_each(|n| reference.add(&mut state, *n));
        reference.image(&state)
    };
    let filtered_by = |samples: &[u32]| image(WorldReference::new(&world, &first_hits, &camera, 1), samples);
    let (filtered, central) = (filtered_by(&[256]), image(WorldReference::of_centres(&world, &first_hits, 1), &[256]));
    let shows_wall = |i: &usize| first_hits.receivers[*i].is_some_and(|r| r.position.z > 1.2 && r.position.z < 4.5);
    let mut squared_scores = Vec::new();
    for i in (0..filtered.reflection.len()).filter(shows_wall) {
        let (sum, error) = (filtered.reflection[i].x, filtered.standard_error[i].x);
        match (i as u32 % size).cmp(&(size / 2)) {
            std::cmp::Ordering::Less => assert!((sum - 0.05).abs() < 1e-6 && error < 1e-6),
            std::cmp::Ordering::Greater => assert!((sum - 0.2).abs() < 1e-6 && error < 1e-6),
            std::cmp::Ordering::Equal => {
                // Each sample has either value with probability ½.
                assert!((error - 0.075 / 16.0).abs() < 2e-4, "{error}");
                squared_scores.push(((sum - 0.125) / error).powi(2));
                assert!((central.reflection[i].x - 0.125).abs() > 0.07, "one ray shows one of both");
            }
        }
    }
    let chi2: f32 = squared_scores.iter().sum();
    assert!(squared_scores.len() >= 5 && chi2 < 4.0 * squared_scores.len() as f32, "{squared_scores:?}");
    let reflecting = |i: &usize| first_hits.receivers[*i].is_some();
    assert!((0..filtered.samples.len()).filter(reflecting).all(|i| filtered.samples[i] == 256));

    // A mirror takes at least 16 samples, which are the same however they are requested.
    let [once, twice] = [filtered_by(&[20]), filtered_by(&[3, 5, 12])];
    assert_eq!(once, twice);
    let few = filtered_by(&[3]);
    assert_eq!((few.samples.iter().max(), &few), (Some(&16), &filtered_by(&[16])));
}
