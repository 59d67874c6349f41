//! Tests the picture as a whole: which way round it is, which options change it and which do not, sky and windows.

use super::{Case, EYE, bytes, mirror_ray, on_screen, path};
use crate::common::{
    Builder, Shown, bilinear, camera, clutter, clutter_camera, gpu, show, show_with, tolerated_share, unfaded, window,
};
use glam::{DVec2, DVec3, Vec3};
use ssct::gpu::Pixels;
use ssct::methods::linear::LinearParams;
use ssct::methods::poster::PosterParams;
use ssct::methods::ssct::ThesisDrawing;
use ssct::methods::{self, Setup, Wants};
use ssct::passes::linear_trace::LinearMarch;
use ssct::passes::{PathCode, PosterFilter};
use ssct_ground::parameter::Preset;
use ssct_lab::stage::Globals;
use ssct_scenes::Scene;
use ssct_truth::metrics::rmse;

/// Returns a mirror floor before a wall of four quarters, whose colours in sRGB are given in the order bottom left,
/// bottom right, top left, top right.
fn quarters(colors: [[u8; 3]; 4]) -> Scene {
    let mut b = Builder::new("quarters");
    b.light(Vec3::Z);
    let wall = b.picture(64, 64, |x, y| colors[usize::from(x >= 32) + 2 * usize::from(y < 32)]);
    b.quad(wall, Vec3::new(-12.0, -1.0, 6.0), Vec3::X * 24.0, Vec3::Y * 8.0, -Vec3::Z);
    let mirror = b.mirror();
    b.quad(mirror, Vec3::new(-12.0, 0.0, 0.0), Vec3::X * 24.0, Vec3::Z * 6.0, Vec3::Y);
    b.0
}

/// The reflection of `linear` is the same at roughness 0 and 0.6, to the bit, since the published method reflects
/// mirrors alone.
#[test]
fn a_mirror_lookup_knows_no_roughness() {
    let gpu = gpu();
    let extent = [160, 120];
    let [mirror, rough] = [0.0, 0.6].map(|roughness| {
        let globals = Globals { roughness: Some(roughness), ..Globals::default() };
        show(&gpu, &clutter(), clutter_camera(extent), "linear", &Setup::new(extent), &globals)
    });
    assert_eq!(mirror.get("reflection"), rough.get("reflection"));
}

/// In ten variants of methods, a wall of four coloured quarters keeps left and right in the reflection of a mirror
/// floor, and up and down change places. A wrong sign mirrors the picture, which a symmetric scene would not show.
#[test]
fn right_is_right_and_down_is_up() {
    const RED: [u8; 3] = [255, 0, 0];
    const GREEN: [u8; 3] = [0, 255, 0];
    const BLUE: [u8; 3] = [0, 0, 255];
    const WHITE: [u8; 3] = [255, 255, 255];
    let gpu = gpu();
    let scene = quarters([BLUE, RED, GREEN, WHITE]);
    let extent = [320, 240];
    let view = camera(EYE.as_vec3(), EYE.as_vec3() + Vec3::Z, extent);
    // At roughness 0, SSLR reaches only a fifth of the screen. The published poster loses rays whose step leaves the
    // screen, so that the author's values are used.
    let usual = unfaded(extent);
    let author = usual.of_preset(Preset::Author);
    let volume = author.with(|p: &mut PosterParams| p.poster_filter = PosterFilter::Volume);
    let fixed = usual.with(|p: &mut LinearParams| (p.march, p.numbers.march_stride) = (LinearMarch::Fixed, 0.01));
    for (method, setup, roughness) in [
        ("ssct", usual.clone(), 0.0),
        ("hzct", usual.clone(), 0.0),
        ("sslr", usual.clone(), 0.03),
        ("linear", author.clone(), 0.0),
        ("linear", fixed, 0.0),
        ("poster", author, 0.0),
        ("poster", volume, 0.0),
        ("ssr", usual.clone(), 0.0),
        ("ssr-fast", usual.clone(), 0.0),
        // The wall is a side of the proxy box, so that the map is exact there.
        ("pccm", usual, 0.0),
    ] {
        let globals = Globals { roughness: Some(roughness), ..Globals::default() };
        let shown = show(&gpu, &scene, view, method, &setup, &globals);
        let (lit, reflection) = (shown.get("color"), shown.get("reflection"));
        // The direct view: rows count from the top, so that the top rows show the top quarters.
        assert_eq!(bytes(lit.texel(40, 10)), GREEN);
        assert_eq!(bytes(lit.texel(280, 10)), WHITE);
        assert_eq!(bytes(lit.texel(40, 130)), BLUE);
        assert_eq!(bytes(lit.texel(280, 130)), RED);
        // In the floor, up and down change places. SSLR's blur may mix in a hundredth of the next quarter, which is 25
        // in sRGB.
        let slack = if roughness > 0.0 { 25 } else { 0 };
        for (x, y, color) in [(40, 160, BLUE), (280, 160, RED), (40, 235, GREEN), (280, 235, WHITE)] {
            let found = bytes(reflection.texel(x, y));
            let near = found.iter().zip(color).all(|(f, c)| f.abs_diff(c) <= slack);
            assert!(near, "{method}, {setup:?}, ({x}, {y}): {found:?}, not {color:?}");
        }
        assert_eq!(reflection.texel(40, 10), [0.0; 4], "the wall does not reflect");
    }
}

/// Returns the number of pixels of an image, and the number of those that differ from another image in a bit.
fn differing(a: &Pixels, b: &Pixels) -> [f64; 2] {
    let bits = |pixel: &[f32]| pixel.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    let differing_pixels = a.texels().zip(b.texels()).filter(|(a, b)| bits(a) != bits(b)).count();
    [a.texels().count() as f64, differing_pixels as f64]
}

/// Each screen-space method makes one image whether its trace is split in two passes, combined in one, or also stores
/// hits. These are different programs, and measurements of one must hold for the others.
#[test]
fn split_combined_and_with_hits_give_the_same_reflection() {
    let gpu = gpu();
    let extent = [161, 119];
    for method in methods::METHODS.iter().filter(|m| m.is_screen_space()) {
        for (preset, roughness) in [(Preset::Published, 0.0), (Preset::Published, 0.3), (Preset::Author, 0.1)] {
            let globals = Globals { roughness: Some(roughness), ..Globals::default() };
            let shown = |split: bool, wants: Wants| {
                let setup = Setup::new(extent).of_preset(preset).with(|p: &mut ThesisDrawing| p.split = split);
                show_with(&gpu, &clutter(), (clutter_camera(extent), &globals), method.name, &setup, wants)
            };
            let combined = shown(false, Wants::REFLECTION);
            for (other, drawn_how) in
                [(shown(true, Wants::REFLECTION), "split"), (shown(false, Wants::HITS), "with hits")]
            {
                for image_name in ["reflection", "composite"] {
                    let [all, differing_pixels] = differing(other.get(image_name), combined.get(image_name));
                    let case =
                        format!("{}, {preset:?}, roughness {roughness}: the {image_name}, {drawn_how}", method.name);
                    assert!(
                        differing_pixels <= tolerated_share(&gpu) * all,
                        "{case}: {differing_pixels} of {all} pixels differ"
                    );
                }
            }
        }
    }
}

/// At roughness 0.3, reflections of the two cone methods have less than 0.8 of the contrast of a mirror, and about the
/// same mean.
#[test]
fn roughness_changes_the_reflection() {
    let gpu = gpu();
    let case = Case { roll: 0.0 };
    let extent = [320, 240];
    for method in ["ssct", "hzct"] {
        let [mirror, rough] = [0.0, 0.3].map(|roughness| {
            let globals = Globals { roughness: Some(roughness), ..Globals::default() };
            show(&gpu, &case.scene(), case.camera(extent), method, &Setup::new(extent), &globals)
        });
        assert_eq!(mirror.get("color"), rough.get("color"), "the lit colour does not change");
        let difference = rmse(&mirror.get("reflection").values, &rough.get("reflection").values);
        assert!(difference > 0.02, "{method}: {difference}");
        // Returns the mean and the standard deviation of red in a part of a row.
        let spread = |shown: &Shown| {
            let reds: Vec<f32> = (120..200).map(|x| shown.get("reflection").texel(x, 220)[0]).collect();
            let mean = reds.iter().sum::<f32>() / reds.len() as f32;
            (mean, (reds.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / reds.len() as f32).sqrt())
        };
        let ((mean_mirror, sharp), (mean_rough, soft)) = (spread(&mirror), spread(&rough));
        assert!(soft < 0.8 * sharp, "{method}: {sharp} {soft}");
        assert!((mean_mirror - mean_rough).abs() < 0.15, "{method}: {mean_mirror} {mean_rough}");
    }
}

/// At reflectivity 0, every screen-space method leaves the lit colour unchanged to the bit, and traces no ray. At
/// reflectivity 1 the image changes.
#[test]
fn without_reflectivity_the_composite_is_the_lit_colour() {
    let gpu = gpu();
    let extent = [321, 239];
    for method in methods::METHODS.iter().filter(|m| m.is_screen_space()) {
        let shown = |reflectivity| {
            let globals = Globals { reflectivity, ..Globals::default() };
            let setup = Setup::new(extent);
            show(&gpu, &clutter(), clutter_camera(extent), method.name, &setup, &globals)
        };
        let dull = shown(0.0);
        for (composite, lit) in dull.get("composite").texels().zip(dull.get("color").texels()) {
            assert_eq!(
                [0, 1, 2].map(|c| composite[c].to_bits()),
                [0, 1, 2].map(|c| lit[c].to_bits()),
                "{}",
                method.name
            );
        }
        if dull.has("hits") {
            assert!(dull.get("hits").texels().all(|h| path(h) == PathCode::None));
        }
        assert!(rmse(&shown(1.0).get("composite").values, &dull.get("composite").values) > 0.01, "{}", method.name);
    }
}

/// Pixels of sky and of windows do not reflect. Rays that meet a window hit it within 2.54 pixels and show the colour
/// at the hit. A window shows the sky but has depth, so that it is taken for sky easily.
#[test]
fn sky_does_not_reflect_but_windows_are_hit() {
    let gpu = gpu();
    let mut b = Builder::new("window");
    let window = b.material(window());
    b.quad(window, Vec3::new(-2.0, 0.0, 6.0), Vec3::X * 4.0, Vec3::Y * 3.0, -Vec3::Z);
    let mirror = b.mirror();
    b.quad(mirror, Vec3::new(-3.0, 0.0, 1.0), Vec3::X * 6.0, Vec3::Z * 5.0, Vec3::Y);
    let extent = [320, 240];
    let view = camera(EYE.as_vec3(), EYE.as_vec3() + Vec3::Z, extent);
    for method in ["ssct", "hzct"] {
        let setup = unfaded(extent);
        let shown = show(&gpu, &b.0, view, method, &setup, &Globals::default());
        let (depth, hits, lit) = (shown.get("depth"), shown.get("hits"), shown.get("color"));
        let (mut sky, mut glass, mut in_mirror) = (0, 0, 0);
        for (y, x) in (0..extent[1]).flat_map(|y| (0..extent[0]).map(move |x| (y, x))) {
            let reflection = shown.get("reflection").texel(x, y);
            let is_mirror = shown.get("material").texel(x, y)[0] > 0.5;
            if !is_mirror {
                assert_eq!(path(hits.texel(x, y)), PathCode::None, "({x}, {y})");
                assert_eq!(reflection, [0.0; 4], "({x}, {y})");
                assert_eq!(shown.get("composite").texel(x, y)[..3], lit.texel(x, y)[..3], "({x}, {y})");
                assert!(lit.texel(x, y)[2] > 0.05, "sky and windows show the environment");
                sky += usize::from(depth.texel(x, y)[0] == 0.0);
                glass += usize::from(depth.texel(x, y)[0] > 0.0);
                continue;
            }
            let uv = DVec2::new((f64::from(x) + 0.5) / 320.0, (f64::from(y) + 0.5) / 240.0);
            let (origin, reflected) = mirror_ray(&shown, uv, -EYE, DVec3::Y);
            let point = origin + reflected * ((6.0 - origin.z) / reflected.z);
            if point.x.abs() < 1.8 && (0.2..2.8).contains(&(point.y + EYE.y)) {
                let expected = on_screen(&shown, point).expect("the window is on screen");
                let hit = hits.texel(x, y);
                assert_eq!(path(hit), PathCode::HiZ, "{method}, ({x}, {y})");
                let error = (DVec2::new(f64::from(hit[0]), f64::from(hit[1])) - expected) * DVec2::new(320.0, 240.0);
                // The bound is that of `mirror_rays_meet_the_wall_where_they_should`: 2 · 1.02 + 0.5 pixels.
                assert!(error.abs().max_element() < 2.54, "{method}, ({x}, {y}): {error} pixels off");
                let seen = bilinear(lit, hit[0], hit[1]);
                for c in 0..3 {
                    // The bound has 8 bits of a filter's weights, and the rounding of 16-bit floats.
                    assert!((reflection[c] - seen[c]).abs() < 0.003, "({x}, {y}): {reflection:?} {seen:?}");
                }
                in_mirror += 1;
            }
        }
        assert!(sky > 1000 && glass > 1000 && in_mirror > 1000, "{sky} {glass} {in_mirror}");
    }
}
