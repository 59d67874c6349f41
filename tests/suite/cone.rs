//! Compares the cone of the shaders with `math::cone` (thesis §4.2.8, Eq. 4.5, 4.6, Alg. 5). From the hits and the
//! chains that were read back, the host predicts the reflection of every pixel.

use crate::common::{Builder, Shown, bilinear, camera, clutter, clutter_camera, gpu, show};
use glam::{DVec2, Vec3};
use ssct::gpu::Pixels;
use ssct::methods::Setup;
use ssct::passes::PathCode;
use ssct_ground::math::cone::{Circle, circles};
use ssct_ground::parameter::Preset;
use ssct_lab::stage::Globals;

/// Returns a trilinear sample of a chain at texture coordinates. The level is clamped to the levels of the chain.
fn trilinear(levels: &[&Pixels], position: DVec2, level: f64) -> [f64; 3] {
    let level = level.clamp(0.0, levels.len() as f64 - 1.0);
    let (fine, share) = (level as usize, level.fract());
    let coarse = (fine + 1).min(levels.len() - 1);
    let [a, b] = [fine, coarse].map(|l| bilinear(levels[l], position.x as f32, position.y as f32).map(f64::from));
    [0, 1, 2].map(|c| a[c] * (1.0 - share) + b[c] * share)
}

/// The greatest error of a device's trilinear sample. Its weights in x, y and level have at least 8 bits, so that each
/// of the three is off by half of 1/256. This counts times the contrast between texels, which is below 1 here.
const FILTER: f64 = 3.0 / 512.0;

/// Returns the colours that Alg. 5 may give for a pixel: one, or more where the sum of visibility is so near to 1 that
/// rounding decides whether another circle counts. `origin` and `hit` are texture coordinates of the ray's two ends.
fn predict(shown: &Shown, origin: DVec2, hit: DVec2, roughness: f64, preset: Preset) -> Vec<[f64; 3]> {
    let (color, visibility) = (shown.levels("color"), shown.levels("visibility"));
    let size = f64::from(color[0].width.max(color[0].height));
    let length = (hit - origin).length();
    let direction = (hit - origin) / length;
    // The half angle of the cone in radians, by Eq. 4.5 with the exponent of the roughness's lobe.
    let half_angle = roughness / 2.0;
    let (mut sum, mut weight, mut results) = ([0.0; 3], 0.0, Vec::new());
    let circles = circles(length, half_angle, 7, preset == Preset::Author);
    for (n, Circle { distance, radius }) in circles.into_iter().enumerate() {
        // The sum of visibility after n samples may be off by so much.
        let doubt = n as f64 * FILTER;
        if weight >= 1.0 - doubt {
            results.push(sum.map(|c| c / weight));
        }
        if weight > 1.0 + doubt {
            return results;
        }
        let position = origin + direction * distance;
        let level = (radius * size).log2();
        let share = trilinear(&visibility, position, level)[0];
        let sample = trilinear(&color, position, level);
        sum = [0, 1, 2].map(|c| sum[c] + share * sample[c]);
        weight += share;
    }
    results.push(sum.map(|c| c / weight));
    results
}

/// In the cluttered scene, at five combinations of method, preset and roughness, each reflection of a hit lies within 2
/// · FILTER of the predicted one.
#[test]
fn reflections_are_those_of_the_closed_form_circles() {
    // A reflection is a quotient of sums of samples, stored as a 16-bit float. Numerator and denominator are each off
    // by FILTER at most, and the level by about 1/256. The mean error is far smaller, since most neighbouring texels
    // hardly differ.
    let gpu = gpu();
    let extent = [321, 239];
    for (method, preset, roughness) in [
        ("ssct", Preset::Published, 0.0),
        ("ssct", Preset::Published, 0.1),
        ("ssct", Preset::Author, 0.3),
        ("hzct", Preset::Published, 0.6),
        ("hzct", Preset::Author, 1.0),
    ] {
        let setup = Setup::new(extent).of_preset(preset);
        let globals = Globals { roughness: Some(roughness), ..Globals::default() };
        let shown = show(&gpu, &clutter(), clutter_camera(extent), method, &setup, &globals);
        let (hits, reflection, material) = (shown.get("hits"), shown.get("reflection"), shown.get("material"));
        let (mut compared, mut worst, mut sum) = (0, 0.0_f64, 0.0);
        for (y, x) in (0..extent[1]).flat_map(|y| (0..extent[0]).map(move |x| (y, x))) {
            let hit = hits.texel(x, y);
            if !PathCode::from_channel(hit[3]).is_some_and(PathCode::is_hit) {
                continue;
            }
            let stored = f64::from(material.texel(x, y)[1]);
            let size = DVec2::new(f64::from(extent[0]), f64::from(extent[1]));
            let origin = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / size;
            let hit = DVec2::new(f64::from(hit[0]), f64::from(hit[1]));
            let found = reflection.texel(x, y);
            let greatest_difference =
                |p: &[f64; 3]| (0..3).map(|c| (f64::from(found[c]) - p[c]).abs()).fold(0.0, f64::max);
            let error = predict(&shown, origin, hit, stored, preset)
                .iter()
                .map(greatest_difference)
                .fold(f64::INFINITY, f64::min);
            assert!(error < 2.0 * FILTER, "{method}, {preset:?}, {roughness}, ({x}, {y}): {found:?} is {error} off");
            compared += 1;
            worst = worst.max(error);
            sum += error;
        }
        println!(
            "{method}, {preset:?}, roughness {roughness}: {compared} pixels, mean error {:.5}, worst {worst:.5}",
            sum / f64::from(compared)
        );
        assert!(compared > 5_000);
        assert!(sum / f64::from(compared) < 1e-3);
    }
}

/// If all lit surfaces have one colour, the reflection of a hit has exactly this colour at any roughness, within the
/// rounding of 16-bit floats. Weights of samples that do not cancel would darken or brighten it.
#[test]
fn one_colour_stays_that_colour_at_any_roughness() {
    // No sky is in view, so that the weights of the samples must cancel in the quotient C / C_alpha of Alg. 5.
    let gpu = gpu();
    let color = Vec3::new(0.5, 0.25, 0.75);
    let mut b = Builder::new("one colour");
    // A surface away from the light is lit to 0.2 (docs/definitions.md, "Surfaces"), and so are all here.
    let matt = b.matt(color);
    let mirror = b.matt(color);
    b.0.materials[mirror].reflectivity = 1.0;
    b.quad(matt, Vec3::new(-30.0, -2.0, 12.0), Vec3::X * 60.0, Vec3::Y * 40.0, -Vec3::Z);
    b.quad(mirror, Vec3::new(-12.0, 0.0, 0.0), Vec3::X * 24.0, Vec3::Z * 12.0, Vec3::Y);
    for n in 0..6 {
        let x = n as f32 * 1.7 - 4.0;
        b.quad(matt, Vec3::new(x, 0.0, 4.0 + n as f32), Vec3::X, Vec3::Y * (1.0 + 0.3 * n as f32), -Vec3::Z);
    }
    let extent = [321, 239];
    let view = camera(Vec3::new(0.0, 1.5, 0.0), Vec3::new(0.0, 1.2, 5.0), extent);
    for (preset, roughness) in
        [(Preset::Published, 0.0), (Preset::Published, 0.05), (Preset::Author, 0.3), (Preset::Author, 1.0)]
    {
        let setup = Setup::new(extent).of_preset(preset);
        let globals = Globals { roughness: Some(roughness), ..Globals::default() };
        let shown = show(&gpu, &b.0, view, "ssct", &setup, &globals);
        let lit = shown.get("color").texel(0, 0);
        assert!(shown.get("color").texels().all(|c| c == lit), "the scene has one colour");
        assert!(shown.levels("visibility")[4].values.iter().any(|v| *v < 0.95), "visibility varies");
        let mut hits = 0;
        for (hit, found) in shown.get("hits").texels().zip(shown.get("reflection").texels()) {
            if PathCode::from_channel(hit[3]).is_some_and(PathCode::is_hit) {
                hits += 1;
                for c in 0..3 {
                    // The result is rounded to a 16-bit float, after sums and a quotient in 32 bits.
                    assert!((found[c] - lit[c]).abs() <= lit[c] / 1000.0, "{preset:?}, {roughness}: {found:?} {lit:?}");
                }
            }
        }
        assert!(hits > 10_000, "{hits}");
    }
}
