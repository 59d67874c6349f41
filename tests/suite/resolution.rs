//! Tests reflections at half resolution (thesis §4.4): they are in place, belong to the right surface, and take a
//! quarter of the rays.

use crate::common::{check_validation, clutter, clutter_camera, gpu, show};
use crate::unified::random_gbuffer;
use ssct::gpu::frame::Mode;
use ssct::gpu::{FrameContext, Pixels, ShaderStage};
use ssct::methods::ssct::ThesisDrawing;
use ssct::methods::{EffectParams, Setup, Wants, find};
use ssct::passes::gbuffer::GBufferImages;
use ssct::passes::resolution::DownsamplePass;
use ssct_lab::stage::{Globals, Shot, Stage};
use ssct_scenes::View;
use ssct_truth::metrics::rmse;

/// Glossy mirrors of full reflectivity.
const GLOSSY: Globals = Globals { roughness: Some(0.1), reflectivity: 1.0, normal_deviation: None };

/// Returns the values of an image that is moved right and down by whole pixels, with its border repeated.
fn moved(image: &Pixels, dx: i32, dy: i32) -> Vec<f32> {
    let shifted = |v: u32, d: i32, side: u32| (v as i32 - d).clamp(0, side as i32 - 1) as u32;
    let pixels = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    pixels.flat_map(|(x, y)| image.texel(shifted(x, dx, image.width), shifted(y, dy, image.height)).to_vec()).collect()
}

/// Returns a setup that traces one pixel of `divisor` × `divisor`.
fn divided(extent: [u32; 2], divisor: u32) -> Setup {
    Setup::new(extent).with(|p: &mut EffectParams| p.resolution_scale = 1.0 / divisor as f32)
}

/// The reflection at half resolution is nearer to the full one than to the full one moved by 2 pixels in any direction,
/// and errs by less than half of a black image. An offset of half a pixel in one of its passes would shift it.
#[test]
fn half_resolution_lies_where_full_resolution_does() {
    let gpu = gpu();
    // In `unified`, rays begin on the triangles that the small pixels show.
    let sizes = [[640, 480], [321, 239]];
    for (extent, method) in sizes.into_iter().flat_map(|extent| ["ssct", "unified"].map(|method| (extent, method))) {
        let shown = |divisor| {
            let setup = divided(extent, divisor);
            show(&gpu, &clutter(), clutter_camera(extent), method, &setup, &GLOSSY)
        };
        let (full, half) = (shown(1), shown(2));
        let (full, small) = (full.get("reflection"), half.get("reflection"));
        let error = rmse(&full.values, &small.values);
        let error_of_black = rmse(&full.values, &vec![0.0; full.values.len()]);
        println!("{method}, {extent:?}: half resolution errs by {error:.4}, no reflection by {error_of_black:.4}");
        assert!(error < 0.5 * error_of_black, "{extent:?}: {error} of {error_of_black}");
        for (dx, dy) in [(2, 0), (-2, 0), (0, 2), (0, -2)] {
            let error_if_moved = rmse(&full.values, &moved(small, dx, dy));
            assert!(error < error_if_moved, "{extent:?}: closer when moved by {dx}, {dy}: {error_if_moved} < {error}");
        }
        // Whether a pixel reflects is decided at full resolution.
        for ((full, small), material) in full.texels().zip(small.texels()).zip(half.get("material").texels()) {
            assert!(material[0] > 1e-4 || small == [0.0; 4], "{extent:?}: {full:?} became {small:?}");
        }
    }
}

/// Returns the bilinear mean of the full reflection at the traced pixels around a pixel, without regard to surfaces.
fn between_traced(full: &Pixels, x: u32, y: u32) -> Vec<f32> {
    // Pixels with even coordinates are traced. An odd one lies midway between the traced ones before and after it.
    let weighted_texel = |corner: u32| {
        let (across, down) = (corner & 1, corner >> 1);
        let share = |pixel: u32, step: u32| if pixel.is_multiple_of(2) { 1.0 - step as f32 } else { 0.5 };
        let traced = |pixel: u32, step: u32, side: u32| (pixel / 2 + step).min((side - 1) / 2) * 2;
        let weight = share(x, across) * share(y, down);
        full.texel(traced(x, across, full.width), traced(y, down, full.height)).iter().map(|v| weight * v).collect()
    };
    (0..4).map(weighted_texel).reduce(|a: Vec<f32>, b| a.iter().zip(&b).map(|(a, b)| a + b).collect()).unwrap()
}

/// In pixels whose traced neighbours lie on other surfaces, half resolution errs by less than 0.42 of plain
/// interpolation.
#[test]
fn half_resolution_takes_reflections_of_the_pixels_own_surface() {
    let gpu = gpu();
    let extent = [640, 480];
    let shown = |divisor| {
        let setup = divided(extent, divisor);
        show(&gpu, &clutter(), clutter_camera(extent), "ssct", &setup, &GLOSSY)
    };
    let (full, half) = (shown(1), shown(2));
    let (normals, full, half) = (full.get("normal"), full.get("reflection"), half.get("reflection"));
    // Returns whether a traced neighbour's normal is turned away from the pixel's normal.
    let has_turned_neighbour = |x: u32, y: u32| {
        let own = normals.texel(x, y);
        let facing = |n: &[f32]| n.iter().zip(own).take(3).map(|(a, b)| a * b).sum::<f32>();
        [(0, 0), (2, 0), (0, 2), (2, 2)]
            .iter()
            .any(|(dx, dy)| facing(normals.texel(x / 2 * 2 + dx, y / 2 * 2 + dy)) < 0.9)
    };
    let pixels = (0..extent[1] - 2).flat_map(|y| (0..extent[0] - 2).map(move |x| (x, y)));
    let edges: Vec<_> = pixels.filter(|&(x, y)| (x % 2, y % 2) != (0, 0) && has_turned_neighbour(x, y)).collect();
    let at_edges =
        |image: &dyn Fn(u32, u32) -> Vec<f32>| edges.iter().flat_map(|&(x, y)| image(x, y)).collect::<Vec<_>>();
    let truth = at_edges(&|x, y| full.texel(x, y).to_vec());
    let error = rmse(&truth, &at_edges(&|x, y| half.texel(x, y).to_vec()));
    let plain_error = rmse(&truth, &at_edges(&|x, y| between_traced(full, x, y)));
    println!(
        "{} pixels at edges: half resolution errs by {error:.4}, plain interpolation by {plain_error:.4}",
        edges.len()
    );
    assert!(edges.len() > 1000 && error < 0.42 * plain_error, "{error} of {plain_error}");
}

/// At half resolution, the trace has a quarter of the fragment invocations, within a 64th, if the device counts them.
/// The image alone does not show how many rays were traced.
#[test]
fn half_resolution_traces_a_quarter_of_the_pixels() {
    let gpu = gpu();
    let mut stage = Stage::new(&gpu, &clutter()).unwrap();
    let materials = GLOSSY.materials(&clutter(), &View::default());
    let mut invocations = |divisor| {
        let extent = [640, 480];
        let setup = divided(extent, divisor);
        let camera = clutter_camera(extent);
        let shot =
            Shot::new(&mut stage, find("ssct").unwrap(), &setup, Wants::REFLECTION, camera, materials.clone()).unwrap();
        let (report, _) = stage.run(&shot, Mode::Counted).unwrap();
        let index = report.recorded.iter().position(|p| p == "trace+cone").unwrap();
        report.work.get(index).map(|work| work.fragment_invocations)
    };
    let (Some(full), Some(half)) = (invocations(1), invocations(2)) else {
        println!("skipped: {} counts no invocations", gpu.info().name);
        return;
    };
    assert!(full >= 640 * 480 && half.abs_diff(full / 4) <= full / 64, "{half} of {full}");
}

/// At half resolution, no hits are handed on, not even by a trace in a pass of its own, which always has an image of them:
/// its pixels are not those of the full image.
#[test]
fn half_resolution_has_no_hits() {
    let (gpu, extent) = (gpu(), [67, 38]);
    for (divisor, has_hits) in [(1, true), (2, false)] {
        let setup = divided(extent, divisor).with(|p: &mut ThesisDrawing| p.split = true);
        let shown = show(&gpu, &clutter(), clutter_camera(extent), "ssct", &setup, &GLOSSY);
        assert_eq!(shown.image.hits.is_some(), has_hits, "one pixel of {divisor} × {divisor}");
    }
}

/// Downsampling by 2 and by 4 keeps depth, normal and material of the block's first pixel and the mean of its colours,
/// in both kinds of shader. A mean of depths would be a place at which nothing stands.
#[test]
fn a_block_has_the_surface_of_its_first_pixel_and_the_mean_of_its_colors() {
    let gpu = gpu();
    let mut context = FrameContext::new(&gpu).unwrap();
    let extent = [37, 22];
    let images = GBufferImages::upload(&mut context, &random_gbuffer(0, extent)).unwrap();
    let full = images.gbuffer();
    for (stage, divisor) in [(ShaderStage::Fragment, 2), (ShaderStage::Compute, 4)] {
        let pass = DownsamplePass::new(&gpu, stage, extent, divisor).unwrap();
        let mut frame = context.begin(Mode::Plain).unwrap();
        let small = pass.record(&mut frame, &full).unwrap();
        frame.finish().unwrap();
        let images = [[full.depth, small.depth], [full.normal, small.normal], [full.material, small.material]]
            .map(|images| images.map(|image| context.read(image.level(0)).unwrap()));
        for (x, y) in (0..images[0][1].height).flat_map(|y| (0..images[0][1].width).map(move |x| (x, y))) {
            for [whole, part] in &images {
                assert_eq!(
                    part.texel(x, y),
                    whole.texel(divisor * x, divisor * y),
                    "{stage:?}, 1/{divisor}, ({x}, {y})"
                );
            }
        }
        let [whole, part] = [full.color, small.color].map(|image| context.read(image.level(0)).unwrap());
        for (x, y) in (0..part.height).flat_map(|y| (0..part.width).map(move |x| (x, y))) {
            let column = |x: u32| divisor * x..(divisor * (x + 1)).min(whole.width);
            let row = divisor * y..(divisor * (y + 1)).min(whole.height);
            let places = row.flat_map(|y| column(x).map(move |x| (x, y)));
            let block: Vec<&[f32]> = places.map(|(x, y)| whole.texel(x, y)).collect();
            for channel in 0..3 {
                let mean = block.iter().map(|texel| texel[channel]).sum::<f32>() / block.len() as f32;
                let found = part.texel(x, y)[channel];
                let case = format!("{stage:?}, 1/{divisor}, ({x}, {y}), channel {channel}");
                assert!((found - mean).abs() <= 1e-3 * mean.abs().max(1.0), "{case}: {found}, not {mean}");
            }
        }
    }
    check_validation(&gpu).unwrap();
}
