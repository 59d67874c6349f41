//! Tests rays that the screen loses and captures find (docs/definitions.md, "Images"). The device is compared with its
//! twin bit by bit, and with the oracle of images.

use crate::common::{Builder, check_validation, clutter, gpu, is_gpu_assisted};
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;
use ssct::gpu::frame::Mode;
use ssct::gpu::{FrameContext, Gpu, Pixels};
use ssct::methods::capture::CaptureImages;
use ssct::methods::setup::CaptureCount;
use ssct::methods::{EffectParams, Fallback, SceneInput, Setup, Wants, find, unified};
use ssct::passes::PathCode;
use ssct::passes::pyramid;
use ssct::passes::scene_data::SceneData;
use ssct_ground::math::constants::{PATH_NONE, PATH_SKY, PATH_UNKNOWN};
use ssct_ground::math::random::Stream;
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_lab::study::stress;
use ssct_scenes::capture::face_camera;
use ssct_scenes::{Aabb, Capture, GBufferData, Lens, Material, Scene, Surface, View};
use ssct_truth::reference::images::EndInImages;
use ssct_truth::reference::unified::{CaptureTraversal, RayEndKind, ScreenRayEnd, Traversal};
use ssct_truth::reference::{CaptureData, ImageOracle};

/// The G-buffer and the captures that the device drew, and the ends of its rays.
struct Drawn {
    data: GBufferData,
    captures: Vec<CaptureData>,
    /// Bounds of the scene: a lost ray outside of them ends in the sky.
    bounds: Aabb,
    /// The image of the hits, which mirror.glsl and follow.comp wrote.
    hits: Pixels,
    /// The reflection before fade and reflectivity.
    reflection: Pixels,
}

/// Returns the materials of a view as mirrors, with flat normals.
fn mirrors(scene: &Scene, view: &View) -> Vec<Material> {
    Globals { roughness: Some(0.0), normal_deviation: Some(0.0), ..Globals::default() }.materials(scene, view)
}

/// Draws the captures of a scene on the device, and reads their faces back as G-buffers. Depths lie in the first level
/// of the faces' common pyramid, whose columns are stored in strips; normals and colours lie face below face.
fn read_captures(gpu: &Gpu, scene: &Scene, materials: &[Material]) -> Vec<CaptureData> {
    let mut context = FrameContext::new(gpu).unwrap();
    let data = SceneData::upload(&mut context, scene).unwrap();
    let images = CaptureImages::new(&mut context, &SceneInput { data: &data, materials }, &scene.captures).unwrap();
    let captures = images.captures();
    let side = scene.captures[0].resolution;
    let near = scene.captures.iter().map(|capture| capture.near_m).fold(f32::INFINITY, f32::min);
    let blocks = context.read(captures.pyramid.level(0)).unwrap();
    let normals = context.read(captures.normal.level(0)).unwrap();
    let colors = context.read(captures.color.level(0)).unwrap();
    let strip = pyramid::strip([side; 2]);
    let rows = pyramid::size([side; 2], strip)[1];
    let texels = || (0..side * side).map(|i| (i % side, i / side));
    let face = |place: Vec3, layer: u32| GBufferData {
        width: side,
        height: side,
        camera: face_camera(place, layer as usize % 6, near),
        depth: texels()
            .map(|(x, y)| blocks.texel((y << strip) | (x % (1 << strip)), layer * rows + (x >> strip))[0].max(0.0))
            .collect(),
        normal: texels().map(|(x, y)| Vec3::from_slice(normals.texel(x, layer * side + y))).collect(),
        reflectivity: vec![0.0; (side * side) as usize],
        roughness: vec![0.0; (side * side) as usize],
        color: texels().map(|(x, y)| Vec3::from_slice(colors.texel(x, layer * side + y))).collect(),
        surface: vec![Surface::Lit; (side * side) as usize],
    };
    let faces = |(index, capture): (usize, &Capture)| CaptureData {
        place: capture.position,
        faces: (0..6).map(|face_index| face(capture.position, 6 * index as u32 + face_index)).collect(),
    };
    scene.captures.iter().enumerate().map(faces).collect()
}

/// Draws a view with `unified` and the captures of the scene, at a size in pixels, and reads everything back.
fn draw(gpu: &Gpu, scene: &Scene, view: &View, extent: [u32; 2]) -> Drawn {
    let setup = Setup::new(extent).with(|p: &mut EffectParams| p.captures = CaptureCount::Auto);
    let (camera, materials) = (view.camera(scene, extent), mirrors(scene, view));
    let captures = read_captures(gpu, scene, &materials);
    let mut stage = Stage::new(gpu, scene).unwrap();
    let shot = Shot::new(&mut stage, &unified::INFO, &setup, Wants::HITS, camera, materials).unwrap();
    let (_, _, output) = stage.output_in(Mode::Plain, &shot).unwrap();
    let hits = stage.context.read(output.traced.hits.unwrap().0.all()).unwrap();
    let reflection = gbuffer::reflection(&mut stage.context, &output).unwrap();
    let bounds = stage.scene().bounds();
    Drawn { data: gbuffer::read(&mut stage.context, &shot).unwrap(), captures, bounds, hits, reflection }
}

/// Returns a scene with a capture at each of the places, whose faces have `resolution` texels on each side.
fn with_captures(mut scene: Scene, places: &[Vec3], resolution: u32) -> Scene {
    scene.captures = places.iter().map(|p| Capture { resolution, ..Capture::placed_at(*p) }).collect();
    scene
}

/// Counts of the rays of an image.
#[derive(Debug, Default, Clone, Copy)]
struct Count {
    /// Rays that the screen loses, so that the captures go on with them.
    followed: usize,
    /// Followed rays that end at a hit in a capture.
    in_captures: usize,
    /// Followed rays that end in the sky.
    in_sky: usize,
    /// Followed rays whose end is only known since the twin knows the bounds of the scene.
    outside: usize,
    /// Followed rays with an unknown end.
    unknown: usize,
    /// The greatest number of steps of a followed ray.
    most_steps: i32,
    /// The greatest number of faces that a followed ray crosses.
    most_faces: i32,
}

/// Checks that the path code and the place of every pixel equal the twin's, bit by bit, and returns counts of the rays.
fn check_twin(drawn: &Drawn) -> Count {
    let screen = Traversal::new(&drawn.data).followed();
    let twin = CaptureTraversal::new(&drawn.data.camera, &drawn.captures).with_bounds(drawn.bounds);
    let unbounded = CaptureTraversal::new(&drawn.data.camera, &drawn.captures);
    let mut count = Count::default();
    let mut wrong = Vec::new();
    for (i, found) in drawn.hits.texels().enumerate() {
        let (x, y) = (i as u32 % drawn.data.width, i as u32 / drawn.data.width);
        let code = found[3] as i32;
        if !drawn.data.reflects(i) {
            assert_eq!(code, PATH_NONE);
            continue;
        }
        assert!(found.iter().all(|v| v.is_finite()), "({x}, {y}): {found:?}");
        let screen_end = twin.trace_screen(&screen, x, y);
        let is_right = match screen_end {
            ScreenRayEnd::NoRay => true,
            ScreenRayEnd::Sky => code == PATH_SKY,
            ScreenRayEnd::Hit(hit) => is_screen_hit(found, &screen, &hit),
            ScreenRayEnd::Lost(ray) => {
                let capture_end = twin.trace_captures(&ray);
                count.followed += 1;
                count.most_steps = count.most_steps.max(capture_end.steps);
                count.most_faces = count.most_faces.max(capture_end.faces);
                assert!(!capture_end.is_exhausted, "({x}, {y}): {capture_end:?}");
                match capture_end.kind {
                    RayEndKind::Unknown => {
                        count.unknown += 1;
                        code == PATH_UNKNOWN && found[..3] == [-1.0; 3]
                    }
                    kind => {
                        count.in_sky += usize::from(kind == RayEndKind::Sky);
                        count.outside += usize::from(unbounded.trace_captures(&ray).kind != kind);
                        count.in_captures += usize::from(kind != RayEndKind::Sky);
                        let bits = capture_end.place.to_array().map(f32::to_bits);
                        code == kind.code() && bits == [0, 1, 2].map(|c| found[c].to_bits())
                    }
                }
            }
        };
        if !is_right {
            let capture_end = match screen_end {
                ScreenRayEnd::Lost(ray) => Some(twin.trace_captures(&ray)),
                _ => None,
            };
            wrong.push(format!("({x}, {y}): {found:?}, {screen_end:?}, {capture_end:?}"));
        }
    }
    let first_wrong = wrong[..wrong.len().min(6)].join("\n");
    assert!(wrong.is_empty(), "{} of {} followed are not the twin's:\n{first_wrong}", wrong.len(), count.followed);
    count
}

/// Returns whether a texel of the device has the code of a hit on the screen and the place of the twin's hit, bit by
/// bit.
fn is_screen_hit(found: &[f32], screen: &Traversal, hit: &ssct_truth::reference::unified::Hit) -> bool {
    let uv = hit.position * screen.parameters.pixel_to_clip;
    let bits = [uv.x, uv.y, 1.0 - hit.depth].map(f32::to_bits);
    PathCode::from_channel(found[3]) == Some(PathCode::HiZ) && bits == [0, 1, 2].map(|c| found[c].to_bits())
}

/// Returns whether a texel of the device agrees with the oracle's end of the ray. Both must be of one kind, in a
/// capture at most a texel apart, and on the screen at most a pixel apart.
fn agrees(found: &[f32], data: &GBufferData, end: Option<EndInImages>) -> bool {
    let place = DVec3::new(found[0].into(), found[1].into(), found[2].into());
    match (end, PathCode::from_channel(found[3])) {
        (Some(EndInImages::Screen(position)), Some(PathCode::HiZ)) => {
            let pixel = place.truncate() * DVec2::new(data.width.into(), data.height.into());
            (pixel - position.truncate()).abs().max_element() <= 1.0
        }
        (Some(EndInImages::Capture { index, place: expected_place, texel_m }), Some(PathCode::Capture)) => {
            PathCode::capture(found[3]) == Some(index) && place.distance(expected_place) <= texel_m
        }
        (Some(EndInImages::Sky), Some(PathCode::Sky)) | (Some(EndInImages::Unknown), Some(PathCode::Unknown)) => true,
        _ => false,
    }
}

/// Compares the followed rays with the oracle of images. Returns how many rays are followed, how many of them are ties,
/// and a sentence for each other ray that ends elsewhere. A ray is a tie if it agrees once its direction is off by the
/// rounding of 32-bit numbers.
fn check_oracle(drawn: &Drawn) -> (usize, usize, Vec<String>) {
    let data = &drawn.data;
    let images = ImageOracle::new(data, &drawn.captures).with_bounds(drawn.bounds);
    let screen = Traversal::new(data).followed();
    let twin = CaptureTraversal::new(&data.camera, &drawn.captures).with_bounds(drawn.bounds);
    // For a pixel whose ray is followed: whether the ray is a tie, and a sentence if it ends elsewhere.
    let compare = |i: usize| {
        let (x, y) = (i as u32 % data.width, i as u32 / data.width);
        let found = drawn.hits.texel(x, y);
        if !data.reflects(i) || !matches!(twin.trace_screen(&screen, x, y), ScreenRayEnd::Lost(_)) {
            return None;
        }
        let on_screen = images.trace_screen(x, y);
        let truth = images.end(on_screen);
        if agrees(found, data, truth) {
            return Some((false, None));
        }
        let stream = Stream::new(i as u64, 3);
        let direction = images.mirror(x, y)?.normalize();
        let is_tie = (0..64).any(|n| {
            let offset = DVec3::from([0, 1, 2].map(|c| stream.uniform(3 * n + c) * 2.0 - 1.0));
            let along = direction + 4.0 * f64::from(f32::EPSILON) * offset;
            agrees(found, data, images.end(images.trace_screen_along(x, y, along)))
        });
        let description =
            format!("({x}, {y}): {found:?}, {:?}, oracle: {on_screen:?}, {truth:?}", twin.trace_screen(&screen, x, y));
        Some((is_tie, (!is_tie).then_some(description)))
    };
    let followed: Vec<_> = (0..data.depth.len()).into_par_iter().filter_map(compare).collect();
    let ties = followed.iter().filter(|(is_tie, _)| *is_tie).count();
    (followed.len(), ties, followed.into_iter().filter_map(|(_, wrong)| wrong).collect())
}

/// Returns a scene without its images, which rays do not read.
fn without_images(mut scene: Scene) -> Scene {
    let plain = |material: &mut Material| {
        let (albedo, reflectivity, roughness) = (material.albedo, material.reflectivity, material.roughness);
        *material = Material { name: material.name.clone(), albedo, reflectivity, roughness, ..Material::default() };
    };
    scene.materials.iter_mut().for_each(plain);
    scene.textures.clear();
    scene.impostors.clear();
    scene
}

/// Returns scenes with captures, each with a name, a view and a size in pixels: many captures and few, fine and coarse
/// faces, hard places, and very small and large scenes.
fn cases() -> Vec<(String, Scene, View, [u32; 2])> {
    let mut cases = Vec::new();
    let [rooms, atrium, street] =
        ["rooms", "atrium", "street"].map(|name| without_images(crate::common::built_in(name)));
    // Size of the image, texels along a side of a face, and number of captures.
    let few = [([97, 61], 64, 1), ([160, 90], 128, 2)];
    let many = [([97, 61], 16, 4), ([64, 64], 33, 4)];
    for (scene, view, kinds) in
        [(&rooms, "window", few), (&rooms, "corridor", many), (&atrium, "", few), (&street, "car", many)]
    {
        let view = scene.views.iter().find(|v| v.name == view).unwrap_or(&scene.views[0]).clone();
        // Places between the eye and the point that it looks at, beside that line, and behind the eye.
        let aside = (view.look_at - view.eye).cross(Vec3::Y).normalize();
        let place = |along: f32, side: f32| view.eye.lerp(view.look_at, along) + side * aside;
        let places = [place(0.3, 0.2), place(0.8, -0.4), view.eye, place(-0.2, 0.5)];
        for (extent, side, count) in kinds {
            let scene = with_captures(scene.clone(), &places[..count], side);
            let name = format!("{} {} {extent:?}, {count} of {side}", scene.name, view.name);
            cases.push((name, scene, view.clone(), extent));
        }
    }
    let view = View { eye: Vec3::new(0.0, 1.4, 0.0), look_at: Vec3::new(0.0, 1.0, 6.0), ..View::default() };
    let places = [Vec3::new(0.0, 1.5, 4.0), Vec3::new(-2.0, 3.0, 9.0)];
    for side in [1, 2, 128] {
        cases.push((format!("clutter, {side}"), with_captures(clutter(), &places, side), view.clone(), [97, 61]));
    }
    // Captures at the eye, on the floor, and below the floor, from where nothing of the room is seen.
    let hard = with_captures(clutter(), &[view.eye, Vec3::new(0.5, 0.0, 4.0), Vec3::new(0.0, -0.5, 3.0)], 33);
    cases.push(("clutter, 3 of 33 in hard places".into(), hard.clone(), view.clone(), [97, 61]));
    for factor in [1e-3, 1e3] {
        let mut scene = Scene { views: vec![view.clone()], ..hard.clone() };
        scene.scale(factor);
        scene.lens = Lens::default().scaled(factor);
        let view = scene.views[0].clone();
        cases.push((format!("clutter times {factor}"), scene, view, [97, 61]));
    }
    cases
}

/// Over all scenes of `cases`, each pixel has the twin's path code and place, bit by bit. More than 5000 rays are
/// followed, and more than 100 end in the sky by the bounds alone, so that each way to end is tried. The twin shares
/// the device's algorithm and its faults; the oracle looks at every texel on the way instead. At most one followed ray
/// in 10 000 ends elsewhere than it says, and at most one in 10 000 is a tie.
#[test]
fn rays_that_are_followed_end_where_the_twin_and_the_oracle_of_images_say() {
    let gpu = gpu();
    let mut total = Count::default();
    let (mut followed, mut ties, mut wrong) = (0, 0, 0);
    for (name, scene, view, extent) in cases().into_iter().take(if is_gpu_assisted() { 1 } else { usize::MAX }) {
        let drawn = draw(&gpu, &scene, &view, extent);
        let count = check_twin(&drawn);
        println!("{name}: {count:?}");
        (total.followed, total.outside) = (total.followed + count.followed, total.outside + count.outside);
        let (rays, tied_rays, wrong_rays) = check_oracle(&drawn);
        println!("    {rays} followed, {tied_rays} ties, {} wrong", wrong_rays.len());
        wrong_rays.iter().take(4).for_each(|w| println!("    {w}"));
        (followed, ties, wrong) = (followed + rays, ties + tied_rays, wrong + wrong_rays.len());
    }
    println!("{followed} followed, {ties} ties, {wrong} wrong");
    assert!(total.followed > 5000 && (is_gpu_assisted() || total.outside > 100), "{total:?}");
    assert!(wrong * 10_000 <= followed && ties * 10_000 <= followed, "{wrong} and {ties} of {followed}");
    check_validation(&gpu).unwrap();
}

/// In the captures of the stress suite, all rays end as the twin's rays do, and no ray of the twin runs out of steps.
/// Captures inside walls or at their surface have depths over which a walk may stall.
#[test]
fn no_ray_is_exhausted_in_captures_that_stand_in_hard_places() {
    let gpu = gpu();
    let rooms = without_images(crate::common::built_in("rooms"));
    let mut total = Count::default();
    for case in stress::captures::cases(&rooms).iter().take(if is_gpu_assisted() { 1 } else { usize::MAX }) {
        // Two frames in three of a capture that moves show nothing that others do not.
        for scene in case.scenes(&rooms).into_iter().step_by(3) {
            let count = check_twin(&draw(&gpu, &scene, &scene.views[0], [97, 61]));
            println!("{}: {count:?}", case.name);
            total.followed += count.followed;
            total.in_captures += count.in_captures;
            total.unknown += count.unknown;
        }
    }
    assert!(total.followed > 5000 && total.in_captures > 500 && total.unknown > 500, "{total:?}");
    check_validation(&gpu).unwrap();
}

/// Returns a mirror floor before a wall at z = 8. The wall is brighter to the right in red and upwards in green,
/// linearly, and has a checker of cells of 2 m in blue.
fn ramp() -> Scene {
    let mut b = Builder::new("ramp");
    b.light(Vec3::Z);
    let srgb = |v: f64| {
        let v = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
        (255.0 * v).round() as u8
    };
    let side = 1024_u32;
    let coordinate = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
    let wall = b.picture(side, side, |x, y| {
        let (u, v) = (coordinate(x), 1.0 - coordinate(y));
        let cell = (u * WALL[0] / CELL).floor() + (v * WALL[1] / CELL).floor();
        [srgb(u), srgb(v), if cell % 2.0 == 0.0 { 255 } else { 0 }]
    });
    let mirror = b.mirror();
    b.quad(mirror, Vec3::new(-20.0, 0.0, 0.0), Vec3::X * 40.0, Vec3::Z * 7.9, Vec3::Y);
    let [width, height] = WALL.map(|v| v as f32);
    b.quad(wall, Vec3::new(-20.0, 0.0, 8.0), Vec3::X * width, Vec3::Y * height, Vec3::NEG_Z);
    b.0
}

/// Width and height of the wall, in metres.
const WALL: [f64; 2] = [40.0, 16.0];
/// The side of a cell of the checker, in metres.
const CELL: f64 = 2.0;

/// The greatest rounding of a colour: steps of the wall's picture and of 16-bit floats.
const ROUNDING: f64 = 0.008;

/// The point of the wall that a pixel shows (metres along the wall and up), how its ray ended, and the error of its
/// colour.
type WallSample = (DVec2, PathCode, f64);

/// Draws the ramp with one capture at a place, whose faces have `resolution` texels on each side. Returns the images,
/// and for each pixel a sample of the wall that it reflects. A pixel that reflects no wall, or a place near its edges,
/// has no sample.
fn draw_wall(gpu: &Gpu, place: Vec3, resolution: u32) -> (Drawn, Vec<Option<WallSample>>) {
    let scene = with_captures(ramp(), &[place], resolution);
    let view = View { eye: Vec3::new(0.0, 1.6, 0.0), look_at: Vec3::new(0.0, 0.2, 4.0), ..View::default() };
    let extent = [160, 120];
    let drawn = draw(gpu, &scene, &view, extent);
    let rotation = drawn.data.camera.world_to_view.as_dmat4().inverse();
    let tan_half_fov = f64::from(drawn.data.camera.lens.fov_y_radians().unwrap() / 2.0).tan();
    let wall_samples = (0..drawn.data.depth.len()).map(|i| {
        let (x, y) = (i as u32 % extent[0], i as u32 / extent[0]);
        let pixel = [f64::from(x) + 0.5, f64::from(y) + 0.5];
        let aspect = f64::from(extent[0]) / f64::from(extent[1]);
        let ndc = [2.0 * pixel[0] / f64::from(extent[0]) - 1.0, 1.0 - 2.0 * pixel[1] / f64::from(extent[1])];
        let direction =
            rotation.transform_vector3(DVec3::new(ndc[0] * tan_half_fov * aspect, ndc[1] * tan_half_fov, 1.0));
        // The eye's mirror image lies 1.6 m below the floor: the ray from there through the pixel meets the wall at
        // this point.
        let distance_scale = 8.0 / direction.z;
        let wall = DVec2::new(distance_scale * direction.x, -1.6 - distance_scale * direction.y);
        let is_inside = wall.x.abs() < 19.0 && wall.y > 1.0 && wall.y < WALL[1] - 0.5;
        let code = PathCode::from_channel(drawn.hits.texel(x, y)[3])?;
        let color_found = drawn.reflection.texel(x, y);
        // The wall's red grows to the right and its green upwards, from 0 to 1.
        let truth = [(wall.x + 20.0) / WALL[0], wall.y / WALL[1]];
        let errors = [0, 1].map(|c| (f64::from(color_found[c]) - truth[c]).abs());
        (drawn.data.reflects(i) && is_inside).then_some((wall, code, errors[0].max(errors[1])))
    });
    let wall_samples = wall_samples.collect();
    (drawn, wall_samples)
}

/// The reflected wall has the right colour everywhere, also at borders between screen and capture and between two
/// faces, where a ray goes on in another image. The allowed error is a texel of the capture and the footprint of the
/// ray, as shares of the wall, plus rounding.
#[test]
fn no_seam_shows_where_a_ray_goes_on_in_a_capture() {
    let gpu = gpu();
    for (place, resolution) in
        [(Vec3::new(0.5, 2.0, 4.0), 128), (Vec3::new(-3.0, 1.0, 6.0), 256), (Vec3::new(0.0, 6.0, 2.0), 64)]
    {
        let (drawn, wall_samples) = draw_wall(&gpu, place, resolution);
        let [mut seams, mut faces, mut cells] = [0; 3];
        let mut worst: [f64; 2] = [0.0; 2];
        let width = drawn.data.width as usize;
        // The direction of a point of the wall from the capture, and the width of a texel there.
        let from_capture = |wall: DVec2| DVec3::new(wall.x, wall.y, 8.0) - place.as_dvec3();
        let texel_m = |wall: DVec2| 2.0 * from_capture(wall).abs().max_element() / f64::from(resolution);
        // The axis of the face that shows a point: that in which the point lies farthest away.
        let face_axis = |wall: DVec2| from_capture(wall).abs().max_position();
        for (i, wall_sample) in wall_samples.iter().enumerate() {
            let &Some((wall, code, error)) = wall_sample else { continue };
            assert!([PathCode::HiZ, PathCode::Capture].contains(&code), "{wall}: {code:?}");
            // A face sees the wall at an angle, which lengthens its texels on the wall. The footprint of a ray widens
            // with the distance from the eye's mirror image; 37° are half of the field of view.
            let direction = from_capture(wall);
            let footprint_m = 2.0 * 37_f64.to_radians().tan() / f64::from(drawn.data.height)
                * DVec3::new(wall.x, wall.y + 1.6, 8.0).length();
            let [texel_m, slope] = match code {
                PathCode::Capture => [texel_m(wall), direction.abs().max_element() / direction.z.abs()],
                _ => [0.0, 1.0],
            };
            let allowed = (texel_m * slope + footprint_m) / WALL[1] + ROUNDING;
            let kind = usize::from(code == PathCode::Capture);
            worst[kind] = worst[kind].max(error);
            assert!(error <= allowed, "{wall}, {code:?}: off by {error}, {allowed} allowed");
            let blue = f64::from(drawn.reflection.texel((i % width) as u32, (i / width) as u32)[2]);
            let in_cells = (wall + DVec2::new(20.0, 0.0)) / CELL;
            let edge_distance_m = (in_cells - in_cells.round()).abs().min_element() * CELL;
            // The coarser of two levels of the colour's chain has texels up to twice as wide as the footprint.
            if edge_distance_m > 2.0 * texel_m.max(footprint_m) * slope + 0.05 {
                let expected = f64::from(u8::from((in_cells.x.floor() + in_cells.y.floor()) % 2.0 == 0.0));
                assert!((blue - expected).abs() < 0.1, "{wall}, {code:?}: blue {blue}");
                cells += 1;
            }
            // The next pixels to the right and below.
            for next in [i + 1, i + width] {
                let Some(&Some((other, other_code, other_error))) = wall_samples.get(next) else { continue };
                if (other - wall).length() > 1.0 {
                    continue;
                }
                let is_seam = code != other_code;
                let between_faces =
                    code == PathCode::Capture && code == other_code && face_axis(wall) != face_axis(other);
                if is_seam || between_faces {
                    let colors = [i, next].map(|i| drawn.reflection.texel((i % width) as u32, (i / width) as u32));
                    let hit = [i, next].map(|i| drawn.hits.texel((i % width) as u32, (i / width) as u32));
                    assert!(
                        error + other_error <= 2.0 * allowed,
                        "{wall}, {other}: off by {error}, {other_error}, {colors:?}, {hit:?}"
                    );
                }
                seams += usize::from(is_seam);
                faces += usize::from(between_faces);
            }
        }
        println!("{place}, {resolution}: {seams} seams, {faces} between faces, {cells} in cells, worst {worst:?}");
        assert!(seams > 50 && faces > 10 && cells > 1000, "{seams}, {faces}, {cells}");
    }
    check_validation(&gpu).unwrap();
}

/// Where the fade of `ssct` is 1, its finished image is the same with captures behind it and without, within the
/// rounding of 16-bit floats. The captures may only fill in where the screen fades or misses.
#[test]
fn captures_behind_a_method_leave_what_the_screen_shows_in_the_image() {
    let gpu = gpu();
    let scene = crate::common::built_in("corridor");
    let (view, extent) = (&scene.views[0], [160, 90]);
    // The reflection and the finished image with a fallback.
    let images = |fallback| {
        let mut stage = Stage::new(&gpu, &scene).unwrap();
        let setup = Setup::new(extent).with(|p: &mut EffectParams| p.fallback = fallback);
        let camera = view.camera(&scene, extent);
        let shot =
            Shot::new(&mut stage, find("ssct").unwrap(), &setup, Wants::REFLECTION, camera, mirrors(&scene, view))
                .unwrap();
        let (_, _, output) = stage.output(&shot).unwrap();
        let reflection = stage.context.read(output.traced.reflection.unwrap().0.all()).unwrap();
        (reflection, stage.context.read(output.composite.level(0)).unwrap())
    };
    let ((alone, screen), (_, captured)) = (images(Fallback::None), images(Fallback::Captures));
    let mut unfaded = 0;
    for ((reflection, screen), captured) in alone.texels().zip(screen.texels()).zip(captured.texels()) {
        if reflection[3] == 1.0 {
            unfaded += 1;
            assert!((0..3).all(|c| (screen[c] - captured[c]).abs() < 2e-3), "{screen:?} became {captured:?}");
        }
    }
    assert!(unfaded > 1000, "{unfaded}");
}
