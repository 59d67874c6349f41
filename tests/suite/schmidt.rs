//! Compares `ssr` and `ssr-fast` with the closed form of a mirror before a wall, and with what their listings say of
//! every hit.

use crate::common::{Builder, Shown, bilinear, camera, clutter, clutter_camera, gpu, show, unfaded};
use glam::{DVec2, DVec3, Vec3};
use ssct::methods::ssr_fast::SsrFastParams;
use ssct::methods::{EffectParams, Setup, find};
use ssct::passes::PathCode;
use ssct_ground::math::projection::{project, unproject};
use ssct_lab::stage::Globals;
use ssct_scenes::{Camera, Lens};

/// Returns the linear depth of a standard depth z by Eq. 28 as printed: 2 · near / (far + near − z · (far − near)).
fn linear_depth(z: f64) -> f64 {
    let (near, far) = (f64::from(Lens::default().near_m), f64::from(Lens::default().far_m));
    2.0 * near / (far + near - z * (far - near))
}

/// Returns the path code of a texel of the hits.
fn path(hit: &[f32]) -> PathCode {
    PathCode::from_channel(hit[3]).expect("a path code")
}

/// The place of the camera, in metres.
const EYE: Vec3 = Vec3::new(0.0, 1.2, 0.0);
/// The wall stands at this z, in metres.
const WALL_Z: f64 = 6.0;

/// Renders a mirror floor that ends at a wall, by a method, with or without fade.
fn wall(camera: Camera, extent: [u32; 2], method: &str, fade: bool) -> Shown {
    let mut b = Builder::new("wall");
    b.light(Vec3::Z);
    let picture = b.picture(64, 64, |x, y| [(4 * x) as u8, (4 * y) as u8, 128]);
    b.quad(picture, Vec3::new(-12.0, -1.0, WALL_Z as f32), Vec3::X * 24.0, Vec3::Y * 12.0, -Vec3::Z);
    let mirror = b.mirror();
    b.quad(mirror, Vec3::new(-12.0, 0.0, 0.0), Vec3::X * 24.0, Vec3::Z * WALL_Z as f32, Vec3::Y);
    let setup = Setup::new(extent).with(|p: &mut EffectParams| p.fade = fade);
    show(&gpu(), &b.0, camera, method, &setup, &Globals::default())
}

/// Rays of `ssr` that can reach the wall end at most 1.1 steps behind it, with the printed fade. Rays that leave the
/// screen, start too near or are too steep are left out.
#[test]
fn the_march_of_listing_4_ends_within_a_step_of_the_wall() {
    for extent in [[512, 256], [239, 321]] {
        let view = camera(EYE, EYE + Vec3::Z, extent);
        let shown = wall(view, extent, "ssr", true);
        let (hits, reflection) = (shown.get("hits"), shown.get("reflection"));
        let to_clip = view.view_to_clip().as_dmat4();
        let inverse = to_clip.inverse();
        let step = 1.0 / f64::from(extent[0].max(extent[1]));
        let size = DVec2::new(f64::from(extent[0]), f64::from(extent[1]));
        let (mut found, mut unreachable, mut too_steep, mut self_hits) = (0, 0, 0, 0);
        for (y, x) in (0..extent[1]).flat_map(|y| (0..extent[0]).map(move |x| (y, x))) {
            if shown.get("material").texel(x, y)[0] < 0.5 {
                continue;
            }
            let uv = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / size;
            let direction = unproject(uv.extend(0.5), &inverse).normalize();
            let origin = direction * (f64::from(-EYE.y) / direction.y);
            let reflected = DVec3::new(direction.x, -direction.y, direction.z);
            let (start, end) = (
                project(origin, &to_clip),
                project(origin + reflected * ((WALL_Z - origin.z) / reflected.z), &to_clip),
            );
            let advance = (end - start).normalize() * step;
            let length = start.distance(end);
            let is_on_screen = end.truncate().cmpge(DVec2::ZERO).all() && end.truncate().cmple(DVec2::ONE).all();
            // The march skips two steps, its last step may overshoot, and the number of steps is limited.
            if !is_on_screen || length > 1.0 - 2.0 * step || length < 3.0 * step {
                unreachable += 1;
                continue;
            }
            // A step that goes deeper than the threshold may pass through the wall.
            if linear_depth(end.z + advance.z) - linear_depth(end.z) > 0.001 {
                too_steep += 1;
                continue;
            }
            let hit = hits.texel(x, y);
            assert_eq!(path(hit), PathCode::Linear, "({x}, {y})");
            let hit_point = DVec3::new(f64::from(hit[0]), f64::from(hit[1]), f64::from(hit[2]));
            let beyond = (hit_point - end).dot(advance.normalize()) / step;
            // The depth of the floor itself, a pixel's slope away from the ray, may stop the ray before the wall.
            if beyond < -0.1 {
                self_hits += 1;
                continue;
            }
            // The bound of 1.1 steps has the rounding of 16-bit normals, and of a direction that is computed from two
            // projected points.
            assert!(beyond < 1.1, "({x}, {y}): {beyond} steps beyond the wall");
            let fade = 16.0 * hit_point.x * (1.0 - hit_point.x) * hit_point.y * (1.0 - hit_point.y);
            // The printed listing takes the fade of the sample before the hit: a step away, where its slope is at most
            // 4 in each axis.
            let difference = (f64::from(reflection.texel(x, y)[3]) - fade).abs();
            assert!(difference <= 4.0 * 2.0 * step + 1.0 / 1024.0, "({x}, {y}): {difference}");
            found += 1;
        }
        println!("{extent:?}: {found} right, {self_hits} on the floor, {unreachable} off, {too_steep} too steep");
        assert!(found > 15_000, "{found}");
        assert!(self_hits * 50 < found, "{self_hits} stop at the floor");
    }
}

/// In the cluttered scene, each hit lies as far behind its surface as the listing's threshold allows and has the
/// bilinear colour there; misses are black.
#[test]
fn a_hit_is_as_near_to_its_surface_as_its_listing_says_and_has_its_colour() {
    let extent = [320, 240];
    let gpu = gpu();
    for method in ["ssr", "ssr-fast"] {
        let setup = unfaded(extent);
        let shown = show(&gpu, &clutter(), clutter_camera(extent), method, &setup, &Globals::default());
        let (hits, depth, lit) = (shown.get("hits"), shown.get("depth"), shown.get("color"));
        let (mut count, mut misses) = (0, 0);
        for (hit, reflection) in hits.texels().zip(shown.get("reflection").texels()) {
            if path(hit) != PathCode::Linear {
                assert_eq!(reflection, [0.0; 4]);
                misses += usize::from(path(hit) == PathCode::LinearMiss);
                continue;
            }
            count += 1;
            assert_eq!(reflection[3], 1.0, "without fade");
            let texel = |v: f32, side: u32| ((v * side as f32) as u32).min(side - 1);
            let surface = 1.0 - f64::from(depth.texel(texel(hit[0], extent[0]), texel(hit[1], extent[1]))[0]);
            let behind = linear_depth(f64::from(hit[2])) - linear_depth(surface);
            // The depth is read from the nearest texel: a hit on the border of two texels may read the other one.
            let on_border = [hit[0] * extent[0] as f32, hit[1] * extent[1] as f32].iter().any(|v| v.fract() < 1e-3);
            let range = if method == "ssr" { 0.0..=0.001_001 } else { -0.002_001..=0.002_001 };
            assert!(on_border || range.contains(&behind), "{method}: {behind}");
            let seen = bilinear(lit, hit[0], hit[1]);
            for c in 0..3 {
                assert!((reflection[c] - seen[c]).abs() < 0.003, "{method}: {reflection:?}, not {seen:?}");
            }
        }
        println!("{method}: {count} hits, {misses} misses");
        assert!(count > 5_000 && misses > 100, "{method}: {count}, {misses}");
    }
}

/// A step of one pixel is the published one and a step of four changes hits. The blur of `ssr-fast` changes colours and
/// no hit, and makes the image about twice as bright, as its printed listing does.
#[test]
fn steps_and_blur_do_what_they_say() {
    let extent = [320, 240];
    let gpu = gpu();
    let image = |method: &str, pixel_step: u32, distance_blur: bool| {
        let setup = unfaded(extent).with(|p: &mut SsrFastParams| {
            (p.pixel_step, p.distance_blur) = (pixel_step, distance_blur);
        });
        show(&gpu, &clutter(), clutter_camera(extent), method, &setup, &Globals::default())
    };
    let published =
        |method: &str| show(&gpu, &clutter(), clutter_camera(extent), method, &unfaded(extent), &Globals::default());
    for method in ["ssr", "ssr-fast"] {
        assert_eq!(published(method).get("hits"), image(method, 1, false).get("hits"), "printed is 1");
        assert_ne!(published(method).get("hits"), image(method, 4, false).get("hits"));
    }
    // The blur changes colours and no hit; listing 4 has no blur.
    let (plain, blurred) = (image("ssr-fast", 1, false), image("ssr-fast", 1, true));
    assert_eq!(plain.get("hits"), blurred.get("hits"));
    assert_ne!(plain.get("reflection"), blurred.get("reflection"));
    assert!(find("ssr").unwrap().read_parameters().iter().all(|p| p.name != "distance_blur"));
    // The printed listing adds a sample of level 7 and does not count it. Near the viewer, the sum of one sample and
    // the mean of the surroundings is thus divided by one, and about twice as bright.
    let brightness = |s: &Shown| s.get("reflection").texels().map(|t| f64::from(t[0] + t[1] + t[2])).sum::<f64>();
    let ratio = brightness(&blurred) / brightness(&plain);
    println!("blurred over plain: {ratio:.3}");
    assert!((1.6..2.4).contains(&ratio), "{ratio}");
}
