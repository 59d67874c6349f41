//! Tests cube maps. A captured thing lies in the right direction, lookups corrected for parallax are exact in a room
//! that is its own proxy box, and levels are blurred as their roughness says. As a fallback, a map shows where the
//! screen-space method fades.

use crate::common::{Builder, Shown, camera, clutter, clutter_camera, gpu, show, with_small_captures};
use ash::vk;
use glam::{DVec2, DVec3, Vec3};
use ssct::error::Error;
use ssct::gpu::{Buffer, FrameContext};
use ssct::methods::capture::capture_cube_maps;
use ssct::methods::{EffectParams, Fallback, METHODS, SceneInput, Setup, Wants, find};
use ssct::passes::cube_filter::{CubeFilterPass, FACE_SIZE, LEVELS, level_roughness};
use ssct::passes::scene_data::SceneData;
use ssct_ground::math::phong;
use ssct_ground::math::projection::unproject;
use ssct_lab::stage::gbuffer;
use ssct_lab::stage::image::render;
use ssct_lab::stage::{Globals, Shot, Stage};
use ssct_scenes::{Aabb, Camera, Probe, Scene, View, sky};

/// The least corner of the room, in metres.
const MIN: Vec3 = Vec3::new(-2.0, -1.0, -3.0);
/// The greatest corner of the room, in metres.
const MAX: Vec3 = Vec3::new(4.0, 2.0, 3.0);

/// Returns the albedo of a quarter of a wall, a different one for each quarter. The wall is given by its axis (0 to 2)
/// and whether it is on that axis's upper side, the quarter by whether each of the other two coordinates is above 0.
fn quarter_albedo(axis: usize, side: bool, high: [bool; 2]) -> Vec3 {
    let index = (axis * 2 + usize::from(side)) * 4 + usize::from(high[0]) + 2 * usize::from(high[1]);
    Vec3::new((index % 3) as f32, (index / 3 % 3) as f32, (index / 9) as f32) * 0.4 + 0.1
}

/// Returns a room whose walls are in four quarters each, split where the other two coordinates are 0. Its floor is a
/// mirror if `mirror_floor` is true.
fn room(mirror_floor: bool) -> Scene {
    let mut b = Builder::new("room");
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [false, true] {
            if mirror_floor && axis == 1 && !side {
                continue;
            }
            for high in [[false, false], [true, false], [false, true], [true, true]] {
                let material = b.matt(quarter_albedo(axis, side, high));
                let mut corner = Vec3::ZERO;
                corner[axis] = if side { MAX[axis] } else { MIN[axis] };
                let (mut right, mut up, mut normal) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
                right[u] = if high[0] { MAX[u] } else { MIN[u] };
                up[v] = if high[1] { MAX[v] } else { MIN[v] };
                normal[axis] = if side { -1.0 } else { 1.0 };
                b.quad(material, corner, right, up, normal);
            }
        }
    }
    if mirror_floor {
        let mirror = b.mirror();
        let size = MAX - MIN;
        b.quad(mirror, MIN, Vec3::X * size.x, Vec3::Z * size.z, Vec3::Y);
    }
    b.0
}

/// Returns the colour of the wall that a ray from inside the room meets, or none within `margin` metres of another
/// quarter or wall. There is no light, so that a wall shows a fifth of its albedo.
fn wall_color(from: DVec3, direction: DVec3, margin: f64) -> Option<Vec3> {
    let (min, max) = (MIN.as_dvec3(), MAX.as_dvec3());
    let distance_to_wall = |a: usize| ((if direction[a] > 0.0 { max[a] } else { min[a] }) - from[a]) / direction[a];
    let axis = (0..3).min_by(|a, b| distance_to_wall(*a).total_cmp(&distance_to_wall(*b))).unwrap();
    let point = from + direction * distance_to_wall(axis);
    let others = [(axis + 1) % 3, (axis + 2) % 3];
    let is_clear = others.iter().all(|&a| point[a].abs().min(point[a] - min[a]).min(max[a] - point[a]) > margin);
    is_clear.then(|| 0.2 * quarter_albedo(axis, direction[axis] > 0.0, others.map(|a| point[a] > 0.0)))
}

/// Returns whether a texel has a colour, but for the rounding of 8-bit sRGB and of 16-bit floats.
fn is_color(found: &[f32], expected: Vec3) -> bool {
    (0..3).all(|c| (found[c] - expected[c]).abs() < 0.004)
}

/// Each texel of the six faces captured in the room has the colour of the wall in its direction. A face that is turned,
/// mirrored or swapped with another shows other quarters. Texels within 5 cm of an edge are left out.
#[test]
fn faces_show_what_lies_in_their_directions() {
    let gpu = gpu();
    let mut context = FrameContext::new(&gpu).unwrap();
    let scene = room(false);
    let data = SceneData::upload(&mut context, &scene).unwrap();
    let place = Vec3::new(1.0, 0.3, -0.5);
    let input = SceneInput { data: &data, materials: &scene.materials };
    let maps = capture_cube_maps(&mut context, &input, &[place]).unwrap();
    let faces = context.read(maps[0].level(0)).unwrap();
    assert_eq!([faces.width, faces.height], [FACE_SIZE, 6 * FACE_SIZE]);
    let mut clear = 0;
    for (y, x) in (0..faces.height).flat_map(|y| (0..faces.width).map(move |x| (y, x))) {
        let (u, v) = ((x as f32 + 0.5) / FACE_SIZE as f32, ((y % FACE_SIZE) as f32 + 0.5) / FACE_SIZE as f32);
        let face = (y / FACE_SIZE) as usize;
        let direction = sky::face_direction(face, u, v).as_dvec3();
        let Some(expected) = wall_color(place.as_dvec3(), direction, 0.05) else { continue };
        let found = faces.texel(x, y);
        assert!(is_color(found, expected), "face {face} ({u}, {v}): {found:?}, not {expected}");
        clear += 1;
    }
    assert!(clear * 10 > 9 * 6 * FACE_SIZE * FACE_SIZE, "{clear} texels");
    gpu.check_validation().unwrap();
}

/// Returns the reflecting pixels: column, row, the point of the mirror floor at a height in metres, and the direction
/// of the reflected ray, both in world space.
fn floor_rays(material: &ssct::gpu::Pixels, camera: &Camera, height: f64) -> Vec<(u32, u32, DVec3, DVec3)> {
    let inverse = camera.view_to_clip().as_dmat4().inverse();
    let to_world = camera.world_to_view.as_dmat4().inverse();
    let eye = camera.eye().as_dvec3();
    let mut rays = Vec::new();
    for (y, x) in (0..material.height).flat_map(|y| (0..material.width).map(move |x| (y, x))) {
        if material.texel(x, y)[0] > 1e-4 {
            let size = DVec2::new(f64::from(material.width), f64::from(material.height));
            let uv = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / size;
            let direction = to_world.transform_vector3(unproject(uv.extend(0.5), &inverse)).normalize();
            rays.push((
                x,
                y,
                eye + direction * ((height - eye.y) / direction.y),
                DVec3::new(direction.x, -direction.y, direction.z),
            ));
        }
    }
    rays
}

/// With one and two probes whose box is the room, `pccm` shows in each pixel the wall that the reflected ray meets. A
/// ray that is moved to the wrong side of the box would meet another. Pixels near edges are left out.
#[test]
fn in_its_own_box_a_corrected_map_is_exact() {
    let gpu = gpu();
    let extent = [321, 239];
    let bounds = Aabb { min: MIN, max: MAX };
    let probe = |x, y, z| Probe { name: "probe".into(), position: Vec3::new(x, y, z), bounds };
    let view = camera(Vec3::new(-1.0, 1.2, -2.4), Vec3::new(1.6, -0.6, 1.0), extent);
    for probes in [vec![probe(1.0, 0.3, -0.5)], vec![probe(-0.8, 0.9, 1.2), probe(2.5, -0.2, -1.0)]] {
        let count = probes.len();
        let scene = Scene { probes, ..room(true) };
        let shown = show(&gpu, &scene, view, "pccm", &Setup::new(extent), &Globals::default());
        let (reflection, composite) = (shown.get("reflection"), shown.get("composite"));
        let (mut clear, mut reflecting) = (0, 0);
        for (x, y, from, direction) in floor_rays(shown.get("material"), &view, f64::from(MIN.y)) {
            reflecting += 1;
            assert_eq!(reflection.texel(x, y)[3], 1.0, "nothing fades");
            // A texel is 0.006 rad: 0.04 m at 6 m, and more on a wall that is seen at an angle.
            let Some(expected) = wall_color(from, direction, 0.25) else { continue };
            assert!(is_color(reflection.texel(x, y), expected), "{count}, ({x}, {y}): {:?}", reflection.texel(x, y));
            assert!(is_color(composite.texel(x, y), expected), "the mirror is black itself");
            clear += 1;
        }
        println!("{count} maps: {clear} of {reflecting} pixels compared");
        assert!(reflecting > 10_000 && clear * 2 > reflecting, "{clear} of {reflecting}");
    }
}

/// Two probes share the room by boxes that meet at x = 1: a pixel in one box shows exactly what the probe of that box
/// shows alone. Weights of the other probe must be 0 there.
#[test]
fn within_one_box_its_map_counts_alone() {
    let gpu = gpu();
    let extent = [161, 119];
    // A probe at x, whose box is the part of the room from one x to another.
    let probe = |x: f32, from: f32, to: f32| {
        let bounds = Aabb { min: Vec3 { x: from, ..MIN }, max: Vec3 { x: to, ..MAX } };
        Probe { name: "probe".into(), position: Vec3::new(x, 0.3, -0.5), bounds }
    };
    let (left, right) = (probe(-0.5, MIN.x, 1.0), probe(2.5, 1.0, MAX.x));
    let view = camera(Vec3::new(1.0, 1.6, -2.9), Vec3::new(1.0, -0.6, 1.0), extent);
    let reflection = |probes: &[&Probe]| {
        let scene = Scene { probes: probes.iter().copied().cloned().collect(), ..room(true) };
        let shown = show(&gpu, &scene, view, "pccm", &Setup::new(extent), &Globals::default());
        (shown.get("reflection").clone(), floor_rays(shown.get("material"), &view, f64::from(MIN.y)))
    };
    let [(left_alone, _), (right_alone, _)] = [&left, &right].map(|probe| reflection(&[probe]));
    let (together, rays) = reflection(&[&left, &right]);
    // The compared pixels on either side whose colour tells which map they show.
    let mut pixels = [0, 0];
    for (x, y, place, _) in rays {
        // A surface that lies on a box counts as inside it.
        if (place.x - 1.0).abs() > 0.1 {
            let side = usize::from(place.x > 1.0);
            let alone = [&left_alone, &right_alone][side].texel(x, y);
            assert_eq!(together.texel(x, y), alone, "({x}, {y}), at {place}");
            pixels[side] += usize::from(left_alone.texel(x, y) != right_alone.texel(x, y));
        }
    }
    assert!(pixels.iter().all(|count| *count > 1000), "{pixels:?} pixels tell the maps apart");
}

/// `local-map` looks up by direction alone, so that a pixel shows the wall that the probe sees in that direction. More
/// than a fifth of the pixels therefore show a wall that their ray does not meet.
#[test]
fn a_local_map_shows_what_is_seen_from_where_it_was_captured() {
    let gpu = gpu();
    let extent = [321, 239];
    let place = Vec3::new(1.0, 0.3, -0.5);
    let probe = Probe { name: "probe".into(), position: place, bounds: Aabb { min: MIN, max: MAX } };
    let scene = Scene { probes: vec![probe], ..room(true) };
    let view = camera(Vec3::new(-1.0, 1.2, -2.4), Vec3::new(1.6, -0.6, 1.0), extent);
    let shown = show(&gpu, &scene, view, "local-map", &Setup::new(extent), &Globals::default());
    let reflection = shown.get("reflection");
    let (mut clear, mut wrong) = (0, 0);
    for (x, y, from, direction) in floor_rays(shown.get("material"), &view, f64::from(MIN.y)) {
        // The lookup has the direction alone: the ray starts at the place of the map, wherever the pixel is.
        let Some(expected) = wall_color(place.as_dvec3(), direction, 0.25) else { continue };
        let found = reflection.texel(x, y);
        assert!(is_color(found, expected), "({x}, {y}): {found:?}, not {expected}");
        clear += 1;
        // The true ray starts at the pixel's own place.
        let truth = wall_color(from, direction, 0.25);
        wrong += usize::from(truth.is_some_and(|truth| !is_color(found, truth)));
    }
    println!("{clear} pixels compared, {wrong} show what is not there");
    assert!(clear > 5000 && wrong * 5 > clear, "{wrong} of {clear}");
}

/// On a lake under the sky, `environment` shows the sky in the direction of each reflected ray. Swapped axes would give
/// over five times the mean error, so that they would be noticed.
#[test]
fn the_environment_is_the_sky_in_the_mirror_direction() {
    let gpu = gpu();
    let mut b = Builder::new("lake");
    let mirror = b.mirror();
    b.quad(mirror, Vec3::new(-90.0, 0.0, -90.0), Vec3::X * 180.0, Vec3::Z * 180.0, Vec3::Y);
    let extent = [320, 240];
    let view = camera(Vec3::new(0.0, 2.0, 0.0), Vec3::new(3.0, 1.5, 4.0), extent);
    let shown = show(&gpu, &b.0, view, "environment", &Setup::new(extent), &Globals::default());
    let rays = floor_rays(shown.get("material"), &view, 0.0);
    assert!(rays.len() > 20_000);
    // The mean error of a channel if the sky were looked up in directions that `transform` changes.
    let error = |transform: fn(Vec3) -> Vec3| {
        let difference = |(x, y, _, direction): &(u32, u32, DVec3, DVec3)| {
            let found = shown.get("reflection").texel(*x, *y);
            let expected = sky::radiance(transform(direction.as_vec3()));
            (0..3).map(|c| f64::from((found[c] - expected[c]).abs())).sum::<f64>() / 3.0
        };
        rays.iter().map(difference).sum::<f64>() / rays.len() as f64
    };
    // The map's texels are 0.35°, the clouds' edges some degrees wide.
    let unchanged = error(|direction| direction);
    println!("mean error {unchanged:.4}");
    assert!(unchanged < 0.004, "{unchanged}");
    for (transform, what) in [
        ((|direction| direction * Vec3::new(-1.0, 1.0, 1.0)) as fn(Vec3) -> Vec3, "left and right"),
        (|direction| direction * Vec3::new(1.0, 1.0, -1.0), "fore and aft"),
        (|direction| Vec3::new(direction.z, direction.y, direction.x), "x and z"),
    ] {
        assert!(error(transform) > 5.0 * unchanged, "{what} changed places: {}", error(transform));
    }
}

/// If a cube map holds a linear function of the direction, each filtered level has the function's mean over the lobe of
/// its roughness, which has a closed form. A wrong lobe or a skewed set of samples would change it.
#[test]
fn levels_are_blurred_by_the_lobe_of_their_roughness() {
    let gpu = gpu();
    let mut context = FrameContext::new(&gpu).unwrap();
    let (source, target) = (CubeFilterPass::source(&gpu).unwrap(), CubeFilterPass::target(&gpu, "target").unwrap());
    let direction = |face: usize, x: u32, y: u32, size: u32| {
        let coordinate = |texel: u32| (texel as f32 + 0.5) / size as f32;
        sky::face_direction(face, coordinate(x), coordinate(y)).normalize()
    };
    let texels: Vec<u16> = (0..6)
        .flat_map(|face| (0..FACE_SIZE).flat_map(move |y| (0..FACE_SIZE).map(move |x| (face, x, y))))
        .flat_map(|(face, x, y)| (0.5 + 0.5 * direction(face, x, y, FACE_SIZE)).extend(1.0).to_array())
        .map(|v| half::f16::from_f32(v).to_bits())
        .collect();
    let bytes = bytemuck::cast_slice(&texels);
    let staging = Buffer::upload(&gpu, "staging", bytes, vk::BufferUsageFlags::TRANSFER_SRC).unwrap();
    let pass = CubeFilterPass::new(&gpu).unwrap();
    context
        .once(|frame| {
            frame.upload("upload", &staging, source.level(0))?;
            pass.record(frame, &source, &target)
        })
        .unwrap();
    for level in 0..LEVELS {
        // The mean of a linear function over the lobe cos^α is the function at the axis times (α + 1)/(α + 2), the mean
        // of cos.
        let exponent = phong::exponent(level_roughness(level));
        let mean_cosine = if exponent.is_infinite() { 1.0 } else { ((exponent + 1.0) / (exponent + 2.0)) as f32 };
        let faces = context.read(target.level(level)).unwrap();
        let (size, mut worst) = (faces.width, 0.0_f32);
        for (y, x) in (0..faces.height).flat_map(|y| (0..size).map(move |x| (y, x))) {
            let expected = 0.5 + 0.5 * mean_cosine * direction((y / size) as usize, x, y % size, size);
            let found = faces.texel(x, y);
            worst = (0..3).fold(worst, |w, c| w.max((found[c] - expected[c]).abs()));
        }
        println!("level {level}, {size} texels, roughness {}: {mean_cosine}, worst {worst}", level_roughness(level));
        // The bound has the rounding of 16-bit floats, and 3 % of the lobe's width for the noise of 64 directions.
        let width = 0.5 * (2.0 * (1.0 - mean_cosine)).sqrt();
        assert!(worst < 0.001 + 0.03 * width, "level {level}: {worst}");
    }
    gpu.check_validation().unwrap();
}

/// For every screen-space method over two fallbacks, the reflection is method · fade + fallback · (1 − fade), within
/// the rounding of 16-bit floats. Light that is weighted twice, or by the wrong fade, breaks the sum.
#[test]
fn a_fallback_shows_where_the_method_fades() {
    let gpu = gpu();
    let extent = [161, 119];
    let globals = Globals { roughness: Some(0.1), ..Globals::default() };
    let image = |method: &str, fallback| {
        let setup = Setup::on_screen(extent).with(|p: &mut EffectParams| p.fallback = fallback);
        show(&gpu, &clutter(), clutter_camera(extent), method, &setup, &globals)
    };
    for (fallback, name) in [(Fallback::Pccm, "pccm"), (Fallback::Environment, "environment")] {
        let fallback_alone = image(name, Fallback::None);
        for method in METHODS.iter().filter(|m| m.is_screen_space()) {
            let (alone, over_fallback) = (image(method.name, Fallback::None), image(method.name, fallback));
            let (mut partly_faded, mut wholly_faded) = (0, 0);
            for (i, found) in over_fallback.get("reflection").texels().enumerate() {
                let pixel = |shown: &crate::common::Shown| shown.get("reflection").values[4 * i..4 * i + 4].to_vec();
                let (local, fallback_texel) = (pixel(&alone), pixel(&fallback_alone));
                let fade = local[3];
                let added: [f32; 3] = std::array::from_fn(|c| found[c] - local[c] * fade);
                // The weight of the fallback in the sum.
                let mut through = 1.0 - fade;
                // The error that the rounding of each image to 16-bit floats makes in the difference of a channel: a
                // device may round either way, so that each number is off by up to a step.
                let step = |v: f32| (v.abs() / 1024.0).max(6e-8);
                let rounded = |c: usize| {
                    step(found[c])
                        + fade * step(local[c])
                        + through * step(fallback_texel[c])
                        + step(fade) * (local[c] + fallback_texel[c])
                };
                let mut allowed: [f32; 3] = std::array::from_fn(rounded);
                if ["unified", "stochastic"].contains(&method.name) && fade > 0.0 {
                    // The rays of a lobe that miss are black without a fallback, and let the fallback through: one
                    // share of each channel, which is at least the share that the fade leaves.
                    let brightest = (0..3).max_by(|a, b| fallback_texel[*a].total_cmp(&fallback_texel[*b])).unwrap();
                    let fallback_light = fallback_texel[brightest].max(0.01);
                    let share = (added[brightest] / fallback_light).max(through);
                    // The share is at most 1. Rounding may raise the light by four steps of a 16-bit float at 1.
                    assert!(share <= 1.0 + 1.0 / 256.0 / fallback_light, "{share} of {name}, pixel {i}");
                    // The error of the share is that of the channel from which the share was computed.
                    let share_error = allowed[brightest] / fallback_light;
                    allowed = std::array::from_fn(|other| allowed[other] + share_error * fallback_texel[other]);
                    through = share;
                }
                for c in 0..3 {
                    let difference = (added[c] - fallback_texel[c] * through).abs();
                    assert!(
                        difference <= allowed[c],
                        "{} over {name}, pixel {i}: {difference} > {}",
                        method.name,
                        allowed[c]
                    );
                }
                assert_eq!(found[3], fallback_texel[3], "nothing fades where something reflects");
                partly_faded += usize::from(fade > 0.0 && fade < 1.0);
                wholly_faded += usize::from(fade == 0.0 && fallback_texel[3] == 1.0);
            }
            // SSLR is printed without a fade: it hits or it misses.
            let fades = method.name != "sslr";
            assert!(
                wholly_faded > 250 && (partly_faded > 25) == fades,
                "{}: {partly_faded} faded in part, {wholly_faded} wholly",
                method.name
            );
        }
    }
}

/// For every screen-space method over three fallbacks, the finished image is lit colour + reflectivity · fade ·
/// reflection, and fewer than 3 % of the reflecting pixels show nothing. Some methods composite along the way, in other
/// passes.
#[test]
fn the_finished_image_has_what_the_reflection_shows_over_each_fallback() {
    let gpu = gpu();
    let extent = [161, 119];
    let globals = Globals { roughness: Some(0.1), ..Globals::default() };
    let (scene, camera) = (clutter(), clutter_camera(extent));
    let materials = globals.materials(&scene, &View::default());
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    for fallback in [Fallback::Pccm, Fallback::Environment, Fallback::Captures] {
        for method in METHODS.iter().filter(|m| m.is_screen_space()) {
            let setup = Setup::on_screen(extent).with(|p: &mut EffectParams| p.fallback = fallback);
            let setup = with_small_captures(&setup);
            let shot = Shot::new(&mut stage, method, &setup, Wants::HITS, camera, materials.clone()).unwrap();
            let shown = Shown { image: render(&mut stage, &shot, true).unwrap(), camera };
            gpu.check_validation().unwrap();
            let texel = |name: &str, i: usize| shown.get(name).texels().nth(i).unwrap().to_vec();
            let (mut reflecting, mut bright) = (0, 0);
            for (i, material) in shown.get("material").texels().enumerate().filter(|(_, m)| m[0] > 0.0) {
                let (lit, reflection, image) = (texel("color", i), texel("reflection", i), texel("composite", i));
                reflecting += 1;
                bright += usize::from(reflection[3] == 1.0);
                for c in 0..3 {
                    let expected = lit[c] + material[0] * reflection[3] * reflection[c];
                    assert!(
                        (image[c] - expected).abs() <= 1e-3 * expected.max(1.0),
                        "{} over {fallback:?}, {i}",
                        method.name
                    );
                }
            }
            assert!(reflecting > 1000, "{reflecting}");
            // Few rays end where neither the method nor the fallback shows anything.
            assert!(
                bright as f64 > 0.97 * reflecting as f64,
                "{} over {fallback:?}: {bright} of {reflecting}",
                method.name
            );
        }
    }
}

/// Methods that are not screen-space refuse a fallback, and a G-buffer without its scene refuses the environment, each
/// with a message that says why.
#[test]
fn what_has_no_fallback_says_so() {
    let gpu = gpu();
    let extent = [16, 16];
    let scene = clutter();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let setup = Setup::new(extent).with(|p: &mut EffectParams| p.fallback = Fallback::Environment);
    let view = clutter_camera(extent);
    let new_shot = |stage: &mut Stage, method: &str, setup: &Setup| {
        Shot::new(stage, find(method).unwrap(), setup, Wants::REFLECTION, view, scene.materials.clone())
    };
    for method in METHODS.iter().filter(|m| !m.is_screen_space()) {
        let Err(Error::Usage(message)) = new_shot(&mut stage, method.name, &setup) else { panic!("{}", method.name) };
        assert!(message.contains("only screen-space methods have a fallback"), "{message}");
    }
    let shot = new_shot(&mut stage, "ssct", &Setup::new(extent)).unwrap();
    stage.run(&shot, ssct::gpu::frame::Mode::Plain).unwrap();
    let data = gbuffer::read(&mut stage.context, &shot).unwrap();
    let Err(Error::Usage(message)) = gbuffer::reflect(&gpu, &data, None, find("ssct").unwrap(), &setup) else {
        panic!()
    };
    assert!(message.contains("needs the scene"), "{message}");
}
