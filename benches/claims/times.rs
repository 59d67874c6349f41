//! Times variants in turn: each variant draws one frame before the first variant draws its next.
//!
//! Columns: claim, method, scene, view, variant, and then ratios of a variant's time over the first variant's time in
//! the same turn. `ratio` is the median for the effect, and `least` and `greatest` are the ends of the middle half.
//! `scene_ratio` is the median for the scene passes.
//!
//! - `pixel-step`: Schmidt's march with longer steps.
//! - `half`: half the resolution.
//! - `gaussian`: the colour chain by a Gaussian in place of the device's filter.
//! - `split`: ray trace and cone trace in two passes in place of one.
//! - `ray-traced`: the world reference of 16 rays a pixel on all cores, over Schmidt's optimised march, at 480×270.
//! - `true-minima`: for the Hi-Z buffer every texel that a cell covers is read, in place of four.
//! - `roughness`: roughness 0.3, 0.6 and 1, over 0.1.
//! - `angle`: the cone's angle is computed from the exponent of the lobe, in place of half the roughness, which is
//!   equal.
//! - `triangles`: a scene whose every triangle is cut into 16, which shows the same picture.
//! - `reflecting`: only a rectangle in the middle reflects, whose share of the pixels is the variant.

use super::edited::Edits;
use super::judged::TRUE_MINIMA;
use super::masked::masked;
use super::{Bench, Change, SAME, globals, method, scene};
use glam::{Vec2, Vec3, Vec4};
use ssct::gpu::FrameReport;
use ssct::gpu::frame::Mode;
use ssct::methods::setup::EffectParams;
use ssct::methods::ssct::ThesisDrawing;
use ssct::methods::ssr::SsrParams;
use ssct::methods::{Effect, Input, Setup, Wants};
use ssct::passes::color_chain::ChainFilter;
use ssct::passes::gbuffer::GBufferImages;
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{Mesh, Scene, Vertex, View};
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world::WorldReference;
use std::time::Instant;

/// Number of turns that count. One more turn before them does not.
const TURNS: usize = 11;
/// Width and height of the frames in pixels.
const SIZE: [u32; 2] = [960, 540];
/// Computes the cone's angle by Eq. 4.5 with an arc cosine, from the exponent of the lobe that a roughness stands for.
const ARC_COSINE: Edits = &[(
    "thesis/cone_angle.glsl",
    "return 0.5 * max(roughness, 0.0);",
    "return roughness <= 0.0 ? 0.0 : acos(pow(0.244, 1.0 / (log(0.244) / log(cos(0.5 * roughness)) - 1.0 + 1.0)));",
)];
/// Shares of the pixels that reflect.
const SHARES: [f64; 4] = [1.0, 0.5, 0.25, 0.1];

/// Milliseconds of the effect, and of the scene passes.
type Times = [f64; 2];

/// Sums the milliseconds of a frame's passes: those of the effect, which are marked as counted, and the others.
fn times(report: &FrameReport) -> Times {
    [true, false].map(|counted| report.passes.iter().filter(|pass| pass.counted == counted).map(|pass| pass.ms).sum())
}

/// Returns the value at a share (0…1) of the way through the sorted values, without interpolation.
fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share).round() as usize]
}

/// Returns the median of some values, and the two ends of their middle half (the quartiles).
pub fn spread(values: impl IntoIterator<Item = f64>) -> [f64; 3] {
    let values: Vec<_> = values.into_iter().collect();
    [0.5, 0.25, 0.75].map(|share| quantile(values.clone(), share))
}

/// Prints a row for each variant. Each of `turns` has the times of all variants, in their order.
fn print_rows(claim: &str, method: &str, (scene, view): (&str, &str), variants: &[&str], turns: &[Vec<Times>]) {
    for (index, variant) in variants.iter().enumerate() {
        // The ratios to the first variant: part 0 of the times is the effect, and part 1 the scene passes.
        let ratios = |part: usize| spread(turns.iter().map(|turn| turn[index][part] / turn[0][part]));
        let ([ratio, least, greatest], [scene_ratio, ..]) = (ratios(0), ratios(1));
        let scene_ratio = if scene_ratio.is_finite() { format!("{scene_ratio:.3}") } else { String::new() };
        println!("{claim},{method},{scene},{view},{variant},{ratio:.3},{least:.3},{greatest:.3},{scene_ratio}");
    }
}

/// A variant of a method.
struct Variant {
    /// The name of the variant in the table.
    name: &'static str,
    /// The change of parameters.
    change: Change,
    /// The changes of shaders.
    edits: Edits,
    /// The roughness and the normal deviation of the surfaces.
    globals: Globals,
}

/// Makes a variant by a change of parameters, at a roughness that is also the normal deviation.
fn changed(name: &'static str, roughness: f32, change: Change) -> Variant {
    Variant { name, change, edits: &[], globals: globals(roughness, roughness) }
}

/// Times variants of the method `name` in turn on a view, and prints their rows.
fn take_turns(bench: &Bench, claim: &str, name: &str, subject: (&Scene, &View, &mut Stage), variants: &[Variant]) {
    let (scene, view, stage) = subject;
    let shot = |variant: &Variant, stage: &mut Stage| {
        let materials = variant.globals.materials(scene, view);
        let setup = (variant.change)(&Setup::new(SIZE));
        bench.shaders.run_with(&bench.gpu, variant.edits, || {
            Shot::new(stage, method(name), &setup, Wants::IMAGE, view.camera(scene, SIZE), materials).expect("a shot")
        })
    };
    let shots: Vec<Shot> = variants.iter().map(|v| shot(v, stage)).collect();
    let mut time_turn =
        || shots.iter().map(|s| times(&stage.run(s, Mode::Timed).expect("a frame").0)).collect::<Vec<_>>();
    time_turn();
    let turns: Vec<_> = (0..TURNS).map(|_| time_turn()).collect();
    let names: Vec<_> = variants.iter().map(|v| v.name).collect();
    print_rows(claim, name, (&scene.name, &view.name), &names, &turns);
}

/// Times variants of methods on each of some views, if the claim is asked for.
fn time_views(bench: &Bench, claim: &str, places: &[(&str, &str)], variants: &[(&str, Vec<Variant>)]) {
    if !bench.wants(claim) {
        return;
    }
    for (name, view) in places {
        let scene = scene(name);
        let mut stage = Stage::new(&bench.gpu, &scene).expect("device memory");
        let view = scene.view(view).expect("a view");
        for (method, variants) in variants {
            take_turns(bench, claim, method, (&scene, view, &mut stage), variants);
        }
    }
}

/// Returns the vertex in the middle of two others.
fn middle_vertex(a: &Vertex, b: &Vertex) -> Vertex {
    let mean_direction =
        |u: [f32; 3], v: [f32; 3]| (Vec3::from(u) + Vec3::from(v)).normalize_or(Vec3::from(u)).to_array();
    let tangent = |v: &Vertex| Vec4::from(v.tangent).truncate().to_array();
    Vertex {
        position: (0.5 * (Vec3::from(a.position) + Vec3::from(b.position))).to_array(),
        normal: mean_direction(a.normal, b.normal),
        uv: (0.5 * (Vec2::from(a.uv) + Vec2::from(b.uv))).to_array(),
        tangent: Vec3::from(mean_direction(tangent(a), tangent(b))).extend(a.tangent[3]).to_array(),
    }
}

/// Cuts every triangle of a mesh into four, at the middles of its edges.
fn cut_into_four(mesh: &Mesh) -> Mesh {
    let mut cut = Mesh { vertices: Vec::new(), indices: Vec::new(), ..mesh.clone() };
    for corners in mesh.indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|corner| mesh.vertices[corners[corner] as usize]);
        let [ab, bc, ca] = [middle_vertex(&a, &b), middle_vertex(&b, &c), middle_vertex(&c, &a)];
        let first_vertex = cut.vertices.len() as u32;
        // The corners have the numbers 0 to 2 here, and the middles of the edges 3 to 5.
        cut.vertices.extend([a, b, c, ab, bc, ca]);
        cut.indices.extend([0, 3, 5, 3, 1, 4, 5, 4, 2, 3, 4, 5].map(|number| first_vertex + number));
    }
    cut
}

/// Times methods in turn on a scene and on a copy of it in which every triangle is cut into 16.
fn time_triangles(bench: &Bench) {
    let coarse = scene("rooms");
    let meshes = coarse.meshes.iter().map(|m| cut_into_four(&cut_into_four(m))).collect();
    let fine = Scene { meshes, ..coarse.clone() };
    let mut stages = [&coarse, &fine].map(|scene| Stage::new(&bench.gpu, scene).expect("device memory"));
    for name in ["sslr", "ssct", "hzct", "planar"] {
        for view in coarse.views.iter().filter(|v| ["corridor", "window-floor"].contains(&v.name.as_str())) {
            let materials = globals(0.1, 0.1).materials(&coarse, view);
            let mut shots = stages.each_mut().map(|stage| {
                let camera = view.camera(&coarse, SIZE);
                let shot = Shot::new(stage, method(name), &Setup::new(SIZE), Wants::IMAGE, camera, materials.clone());
                (shot.expect("a shot"), stage)
            });
            let mut time_turn =
                || shots.each_mut().map(|(s, stage)| times(&stage.run(s, Mode::Timed).expect("a frame").0)).to_vec();
            time_turn();
            let turns: Vec<_> = (0..TURNS).map(|_| time_turn()).collect();
            print_rows("triangles", name, (&coarse.name, &view.name), &["1", "16"], &turns);
        }
    }
}

/// Times screen-space methods in turn on G-buffers in which all, half, a quarter and a tenth of the pixels reflect.
fn time_reflecting(bench: &Bench) {
    let scene = scene("rooms");
    let mut stage = Stage::new(&bench.gpu, &scene).expect("device memory");
    for view in scene.views.iter().filter(|v| ["corridor", "window-floor"].contains(&v.name.as_str())) {
        let materials = globals(0.0, 0.0).materials(&scene, view);
        let camera = view.camera(&scene, SIZE);
        let setup = Setup::new(SIZE);
        let shot = Shot::new(&mut stage, method("ssr"), &setup, Wants::IMAGE, camera, materials).expect("a shot");
        stage.run(&shot, Mode::Plain).expect("a frame");
        let data = gbuffer::read(&mut stage.context, &shot).expect("the G-buffer");
        let images =
            SHARES.map(|share| GBufferImages::upload(&mut stage.context, &masked(&data, share)).expect("an upload"));
        for name in ["ssr", "ssr-fast"] {
            let effect = Effect::new(&mut stage.context, method(name), &setup, Wants::IMAGE, None).expect("the effect");
            let mut time_turn = || {
                let frame_times = |images: &GBufferImages| {
                    let mut frame = stage.context.begin(Mode::Timed).expect("a frame");
                    frame.begin_effect();
                    effect.record(&mut frame, &Input::of_screen(images.gbuffer(), &camera)).expect("the effect");
                    times(&frame.finish().expect("the frame's end"))
                };
                images.iter().map(frame_times).collect::<Vec<_>>()
            };
            time_turn();
            let turns: Vec<_> = (0..TURNS).map(|_| time_turn()).collect();
            print_rows("reflecting", name, (&scene.name, &view.name), &["1", "0.5", "0.25", "0.1"], &turns);
        }
    }
}

/// Times Schmidt's optimised march and the world reference in turn, on the view of his figure 47.
fn time_ray_traced(bench: &Bench) {
    const SMALL: [u32; 2] = [480, 270];
    let scene = scene("street");
    let view = scene.view("car").expect("a view");
    let mut stage = Stage::new(&bench.gpu, &scene).expect("device memory");
    let materials = globals(0.0, 0.1).materials(&scene, view);
    let camera = view.camera(&scene, SMALL);
    let setup = Setup::new(SMALL);
    let shot = Shot::new(&mut stage, method("ssr-fast"), &setup, Wants::IMAGE, camera, materials.clone());
    let shot = shot.expect("a shot");
    let mut time_turn = || {
        let march = times(&stage.run(&shot, Mode::Timed).expect("a frame").0);
        let begun = Instant::now();
        let world = World::new(&scene, &materials);
        let first_hits = FirstHits::trace(&world, &camera, SMALL);
        let reference = WorldReference::new(&world, &first_hits, &camera, 1);
        let mut state = reference.start();
        reference.add(&mut state, 16);
        vec![march, [begun.elapsed().as_secs_f64() * 1e3, march[1]]]
    };
    time_turn();
    let turns: Vec<_> = (0..5).map(|_| time_turn()).collect();
    print_rows("ray-traced", "ssr-fast", (&scene.name, &view.name), &["march", "reference"], &turns);
}

/// Times the claims that are asked for.
pub fn run(bench: &Bench) {
    println!("claim,method,scene,view,variant,ratio,least,greatest,scene_ratio");
    let mirrors = |name, change: Change| changed(name, 0.0, change);
    let pixel_steps = vec![
        mirrors("1", SAME),
        mirrors("5", |s| s.with(|p: &mut SsrParams| p.pixel_step = 5)),
        mirrors("10", |s| s.with(|p: &mut SsrParams| p.pixel_step = 10)),
        mirrors("20", |s| s.with(|p: &mut SsrParams| p.pixel_step = 20)),
    ];
    let schmidt = [("street", "puddles"), ("museum", "museum"), ("cathedral", "nave")];
    time_views(bench, "pixel-step", &schmidt, &[("ssr", pixel_steps)]);

    let views = [("rooms", "corridor"), ("rooms", "window-floor"), ("rooms", "two-cylinders"), ("atrium", "hall")];
    let half_resolution = |roughness| {
        let smaller: Change = |s| s.with(|p: &mut EffectParams| p.resolution_scale = 0.5);
        vec![changed("1", roughness, SAME), changed("0.5", roughness, smaller)]
    };
    time_views(bench, "half", &views, &[("ssct", half_resolution(0.1)), ("sslr", half_resolution(0.1))]);
    let gaussian: Change = |s| s.with(|p: &mut ThesisDrawing| p.chain_filter = ChainFilter::Gaussian);
    let filters = vec![changed("hardware", 0.1, SAME), changed("gaussian", 0.1, gaussian)];
    time_views(bench, "gaussian", &views, &[("ssct", filters)]);
    let split: Change = |s| s.with(|p: &mut ThesisDrawing| p.split = true);
    let passes = |roughness| vec![changed("combined", roughness, SAME), changed("split", roughness, split)];
    time_views(bench, "split", &views, &[("ssct", passes(0.1)), ("hzct", passes(0.1))]);
    let minima = vec![changed("printed", 0.1, SAME), Variant { edits: TRUE_MINIMA, ..changed("true", 0.1, SAME) }];
    time_views(bench, "true-minima", &views, &[("ssct", minima)]);
    let angles = vec![changed("half", 0.1, SAME), Variant { edits: ARC_COSINE, ..changed("detour", 0.1, SAME) }];
    time_views(bench, "angle", &views, &[("ssct", angles)]);
    let rougher = |name, roughness| Variant { globals: globals(roughness, 0.1), ..changed(name, 0.1, SAME) };
    let roughness = || vec![rougher("0.1", 0.1), rougher("0.3", 0.3), rougher("0.6", 0.6), rougher("1", 1.0)];
    time_views(bench, "roughness", &views, &[("ssct", roughness()), ("hzct", roughness()), ("sslr", roughness())]);
    if bench.wants("triangles") {
        time_triangles(bench);
    }
    if bench.wants("reflecting") {
        time_reflecting(bench);
    }
    if bench.wants("ray-traced") {
        time_ray_traced(bench);
    }
}
