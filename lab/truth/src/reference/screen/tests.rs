//! Tests against closed forms first, then the statistical properties of a Monte Carlo image.

use super::*;
use crate::reference::Oracle;
use crate::reference::ray::RaySetup;
use crate::reference::surface::sky_color;
use crate::reference::testing::{flat_wall, floor_and_wall};
use ssct_scenes::{Camera, Surface};

const SAMPLING: Sampling = Sampling { samples: 64, seed: 1, oracle: OracleVersion::V1, bounces: 1 };

/// Returns the G-buffer of a floor and a wall, and the mask of its reflecting pixels. The lit colour is striped. The
/// floor has the given roughness, and only the floor reflects.
fn stage(roughness: f32) -> (GBufferData, Vec<bool>) {
    let mut gbuffer = floor_and_wall(32, 18);
    for (i, color) in gbuffer.color.iter_mut().enumerate() {
        let (x, y) = (i % 32, i / 32);
        *color = Vec3::new((x % 4) as f32 / 3.0, y as f32 / 17.0, 0.5);
    }
    gbuffer.roughness.fill(roughness);
    // The normal's y is 1 on the floor and 0 on the wall.
    for (reflectivity, normal) in gbuffer.reflectivity.iter_mut().zip(&gbuffer.normal) {
        *reflectivity = normal.y;
    }
    let mask = gbuffer.reflecting();
    (gbuffer, mask)
}

/// Returns the lit colour that a ray from the pixel `start_pixel` sees where it hits the pixel (x, y) at `position`.
fn shown_color(
    gbuffer: &GBufferData,
    start_pixel: [u32; 2],
    direction: DVec3,
    [x, y]: [u32; 2],
    position: DVec3,
) -> DVec3 {
    let rays = RaySetup::new(gbuffer);
    let start = rays.position(start_pixel[0], start_pixel[1]).zip(rays.normal(start_pixel[0], start_pixel[1]));
    let ray = start.map(|(point, normal)| ReflectedRay { point, normal, direction });
    SurfaceColors::new(gbuffer).shown(gbuffer.index(x, y), [position.x, position.y], DVec3::Z, ray)
}

/// Returns the view-space direction of the camera ray through pixel (x, y) for a sample, as the reference draws it.
fn footprint_ray(rays: &RaySetup, [x, y]: [u32; 2], sample: u64) -> DVec3 {
    let stream = Stream::new(SAMPLING.seed, rays.gbuffer.index(x, y) as u64);
    rays.camera_ray(f64::from(x) + stream.uniform(4 * sample + 2), f64::from(y) + stream.uniform(4 * sample + 3))
}

/// Returns the screen reference of the stage whose floor has this roughness.
fn render(roughness: f32, sampling: Sampling) -> ScreenReference {
    let (gbuffer, mask) = stage(roughness);
    ScreenReference::render(&gbuffer, &mask, sampling)
}

#[test]
fn a_ray_goes_on_where_it_was_reflected() {
    // Wall and floor are mirrors of different reflectivity.
    let (mut gbuffer, _) = stage(0.0);
    for (reflectivity, normal) in gbuffer.reflectivity.iter_mut().zip(&gbuffer.normal) {
        *reflectivity = if normal.y > 0.5 { 0.5 } else { 0.25 };
    }
    let (oracle, rays) = (Oracle::new(&gbuffer), RaySetup::new(&gbuffer));
    let reflection = |bounces| {
        let sampling = Sampling { samples: MIRROR_SAMPLES_MIN, bounces, ..SAMPLING };
        ScreenReference::render(&gbuffer, &gbuffer.reflecting(), sampling).color
    };
    // The colour that a ray from a pixel brings over three bounces, followed by the oracle.
    let path = |from: [u32; 2], towards: DVec3| {
        let (mut from, mut direction, mut radiance, mut throughput) = (from, towards, DVec3::ZERO, 1.0);
        for _ in 0..3 {
            let normal = rays.normal(from[0], from[1]).expect("a normal");
            let hit = oracle.trace_direction(from[0], from[1], direction).outcome;
            let (Outcome::Hit { pixel, position }, true) = (hit, direction.dot(normal) > 0.0) else { break };
            radiance += throughput * shown_color(&gbuffer, from, direction, pixel, position);
            throughput *= f64::from(gbuffer.reflectivity[gbuffer.index(pixel[0], pixel[1])]);
            let normal = rays.normal(pixel[0], pixel[1]).expect("a normal");
            (from, direction) = (pixel, direction - 2.0 * direction.dot(normal) * normal);
        }
        radiance
    };
    let (one_bounce, three_bounces) = (reflection(1), reflection(3));
    let mut changed_pixels = 0;
    for (i, found) in three_bounces.iter().enumerate() {
        let from = [i as u32 % 32, i as u32 / 32];
        let normal = rays.normal(from[0], from[1]).expect("a mirror");
        let samples = u64::from(MIRROR_SAMPLES_MIN);
        let sum: DVec3 =
            (0..samples).map(|sample| path(from, footprint_ray(&rays, from, sample).reflect(normal))).sum();
        let expected = sum / samples as f64;
        assert!((expected.as_vec3() - *found).length() < 1e-6, "{i}: {expected} {found}");
        changed_pixels += usize::from(*found != one_bounce[i]);
    }
    assert!(changed_pixels > 5, "{changed_pixels}");
}

#[test]
fn nearly_a_mirror_is_nearly_the_mirrors_image() {
    let (mirror, glossy) = (render(0.0, SAMPLING), render(1e-4, SAMPLING));
    for (a, b) in mirror.color.iter().zip(&glossy.color) {
        assert!((*a - *b).length() < 0.01, "{a} {b}");
    }
}

#[test]
fn directions_have_the_moments_of_the_lobe() {
    // For the density (α + 1) / 2π cos^α: E cos = (α + 1) / (α + 2), E cos² = (α + 1) / (α + 3), and the mean
    // direction is the axis.
    let axis = DVec3::new(0.3, -0.5, 0.8).normalize();
    let stream = Stream::new(5, 0);
    for exponent in [0.0, 1.0, 30.0, 4512.0] {
        let count = 40_000_u64;
        let [mut sum, mut cosine, mut square] = [DVec3::ZERO, DVec3::ZERO, DVec3::ZERO];
        for i in 0..count {
            let direction = lobe_direction(axis, exponent, [stream.uniform(2 * i), stream.uniform(2 * i + 1)]);
            assert!((direction.length() - 1.0).abs() < 1e-12 && direction.dot(axis) >= 0.0);
            sum += direction;
            cosine.x += direction.dot(axis);
            square.x += direction.dot(axis).powi(2);
        }
        let [mean, mean_square] = [cosine.x, square.x].map(|sum_x| sum_x / count as f64);
        let expected = [(exponent + 1.0) / (exponent + 2.0), (exponent + 1.0) / (exponent + 3.0)];
        let standard_error = (expected[1] - expected[0].powi(2)).sqrt() / (count as f64).sqrt();
        assert!((mean - expected[0]).abs() < 5.0 * standard_error, "α {exponent}: {mean} {expected:?}");
        assert!((mean_square - expected[1]).abs() < 10.0 * standard_error, "α {exponent}: {mean_square} {expected:?}");
        let sideways = (sum / count as f64).reject_from(axis).length();
        assert!(sideways < 4.0 / (count as f64).sqrt() * (1.0 - expected[1]).sqrt(), "α {exponent}: {sideways}");
    }
}

#[test]
fn directions_below_the_surface_carry_nothing_and_count() {
    // Where the floor meets the wall, mirror rays rise by 16°, so that a lobe with ϱ = 0.6 reaches below the floor. The
    // expected sum is computed from rays that the oracle traces.
    let (gbuffer, mask) = stage(0.6);
    let sampling = Sampling { samples: 200, ..SAMPLING };
    let image = ScreenReference::render(&gbuffer, &mask, sampling);
    let (oracle, rays) = (Oracle::new(&gbuffer), RaySetup::new(&gbuffer));
    let (x, y) = (16, 12);
    let normal = rays.normal(x, y).expect("floor");
    let stream = Stream::new(SAMPLING.seed, gbuffer.index(x, y) as u64);
    let (mut sum, mut below_surface, mut would_hit) = (DVec3::ZERO, 0, 0);
    for i in 0..200 {
        let random_pair = [stream.uniform(4 * i), stream.uniform(4 * i + 1)];
        let mirror = footprint_ray(&rays, [x, y], i).reflect(normal);
        let direction = lobe_direction(mirror, phong::exponent(f64::from(0.6_f32)), random_pair);
        let hit = oracle.trace_direction(x, y, direction).outcome;
        if direction.dot(normal) <= 0.0 {
            below_surface += 1;
            would_hit += usize::from(matches!(hit, Outcome::Hit { .. }));
        } else if let Outcome::Hit { pixel, position } = hit {
            sum += shown_color(&gbuffer, [x, y], direction, pixel, position);
        }
    }
    assert!(
        below_surface > 10 && would_hit > 5,
        "{below_surface} rays below the surface, {would_hit} of which would hit the floor"
    );
    let found = image.color[gbuffer.index(x, y)].as_dvec3();
    assert!((found - sum / 200.0).length() < 1e-6, "{found} {}", sum / 200.0);
}

#[test]
fn the_mean_and_its_error_are_those_of_a_hand_computation() {
    // Samples 1, 2, 6: mean 3, variance (4 + 1 + 9) / 2 = 7, standard error √(7 / 3).
    let estimate = mean_and_error([1.0, 2.0, 6.0].into_iter().map(DVec3::splat));
    assert!((estimate.mean - 3.0).length() < 1e-12);
    assert!((estimate.standard_error - (7.0_f64 / 3.0).sqrt()).length() < 1e-12);
    assert_eq!(mean_and_error([DVec3::ONE].into_iter()).standard_error, DVec3::INFINITY);
}

#[test]
fn the_standard_error_is_how_far_independent_images_are_apart() {
    let [a, b] = [1, 2].map(|seed| render(0.3, Sampling { seed, ..SAMPLING }));
    let (_, mask) = stage(0.3);
    // The mean squared difference in units of its variance should be 1. Over some 300 pixels and 2 channels its
    // standard deviation is below 0.1. (The third channel is constant where all rays hit.)
    let mut squared_scores = Vec::new();
    for i in (0..mask.len()).filter(|i| mask[*i]) {
        for channel in 0..2 {
            let variance = a.standard_error[i][channel].powi(2) + b.standard_error[i][channel].powi(2);
            if variance > 1e-6 {
                squared_scores.push(f64::from((a.color[i][channel] - b.color[i][channel]).powi(2) / variance));
            }
        }
    }
    let mean = squared_scores.iter().sum::<f64>() / squared_scores.len() as f64;
    assert!(squared_scores.len() > 200 && (0.75..1.25).contains(&mean), "{mean} over {}", squared_scores.len());
    assert!(a.overall_standard_error > 0.005 && a.overall_standard_error < 0.1);
    // Four times the samples give half the error.
    let finer = render(0.3, Sampling { samples: 256, seed: 3, ..SAMPLING });
    let ratio = a.overall_standard_error / finer.overall_standard_error;
    assert!((1.85..2.15).contains(&ratio), "{ratio}");
}

#[test]
fn the_image_does_not_depend_on_the_number_of_threads() {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    assert_eq!(one.install(|| render(0.3, SAMPLING)), render(0.3, SAMPLING));
}

#[test]
fn an_error_between_two_bands_ends_the_rendering() {
    let (gbuffer, mask) = stage(0.1);
    let render_until = |allowed_calls: u32| {
        let mut calls = 0;
        let image = ScreenReference::render_while(&gbuffer, &mask, SAMPLING, &mut || {
            calls += 1;
            if calls > allowed_calls { Err("stop") } else { Ok(()) }
        });
        (image, calls)
    };
    let bands = gbuffer.height.div_ceil(BAND_ROWS);
    assert!(bands > 1);
    assert_eq!(render_until(bands), (Ok(ScreenReference::render(&gbuffer, &mask, SAMPLING)), bands));
    assert_eq!(render_until(bands - 1), (Err("stop"), bands));
}

#[test]
fn the_mask_restricts() {
    let (gbuffer, mut mask) = stage(0.1);
    let full_image = ScreenReference::render(&gbuffer, &mask, SAMPLING);
    mask[gbuffer.index(5, 15)] = false;
    let restricted_image = ScreenReference::render(&gbuffer, &mask, SAMPLING);
    for (i, masked) in mask.iter().enumerate() {
        assert_eq!(restricted_image.color[i], if *masked { full_image.color[i] } else { Vec3::ZERO });
    }
}

#[test]
fn colours_are_bilinear_between_centres_and_clamped_at_the_border() {
    let mut gbuffer = flat_wall(3, 2, 1.0);
    for (i, color) in gbuffer.color.iter_mut().enumerate() {
        *color = Vec3::splat([0.0, 4.0, 8.0, 1.0, 5.0, 9.0][i]);
    }
    for (x, y, expected) in [
        (0.5, 0.5, 0.0),
        (1.5, 1.5, 5.0),
        (1.0, 0.5, 2.0),
        (1.75, 1.0, 5.5),
        (0.0, 0.0, 0.0),
        (3.0, 2.0, 9.0),
        (3.0, 1.0, 8.5),
    ] {
        let pixel = [f64::min(x, 2.5), f64::min(y, 1.5)].map(|v| v as u32);
        let found = SurfaceColors::new(&gbuffer).shown(gbuffer.index(pixel[0], pixel[1]), [x, y], DVec3::Z, None);
        assert_eq!(found, DVec3::splat(expected), "({x}, {y})");
    }
}

#[test]
fn rays_are_drawn_by_their_numbers() {
    for roughness in [0.0, 0.3] {
        let (gbuffer, mask) = stage(roughness);
        let image = ScreenReference::render(&gbuffer, &mask, SAMPLING);
        let (hierarchy, rays) = (Hierarchy::new(&gbuffer), RaySetup::new(&gbuffer));
        let pixels = (0..gbuffer.height).flat_map(|y| (0..gbuffer.width).map(move |x| (x, y)));
        for (x, y) in pixels.filter(|(x, y)| mask[gbuffer.index(*x, *y)]) {
            let normal = rays.normal(x, y).expect("floor");
            let stream = Stream::new(SAMPLING.seed, gbuffer.index(x, y) as u64);
            let colors = (0..u64::from(SAMPLING.samples)).map(|i| {
                let random_pair = [stream.uniform(4 * i), stream.uniform(4 * i + 1)];
                let mirror = footprint_ray(&rays, [x, y], i).reflect(normal);
                let direction = lobe_direction(mirror, phong::exponent(f64::from(roughness)), random_pair);
                match hierarchy.trace_direction(x, y, direction).outcome {
                    Outcome::Hit { pixel, position } if direction.dot(normal) > 0.0 => {
                        shown_color(&gbuffer, [x, y], direction, pixel, position)
                    }
                    _ => DVec3::ZERO,
                }
            });
            let expected = mean_and_error(colors);
            let i = gbuffer.index(x, y);
            let found = (image.color[i], image.standard_error[i]);
            let expected = (expected.mean.as_vec3(), expected.standard_error.as_vec3());
            assert_eq!(found, expected, "({x}, {y}) at {roughness}, to the bit");
        }
    }
}

#[test]
fn a_mirror_filters_a_striped_wall_over_the_pixel() {
    // Columns are black and white in turns. The reflecting pixel's centre lies at view depth z. A ray through a place u
    // (0 to 1) of the pixel's width ends on the wall at z = 5, off the column's centre by (u − ½) (5 − z) / 5 of a
    // pixel. The bilinear colour there is this distance in a black column, and 1 minus the distance in a white one.
    // Averaged over u, the colours are w/4 and 1 − w/4 with w = (5 − z) / 5.
    let (mut gbuffer, mask) = stage(0.0);
    for (i, color) in gbuffer.color.iter_mut().enumerate() {
        *color = Vec3::splat((i % 2) as f32);
    }
    let image = ScreenReference::render(&gbuffer, &mask, Sampling { samples: 1024, ..SAMPLING });
    let (hierarchy, rays) = (Hierarchy::new(&gbuffer), RaySetup::new(&gbuffer));
    let mut scores = Vec::new();
    for (x, y) in (0..gbuffer.height).flat_map(|y| (1..gbuffer.width - 1).map(move |x| (x, y))) {
        let i = gbuffer.index(x, y);
        // All rays of the pixel reach the wall.
        let end = mask[i].then(|| hierarchy.trace(x, y).position()).flatten();
        if end.is_none_or(|p| p.y < 2.0 || (p.x - 0.5 - f64::from(x)).abs() > 0.01) {
            continue;
        }
        let width = (5.0 - rays.position(x, y).expect("floor").z) / 5.0;
        let expected = if x % 2 == 1 { 1.0 - width / 4.0 } else { width / 4.0 };
        // |u − ½| w has the variance w² / 48.
        let error = f64::from(image.standard_error[i].x);
        let expected_error = width / 48_f64.sqrt() / 1024_f64.sqrt();
        assert!((error / expected_error - 1.0).abs() < 0.15, "({x}, {y}): {error} {expected_error}");
        scores.push((f64::from(image.color[i].x) - expected) / error);
    }
    let chi2: f64 = scores.iter().map(|score| score * score).sum::<f64>() / scores.len() as f64;
    assert!(scores.len() > 50 && (0.5..1.5).contains(&chi2), "χ² {chi2} of {}", scores.len());
}

#[test]
fn a_mirror_takes_at_least_sixteen_rays() {
    let reference = |samples| render(0.0, Sampling { samples, ..SAMPLING });
    let [one_ray, sixteen_rays, seventeen_rays] = [1, 16, 17].map(reference);
    assert!(one_ray.overall_standard_error > 0.0 && one_ray.overall_standard_error.is_finite());
    assert!(one_ray == sixteen_rays && sixteen_rays != seventeen_rays);
    assert_eq!(
        render(0.3, Sampling { samples: 1, ..SAMPLING }).overall_standard_error,
        f64::INFINITY,
        "a lobe takes one"
    );
}

#[test]
fn a_window_shows_the_environment_along_the_ray_and_other_surfaces_the_screen() {
    let (mut gbuffer, mask) = stage(0.0);
    // The camera is turned, so that directions in the view and in the world differ.
    gbuffer.camera =
        Camera::new(Vec3::new(3.0, 1.0, 2.0), Vec3::new(1.0, 1.5, 3.0), gbuffer.camera.lens, gbuffer.camera.aspect);
    gbuffer.color.fill(Vec3::new(9.0, 0.0, 9.0));
    for i in (0..mask.len()).filter(|i| !mask[*i] && i % 32 < 16) {
        gbuffer.surface[i] = Surface::Sky;
    }
    let image = ScreenReference::render(&gbuffer, &mask, Sampling { samples: 256, ..SAMPLING });
    let (hierarchy, rays) = (Hierarchy::new(&gbuffer), RaySetup::new(&gbuffer));
    let view_to_world = gbuffer.camera.world_to_view.as_dmat4().inverse();
    let [mut windows, mut walls] = [0, 0];
    for (x, y) in (0..gbuffer.height).flat_map(|y| (0..gbuffer.width).map(move |x| (x, y))) {
        let i = gbuffer.index(x, y);
        let end = mask[i].then(|| hierarchy.trace(x, y).position()).flatten();
        // All rays of the pixel reach the same half of the wall.
        if end.is_none_or(|p| p.y < 2.0 || (p.x - 16.0).abs() < 1.5) {
            continue;
        }
        if x > 16 {
            assert_eq!(image.color[i], Vec3::new(9.0, 0.0, 9.0));
            walls += 1;
            continue;
        }
        // Averages over a grid of places within the pixel; the floor reverses the sign of y.
        let grid_side = 16;
        let places = (0..grid_side * grid_side)
            .map(|k| [k % grid_side, k / grid_side].map(|v| (f64::from(v) + 0.5) / f64::from(grid_side)));
        let sum: DVec3 = places
            .map(|[u, v]| {
                let incoming = rays.camera_ray(f64::from(x) + u, f64::from(y) + v);
                sky_color(view_to_world.transform_vector3(incoming * DVec3::new(1.0, -1.0, 1.0)))
            })
            .sum();
        let (difference, error) =
            (image.color[i].as_dvec3() - sum / f64::from(grid_side * grid_side), image.standard_error[i].as_dvec3());
        assert!(difference.abs().cmple(5.0 * error + 1e-3).all(), "({x}, {y}): {difference} {error}");
        windows += 1;
    }
    assert!(windows > 20 && walls > 20, "{windows} {walls}");
    // If the G-buffer marks no surface as sky, the screen's colour is used.
    gbuffer.surface.fill(Surface::Lit);
    let without_windows = ScreenReference::render(&gbuffer, &mask, SAMPLING);
    assert!(without_windows.color.iter().all(|c| c.y == 0.0 && c.x <= 9.0));
}

#[test]
fn a_ray_beyond_the_far_plane_shows_the_sky_of_the_screen_and_no_other_miss_does() {
    let (mut gbuffer, mask) = stage(0.0);
    for i in (0..mask.len()).filter(|i| !mask[*i]) {
        (gbuffer.depth[i], gbuffer.normal[i], gbuffer.color[i]) = (0.0, Vec3::ZERO, Vec3::new(0.25, 0.5, 0.75));
    }
    let image = ScreenReference::render(&gbuffer, &mask, SAMPLING);
    let hierarchy = Hierarchy::new(&gbuffer);
    let [mut shown, mut black] = [0, 0];
    for (x, y) in
        (0..gbuffer.height).flat_map(|y| (1..31).map(move |x| (x, y))).filter(|(x, y)| mask[gbuffer.index(*x, *y)])
    {
        let found = image.color[gbuffer.index(x, y)];
        match hierarchy.trace(x, y).outcome {
            // All rays of the pixel leave by the same side.
            Outcome::Miss { reason: MissReason::Far, .. } if y < 15 => {
                assert!((found - Vec3::new(0.25, 0.5, 0.75)).length() < 1e-6, "({x}, {y}): {found}");
                shown += 1;
            }
            Outcome::Miss { reason: MissReason::LeftScreen, .. } => {
                assert!(found.length() < 1.0);
                black += usize::from(found == Vec3::ZERO);
            }
            _ => {}
        }
    }
    assert!(shown > 50, "{shown} {black}");
}
