//! Measures how the time of `unified` depends on what a frame needs and on the image's size. Prints a table to
//! standard output.
//!
//! "need": the six views of the built-in rooms at 960×540, in which every pixel reflects, only a rectangle with a tenth
//! of the pixels, or none. "growth": the same views at 640×480 and 1920×1080. Times are those of the effect: the median
//! of [`FRAMES`] frames by the device's timestamps, with the variants timed in turn.
//!
//! The columns on needs also give the share of the image that the drawn tiles cover, and the time of classification,
//! composite and colour chain, whose cost does not depend on the number of reflecting pixels. The columns on growth also
//! give how many cells of the pyramid the mirror ray of a pixel visits. They have the mean, and the mean of the greatest
//! number in each block of 4 × 2 pixels, for which eight threads in lockstep wait.

#![allow(clippy::expect_used)]

mod masked;

use masked::masked;
use ssct::gpu::FrameReport;
use ssct::gpu::frame::Mode;
use ssct::gpu::{DeviceQuery, FrameContext, Gpu};
use ssct::methods::{Effect, Input, Setup, Wants, unified};
use ssct::passes::gbuffer::GBufferImages;
use ssct::passes::tiles::TILE;
use ssct::passes::{GBuffer, Reflectors};
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{Camera, GBufferData, library};
use ssct_truth::metrics::bootstrap::median_of;
use ssct_truth::reference::unified::Traversal;
use std::collections::BTreeSet;

/// Number of frames that count.
const FRAMES: usize = 7;
/// Width and height in pixels of the frames for "need".
const SIZE: [u32; 2] = [960, 540];
/// The two sizes in pixels of the frames for "growth".
const GROWTH: [[u32; 2]; 2] = [[640, 480], [1920, 1080]];
/// The roughness values of all surfaces.
const ROUGHNESS: [f32; 3] = [0.0, 0.1, 0.3];

/// Returns the milliseconds of the effect, of its pyramid, and of the other passes whose time does not depend on the
/// number of reflecting pixels.
fn effect_ms(report: &FrameReport) -> [f64; 3] {
    let milliseconds = |is_wanted: &dyn Fn(&str) -> bool| {
        report.passes.iter().filter(|pass| pass.counted && is_wanted(&pass.name)).map(|pass| pass.ms).sum()
    };
    let is_fixed = |name: &str| ["classify", "composite", "color"].contains(&name.split('/').next().unwrap_or(name));
    [milliseconds(&|_| true), milliseconds(&|name| name == "pyramid"), milliseconds(&is_fixed)]
}

/// Returns the number of cells that mirror rays visit: the mean over the rays, and the mean of the greatest number in
/// each block of 4 × 2 pixels.
fn count_cells(data: &GBufferData) -> [f64; 2] {
    let (traversal, reflects) = (Traversal::new(data), data.reflecting());
    let steps = |x: u32, y: u32| {
        let ray = traversal.mirror_ray(x, y).filter(|_| reflects[data.index(x, y)]);
        ray.map_or(0, |(ray, _)| traversal.traverse(&ray).steps)
    };
    let (mut sum_of_means, mut sum_of_maxima) = (0.0, 0.0);
    for (top, left) in (0..data.height / 2).flat_map(|y| (0..data.width / 4).map(move |x| (2 * y, 4 * x))) {
        let block_steps: [i32; 8] = std::array::from_fn(|i| steps(left + i as u32 % 4, top + i as u32 / 4));
        sum_of_means += block_steps.iter().map(|steps| f64::from(*steps)).sum::<f64>() / 8.0;
        sum_of_maxima += f64::from(block_steps.into_iter().max().unwrap_or(0));
    }
    [sum_of_means, sum_of_maxima].map(|sum| sum / f64::from(data.width / 4 * (data.height / 2)))
}

/// Returns the share of the pixels that lie in tiles with at least one reflecting pixel; only these tiles are drawn.
fn covered_share(data: &GBufferData) -> f64 {
    let mut tiles = BTreeSet::new();
    for (pixel, _) in data.reflecting().iter().enumerate().filter(|(_, reflects)| **reflects) {
        tiles.insert([pixel as u32 % data.width / TILE, pixel as u32 / data.width / TILE]);
    }
    // Tiles at the right and lower border of the image may be cut off.
    let side = |tile: u32, size: u32| TILE.min(size - tile * TILE);
    let pixels: u32 = tiles.iter().map(|[x, y]| side(*x, data.width) * side(*y, data.height)).sum();
    f64::from(pixels) / data.depth.len() as f64
}

/// Records the effect on a G-buffer in a frame of its own, and returns the frame's times.
fn run_effect(context: &mut FrameContext, effect: &Effect, gbuffer: GBuffer, camera: &Camera) -> FrameReport {
    let mut frame = context.begin(Mode::Timed).expect("a frame");
    frame.begin_effect();
    effect.record(&mut frame, &Input::of_screen(gbuffer, camera)).expect("the effect");
    frame.finish().expect("the frame's end")
}

/// Measures both questions, "need" and "growth", at each roughness on each view of the rooms. Prints a row for each
/// view, and the medians over the views.
fn main() {
    let gpu = Gpu::open(&DeviceQuery::default()).expect("a Vulkan device");
    let scene = library::scene("rooms").expect("a built-in scene");
    let mut stage = Stage::new(&gpu, &scene).expect("device memory");
    println!("# {} ({}), ssct {}", gpu.info().name, gpu.info().driver, env!("CARGO_PKG_VERSION"));
    println!(
        "# need: what a tenth costs beyond its pyramid, over the full frame, and of that what no number of pixels changes; covered: the share of the pixels in tiles that are drawn; growth: time a pixel, large over small"
    );
    println!(
        "# cells, block_cells: the same ratio of the cells that mirror rays look at, on average and in step by eight"
    );
    println!("roughness,view,full_ms,tenth_ms,pyramid_ms,none_passes,need,fixed,covered,growth,cells,block_cells");
    for roughness in ROUGHNESS {
        let globals = Globals { roughness: Some(roughness), ..Globals::default() };
        let mut rows = Vec::new();
        for view in &scene.views {
            let materials = || globals.materials(&scene, view);
            let camera = view.camera(&scene, SIZE);
            let shot =
                Shot::new(&mut stage, &unified::INFO, &Setup::on_screen(SIZE), Wants::IMAGE, camera, materials())
                    .expect("a shot");
            let (_, drawn) = stage.run(&shot, Mode::Plain).expect("a frame");
            let data = gbuffer::read(&mut stage.context, &shot).expect("the G-buffer");
            let gbuffers = [1.0, 0.1, 0.0].map(|share| {
                let data = masked(&data, share);
                let reflecting = data.reflecting().iter().filter(|reflects| **reflects).count();
                let is_share = (reflecting as f64 / data.depth.len() as f64) < 1.02 * share + 1e-3;
                assert!(is_share, "{reflecting} pixels reflect");
                data
            });
            let images =
                gbuffers.each_ref().map(|data| GBufferImages::upload(&mut stage.context, data).expect("an upload"));
            let covered = covered_share(&gbuffers[1]);
            let all_pixels = drawn.reflectors;
            let reflectors = [all_pixels, Reflectors { everywhere: false, ..all_pixels }, Reflectors::default()];
            let effect = Effect::new(&mut stage.context, &unified::INFO, &Setup::on_screen(SIZE), Wants::IMAGE, None)
                .expect("the effect");
            let shots = GROWTH.map(|size| {
                let camera = view.camera(&scene, size);
                Shot::new(&mut stage, &unified::INFO, &Setup::on_screen(size), Wants::IMAGE, camera, materials())
                    .expect("a shot")
            });

            let cells_visited = shots.each_ref().map(|shot| {
                stage.run(shot, Mode::Plain).expect("a frame");
                count_cells(&gbuffer::read(&mut stage.context, shot).expect("the G-buffer"))
            });
            let [cells, block_cells] = [0, 1].map(|kind| cells_visited[1][kind] / cells_visited[0][kind]);

            // The times and the number of passes in each frame of a variant, and the time a pixel in each frame of a
            // size.
            let (mut need_frames, mut growth_frames) = ([vec![], vec![], vec![]], [vec![], vec![]]);
            for frame in 0..=FRAMES {
                for (i, (images, reflectors)) in images.iter().zip(reflectors).enumerate() {
                    let gbuffer = GBuffer { reflectors, ..images.gbuffer() };
                    let report = run_effect(&mut stage.context, &effect, gbuffer, &camera);
                    // The first frame of each variant compiles shaders.
                    if frame > 0 {
                        need_frames[i].push((effect_ms(&report), report.recorded.len()));
                    }
                }
                for (i, shot) in shots.iter().enumerate() {
                    let (report, _) = stage.run(shot, Mode::Timed).expect("a frame");
                    if frame > 0 {
                        growth_frames[i].push(effect_ms(&report)[0] / GROWTH[i].map(f64::from).iter().product::<f64>());
                    }
                }
            }
            // The median milliseconds of a variant, for a part of `effect_ms`: 0 for the whole effect.
            let median_ms = |variant: usize, part: usize| {
                median_of(need_frames[variant].iter().map(|(times_ms, _)| times_ms[part]))
            };
            let (full, tenth) = (median_ms(0, 0), median_ms(1, 0));
            let [pyramid, fixed] = [1, 2].map(|part| median_ms(1, part));
            let passes = need_frames[2].iter().map(|(_, passes)| *passes).max().unwrap_or(0);
            let [small, large] = growth_frames.map(median_of);
            let growth = large / small;
            let need = (tenth - pyramid) / full;
            let row = [full, tenth, pyramid, passes as f64, need, fixed / full, covered, growth, cells, block_cells];
            println!("{roughness},{},{}", view.name, row.map(|value| format!("{value:.3}")).join(","));
            rows.push(row);
        }
        let medians: Vec<_> =
            (0..rows[0].len()).map(|column| format!("{:.3}", median_of(rows.iter().map(|row| row[column])))).collect();
        println!("{roughness},median,{}", medians.join(","));
    }
}
