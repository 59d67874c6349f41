//! Tests rays that are reflected at other normals than those of shading, and bumps that are applied after the tracing
//! (thesis §4.4).

use crate::common::{Shown, clutter, clutter_camera, gpu, show};
use glam::Vec3;
use ssct::error::Error;
use ssct::gpu::Pixels;
use ssct::methods::{EffectParams, METHODS, Setup, Wants, find};
use ssct::passes::trace_normals::TraceNormals;
use ssct_lab::stage::{Globals, Shot, Stage};

/// Returns a setup with a choice of normals for tracing and a strength of bumps.
fn setup(extent: [u32; 2], normals: TraceNormals, bump: f32) -> Setup {
    Setup::new(extent).with(|p: &mut EffectParams| (p.trace_normals, p.bump_after) = (normals, bump))
}

/// Returns the share of reflecting pixels in which a channel of `a` and `b` differs by more than a step of 8 bits. The
/// first channel of `material` is the reflectivity.
fn differ(a: &Pixels, b: &Pixels, material: &Pixels) -> f64 {
    let pairs = a.texels().zip(b.texels()).zip(material.texels()).filter(|(_, material)| material[0] > 1e-4);
    let differing: Vec<bool> = pairs.map(|((a, b), _)| (0..3).any(|c| (a[c] - b[c]).abs() > 1.0 / 255.0)).collect();
    differing.iter().filter(|differs| **differs).count() as f64 / differing.len() as f64
}

/// Without normal maps, geometric normals change less than a fifth of the pixels, all of them at edges, and bumps
/// displace hardly any more. Upward normals for all surfaces change over a fifth more. Geometric normals are found from
/// depth, which could turn them.
#[test]
fn without_normal_maps_the_geometry_is_what_shades() {
    let gpu = gpu();
    let extent = [321, 239];
    let flat = Globals { roughness: Some(0.0), normal_deviation: Some(0.0), ..Globals::default() };
    let scene = crate::common::built_in("corridor");
    let view = scene.views[0].camera(&scene, extent);
    let image = |normals, bump| show(&gpu, &scene, view, "unified", &setup(extent, normals, bump), &flat);
    let usual = image(TraceNormals::Shading, 0.0);
    let difference =
        |normals, bump| differ(usual.get("reflection"), image(normals, bump).get("reflection"), usual.get("material"));
    let (geometric, bumped, up) = (
        difference(TraceNormals::Geometric, 0.0),
        difference(TraceNormals::Geometric, 0.2),
        difference(TraceNormals::Up, 0.0),
    );
    println!("differ: geometric {geometric}, with bumps {bumped}, up {up}");
    // Pixels differ at edges, where a neighbour lies on another surface, and by the rounding of normals that are found
    // from depth.
    assert!(geometric < 0.2, "{geometric}");
    // With upward normals, walls reflect as if they were floors.
    assert!(up > geometric + 0.2, "{up}");
    // Without normal maps, bumps displace nothing.
    assert!(bumped < geometric + 0.1, "{bumped}");
}

/// Returns the share of displaced pixels that show the reflection of the pixel to which the bump displaces them.
///
/// `flat` is the frame without bumps after the tracing, `bumped` the frame with them, and `geometric` the image of
/// geometric normals. `y_sign` is 1 for the right sign of vertical displacements, and −1 for the wrong one.
fn displaced(flat: &Shown, bumped: &Shown, geometric: &Pixels, strength: f32, y_sign: f32) -> f64 {
    let (reflection, material, shading) = (flat.get("reflection"), flat.get("material"), flat.get("normal"));
    let [width, height] = [reflection.width, reflection.height];
    let normal = |image: &Pixels, x, y| Vec3::from_slice(&image.texel(x, y)[..3]);
    let (mut moved, mut right) = (0, 0);
    for (x0, y0) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        if material.texel(x0, y0)[0] <= 1e-4 {
            continue;
        }
        let traced = normal(geometric, x0, y0);
        let shift = (normal(shading, x0, y0) - traced) * strength * height as f32;
        let displaced_coordinate = |coordinate: u32, shift_px: f32, side: u32| {
            ((coordinate as f32 + 0.5 + shift_px).floor().clamp(0.0, side as f32 - 1.0)) as u32
        };
        let (x, y) = (displaced_coordinate(x0, shift.x, width), displaced_coordinate(y0, -shift.y * y_sign, height));
        if (x, y) != (x0, y0) && material.texel(x, y)[0] > 1e-4 && normal(geometric, x, y).dot(traced) > 0.9 {
            moved += 1;
            right += usize::from(bumped.get("reflection").texel(x0, y0) == reflection.texel(x, y));
        }
    }
    assert!(moved > 5000, "only {moved} pixels are displaced");
    f64::from(right as u32) / f64::from(moved)
}

/// With two methods, over 90 % of the displaced pixels show the right pixel. With the sign of y turned round, clearly
/// fewer would be right, so that the check notices a wrong sign.
#[test]
fn bumps_after_the_tracing_displace_reflections_by_what_normal_maps_bend() {
    let gpu = gpu();
    let (extent, strength) = ([320, 180], 0.1);
    let scene = crate::common::built_in("rooms");
    let view = scene.view("corridor").unwrap().camera(&scene, extent);
    let globals_with =
        |deviation| Globals { roughness: Some(0.0), normal_deviation: Some(deviation), ..Globals::default() };
    let plain = show(&gpu, &scene, view, "ssct", &Setup::new(extent), &globals_with(0.0));
    for method in ["ssct", "unified"] {
        let image =
            |bump| show(&gpu, &scene, view, method, &setup(extent, TraceNormals::Geometric, bump), &globals_with(1.0));
        let (flat, bumped) = (image(0.0), image(strength));
        let right_share = |y_sign| displaced(&flat, &bumped, plain.get("normal"), strength, y_sign);
        let (right, upside_down) = (right_share(1.0), right_share(-1.0));
        println!("{method}: {right} of the displaced pixels are right, {upside_down} if up were down");
        // Normals found from depth are rounded, so that some land a pixel beside.
        assert!(right > 0.9 && upside_down < right - 0.1, "{method}: {right}, {upside_down}");
        let share = differ(flat.get("composite"), bumped.get("composite"), flat.get("material"));
        assert!(share > 0.0, "{method}: the composite does not show the displaced reflection");
    }
}

/// Methods that are not screen-space refuse other normals, and bumps are refused without other normals for tracing.
/// Both settings would otherwise be ignored without a word.
#[test]
fn what_cannot_have_other_normals_says_so() {
    let gpu = gpu();
    let scene = clutter();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let view = clutter_camera([16, 16]);
    let mut refuse = |method: &str, setup: &Setup, reason: &str| {
        let shot =
            Shot::new(&mut stage, find(method).unwrap(), setup, Wants::REFLECTION, view, scene.materials.clone());
        let Err(Error::Usage(message)) = shot else { panic!("{method} took it") };
        assert!(message.contains(reason), "{message}");
    };
    for method in METHODS.iter().filter(|m| !m.is_screen_space()) {
        refuse(method.name, &setup([16, 16], TraceNormals::Up, 0.0), "are for screen-space methods");
    }
    refuse(
        "ssct",
        &setup([16, 16], TraceNormals::Shading, 0.5),
        "need rays that were reflected at normals without them",
    );
}
