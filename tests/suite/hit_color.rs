//! Tests the colour of a hit on the screen: it has nothing of the surface that reflects. Rays that never hit have the
//! colour of the sky that the screen shows (docs/definitions.md, "The colour of a hit").

use crate::common::{Builder, Shown, camera, check_validation, clutter, clutter_camera, gpu, show, unfaded};
use glam::{DVec3, Vec3};
use ssct::gpu::frame::Mode;
use ssct::methods::setup::StageChoice;
use ssct::methods::unified::{self, UnifiedParams};
use ssct::methods::{Setup, Wants};
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{Scene, View};
use ssct_truth::reference::surface_color::{ReflectedRay, SurfaceColors};
use ssct_truth::reference::{Hierarchy, Outcome};

/// Size of the images in pixels. The height is even, so that no row of pixels is the horizon.
const EXTENT: [u32; 2] = [160, 120];
/// The wall stands at this z, in metres.
const WALL_Z: f32 = 6.0;
/// The place of the camera, in metres.
const EYE: Vec3 = Vec3::new(0.0, 1.2, 0.0);

/// Returns a black mirror floor with a white wall on it.
fn floor_and_wall(height_m: f32) -> Scene {
    let mut builder = Builder::new("floor and white wall");
    builder.light(Vec3::Z);
    let white = builder.matt(Vec3::ONE);
    builder.quad(white, Vec3::new(-24.0, 0.0, WALL_Z), Vec3::X * 48.0, Vec3::Y * height_m, -Vec3::Z);
    let mirror = builder.mirror();
    builder.quad(mirror, Vec3::new(-24.0, 0.0, 0.0), Vec3::X * 48.0, Vec3::Z * WALL_Z, Vec3::Y);
    builder.0
}

/// Renders a scene by a method from an eye that looks along the z axis, with all intermediate images.
fn render_from(scene: &Scene, eye: Vec3, method: &str, setup: &Setup) -> Shown {
    let gpu = gpu();
    let shown = show(&gpu, scene, camera(eye, eye + Vec3::Z, EXTENT), method, setup, &Globals::default());
    check_validation(&gpu).unwrap();
    shown
}

/// Returns the colours of the intermediate image with a name.
fn colors(shown: &Shown, image: &str) -> Vec<Vec3> {
    shown.get(image).texels().map(Vec3::from_slice).collect()
}

/// Returns, for each pixel, whether it reflects.
fn reflects(shown: &Shown) -> Vec<bool> {
    shown.get("material").texels().map(|texel| texel[0] > 0.5).collect()
}

/// Returns a setup without fade in which `unified` traces in a kind of shader.
fn in_stage(choice: StageChoice) -> Setup {
    unfaded(EXTENT).with(|p: &mut UnifiedParams| p.trace_stage = choice)
}

/// Reflections of the wall are white down to its foot, within 1 %: the bilinear sample of the hit's colour leaves out
/// the black floor beside it. Five heights of the eye are tried.
#[test]
fn the_foot_of_a_wall_is_not_mixed_with_the_floor() {
    let scene = floor_and_wall(24.0);
    let variants = [
        ("unified", in_stage(StageChoice::Fragment)),
        ("unified", in_stage(StageChoice::Compute)),
        ("stochastic", unfaded(EXTENT)),
    ];
    // The height of the eye decides how the foot lies among the pixels. From some heights, nothing is mixed even if all
    // four pixels around a hit count.
    for ((method, setup), height) in
        variants.iter().flat_map(|variant| [1.0, 1.1, 1.2, 1.3, 1.4].map(|height| (variant, height)))
    {
        let shown = render_from(&scene, Vec3::Y * height, method, setup);
        let (reflection, reflects) = (colors(&shown, "reflection"), reflects(&shown));
        let wall = colors(&shown, "color").into_iter().map(|color| color.x).fold(0.0, f32::max);
        let hits: Vec<f32> = (0..reflects.len()).filter(|i| reflects[*i]).map(|i| reflection[i].x / wall).collect();
        let seen = hits.iter().filter(|share| **share > 0.0).count();
        let mixed = hits.iter().filter(|share| **share > 0.0 && **share < 0.99).count();
        assert!(seen > 5000 && mixed == 0, "{method}, {height} m: {mixed} of {seen}");
    }
}

/// Rays that pass over a low wall show the sky that the screen shows in their direction, which is that of the mirrored
/// row above the horizon, within 0.02. A ray that stops at the border of the image would show another part of the sky.
#[test]
fn a_ray_that_goes_on_for_ever_shows_the_sky_of_the_screen() {
    let [width, height] = EXTENT;
    for method in ["unified", "dda"] {
        let shown = render_from(&floor_and_wall(1.0), EYE, method, &unfaded(EXTENT));
        let (reflection, reflects, color) = (colors(&shown, "reflection"), reflects(&shown), colors(&shown, "color"));
        let depth: Vec<f32> = shown.get("depth").values.clone();
        let mut compared = 0;
        for (x, y) in (height / 2..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let [i, mirrored] = [y, height - 1 - y].map(|y| (y * width + x) as usize);
            // Rays from the floor nearer than 3.27 m pass over the wall, in the direction of the pixel that lies
            // mirrored above the horizon.
            let slope =
                (f64::from(y) + 0.5 - f64::from(height) / 2.0) / f64::from(height) * 2.0 * 37_f64.to_radians().tan();
            if !reflects[i] || f64::from(EYE.y) / slope > 3.1 || depth[mirrored] > 0.0 {
                continue;
            }
            let difference = (reflection[i] - color[mirrored]).abs().max_element();
            assert!(difference < 0.02, "{method} at ({x}, {y}): {} for {}", reflection[i], color[mirrored]);
            compared += usize::from(color[mirrored] != Vec3::ZERO);
        }
        assert!(compared > 2000, "{method}: {compared}");
    }
}

/// In the cluttered scene, fewer than one hit in 1000 has a colour that differs by more than 0.01 from the reference's
/// colour of that hit.
#[test]
fn a_mirror_shows_what_the_reference_shows_where_its_ray_hits() {
    let gpu = gpu();
    let (scene, extent) = (clutter(), [321, 239]);
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let mirrors = Globals { roughness: Some(0.0), ..Globals::default() }.materials(&scene, &View::default());
    let camera = clutter_camera(extent);
    let shot = Shot::new(&mut stage, &unified::INFO, &unfaded(extent), Wants::HITS, camera, mirrors).unwrap();
    let (_, _, output) = stage.output_in(Mode::Plain, &shot).unwrap();
    let reflection = gbuffer::reflection(&mut stage.context, &output).unwrap();
    let data = gbuffer::read(&mut stage.context, &shot).unwrap();
    let (hierarchy, colors) = (Hierarchy::new(&data), SurfaceColors::new(&data));
    let rays = hierarchy.rays();
    let view_to_world = camera.world_to_view.as_dmat4().inverse();
    let (mut hits, mut wrong) = (0, 0);
    for (x, y) in (0..extent[1]).flat_map(|y| (0..extent[0]).map(move |x| (x, y))) {
        let Some(direction) = data.reflects(data.index(x, y)).then(|| rays.mirror(x, y)).flatten() else { continue };
        let Outcome::Hit { pixel: [i, j], position } = hierarchy.trace(x, y).outcome else { continue };
        // Hits beside sky are left out, since the reference shows the sky there as the camera sees it.
        let around = [-0.5, 0.5].map(|step| [position.x + step, position.y + step]);
        let clamp = |coordinate: f64, side: u32| (coordinate.max(0.0) as u32).min(side - 1);
        let [low, high] = around.map(|[x, y]| [clamp(x, extent[0]), clamp(y, extent[1])]);
        if [low, [high[0], low[1]], [low[0], high[1]], high].iter().any(|[x, y]| data.depth[data.index(*x, *y)] <= 0.0)
        {
            continue;
        }
        let ray = rays.position(x, y).zip(rays.normal(x, y));
        let ray = ray.map(|(point, normal)| ReflectedRay { point, normal, direction });
        let world_direction = view_to_world.transform_vector3(direction);
        let expected = colors.shown(data.index(i, j), [position.x, position.y], world_direction, ray);
        let found = reflection.texel(x, y);
        let found = DVec3::new(f64::from(found[0]), f64::from(found[1]), f64::from(found[2]));
        hits += 1;
        wrong += usize::from((found - expected).abs().max_element() > 0.01);
    }
    println!("{wrong} of {hits} hits have another colour");
    assert!(hits > 1000 && wrong * 1000 < hits, "{wrong} of {hits} hits have another colour");
    check_validation(&gpu).unwrap();
}
