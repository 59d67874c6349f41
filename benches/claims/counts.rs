//! Counts the work of rays and cones, with changed shaders that count it. Columns: claim, method, scene, view, size
//! (the height), variant, value.
//!
//! - `cone-samples`: samples of a cone that hit something, by roughness, at most 7 as published; `cone-levels`: the mean
//!   level that they read; `cone-samples-unbounded`, `cone-levels-unbounded`: at most 64.
//! - `ray-steps`: depths that a ray of a march reads, by pixels a step, by roughness, or by the height of the image.
//! - `towards-camera`: the share of the rays that run towards the camera; `towards-camera-hits`: the share of these that hit;
//!   `away-hits`: the share of the others that hit; `search-off-screen`: the share of the hits towards the camera whose
//!   binary search ended off the screen.
//! - `device-mb`: megabytes on the device that the passes of the effect take, in one pass or split in two.

use super::edited::{Edit, Edits};
use super::{Bench, Change, SAME, THESIS, globals, mean, method, scene};
use ssct::gpu::Pixels;
use ssct::methods::ssct::ThesisDrawing;
use ssct::methods::ssr::SsrParams;
use ssct::methods::thesis::ConeParams;
use ssct::methods::{Effect, Setup, Wants};
use ssct::passes::PathCode;
use ssct_lab::stage::{Globals, Shot, Stage, image};
use ssct_scenes::{Scene, View};

/// The size of the thesis's figures.
const SIZE: [u32; 2] = [960, 540];
/// The greatest number of a cone's samples where 7 are not enough.
const UNBOUNDED: u32 = 64;

/// Makes a shader write counts in place of the reflection's colour: the number of the cone's samples, the sum of their
/// levels, and 1.
const CONE_COUNTS: Edits = &[
    ("thesis/cone_trace.glsl", "vec4 C = vec4(0.0);", "vec4 C = vec4(0.0);\n    float counted = 0.0, levels = 0.0;"),
    (
        "thesis/cone_trace.glsl",
        "C += ConeSampleWeightedColor(P_sample, max(l_mip, 0.0));",
        "C += ConeSampleWeightedColor(P_sample, max(l_mip, 0.0)); counted += 1.0; levels += max(l_mip, 0.0);",
    ),
    ("thesis/cone_trace.glsl", "return C.rgb / C.a;", "return vec3(counted, levels, 1.0);"),
];

const SCHMIDT: &str = "schmidt/screen_space_reflections.frag";

/// Makes a shader write counts in place of the reflection's colour: the number of depths that the ray has read, 0, and
/// 1.
const MARCH_COUNTS: Edits = &[
    (
        SCHMIDT,
        "bool behind = false;\n\n// Reads the linearised",
        "bool behind = false;\nfloat counted = 0.0;\n\n// Reads the linearised",
    ),
    (
        SCHMIDT,
        "    float sampledDepth = linearizeDepth(1.0 - textureLod(DepthTex",
        "    counted += 1.0;\n    float sampledDepth = linearizeDepth(1.0 - textureLod(DepthTex",
    ),
    (
        SCHMIDT,
        "        out_reflection = ScreenSpaceReflections(vsPosition, vsNormal, vsReflectionVector);",
        "        ScreenSpaceReflections(vsPosition, vsNormal, vsReflectionVector);\n        out_reflection = vec4(counted, 0.0, 1.0, 1.0);",
    ),
];

/// Declares a counter beside the linear march.
pub const COUNTER: Edit = (
    "thesis/linear_ray_march.glsl",
    "#define INVALID_RAY vec3(-1.0)",
    "#define INVALID_RAY vec3(-1.0)\nfloat counted = 0.0;",
);
/// Counts each step of the march.
pub const MARCHED: Edit = (
    "thesis/linear_ray_march.glsl",
    "        // 9-11: Check if ray steps",
    "        counted += 1.0;\n        // 9-11: Check if ray steps",
);
/// Makes `sslr` write the counter in place of where a ray missed.
pub const MISS_OF_SSLR: Edit = (
    "thesis/sslr_ray_trace.frag",
    "out_hit = vec4(hit, PATH_LINEAR_MISS);",
    "out_hit = vec4(counted, 0.0, 0.0, PATH_LINEAR_MISS);",
);
/// Makes `sslr` write the counter in place of where a ray hit.
pub const HIT_OF_SSLR: Edit = (
    "thesis/sslr_ray_trace.frag",
    "out_hit = vec4(hit, PATH_LINEAR);",
    "out_hit = vec4(counted, 0.0, 0.0, PATH_LINEAR);",
);

/// Makes `sslr` write the number of depths that a ray has read, in place of where it ended, whether it hit or not.
const SSLR_COUNTS: Edits = &[COUNTER, MARCHED, MISS_OF_SSLR, HIT_OF_SSLR];

/// An image to draw with shaders that count.
struct CountShot<'a> {
    method: &'a str,
    edits: Edits,
    change: Change,
    size: [u32; 2],
    globals: Globals,
}

impl CountShot<'_> {
    /// Draws a view with the edited shaders; returns the images of the reflection and of the hits.
    fn draw(&self, bench: &Bench, stage: &mut Stage, (scene, view): (&Scene, &View)) -> (Pixels, Pixels) {
        let setup = (self.change)(&Setup::new(self.size));
        let materials = self.globals.materials(scene, view);
        let camera = view.camera(scene, self.size);
        bench.shaders.run_with(&bench.gpu, self.edits, || {
            let shot = Shot::new(stage, method(self.method), &setup, Wants::HITS, camera, materials).expect("a shot");
            let rendered = image::render(stage, &shot, true).expect("an image");
            let intermediates = rendered.intermediates.expect("intermediates");
            let hits = intermediates.into_iter().find(|(name, ..)| name == "hits").expect("hits").2;
            (rendered.reflection, hits)
        })
    }
}

/// Returns the mean of a channel over the texels with counts, whose third channel is 1.
fn mean_count(image: &Pixels, channel: usize) -> f64 {
    mean(image.texels().filter(|texel| texel[2] == 1.0).map(|texel| f64::from(texel[channel])))
}

/// Prints a row of the table.
fn print_row(claim: &str, method: &str, (scene, view): (&Scene, &View), height: u32, variant: &str, value: f64) {
    println!("{claim},{method},{},{},{height},{variant},{value:.4}", scene.name, view.name);
}

/// Prints how many samples cones take and which levels they read, by roughness.
fn print_cones(bench: &Bench, stage: &mut Stage, subject: (&Scene, &View)) {
    let limits: [(&str, Change); 2] =
        [("", SAME), ("-unbounded", |s| s.with(|p: &mut ConeParams| p.cone_samples = UNBOUNDED))];
    for roughness in [0.05, 0.1, 0.3, 0.6, 1.0] {
        for (suffix, change) in limits {
            let counting =
                CountShot { method: "ssct", edits: CONE_COUNTS, change, size: SIZE, globals: globals(roughness, 0.1) };
            let (counts, _) = counting.draw(bench, stage, subject);
            let (samples, levels) = (mean_count(&counts, 0), mean_count(&counts, 1));
            let variant = roughness.to_string();
            print_row(&format!("cone-samples{suffix}"), "ssct", subject, SIZE[1], &variant, samples);
            print_row(&format!("cone-levels{suffix}"), "ssct", subject, SIZE[1], &variant, levels / samples);
        }
    }
}

/// Prints the share of the rays that run towards the camera, and the shares of hits among these and among the others.
/// The path code of a pixel tells the direction of its ray: rays towards the camera are the ones that march linearly.
fn print_directions(bench: &Bench, stage: &mut Stage, subject: (&Scene, &View)) {
    let counting = CountShot { method: "ssct", edits: &[], change: SAME, size: SIZE, globals: globals(0.0, 0.1) };
    let (_, hits) = counting.draw(bench, stage, subject);
    let codes: Vec<_> = hits.texels().filter_map(|texel| PathCode::from_channel(texel[3])).collect();
    let count = |wanted: &[PathCode]| codes.iter().filter(|code| wanted.contains(code)).count() as f64;
    let towards = count(&[PathCode::Linear, PathCode::LinearMiss]);
    let away = count(&[PathCode::HiZ, PathCode::Miss, PathCode::Exhausted]);
    let share = |part: f64, whole: f64| part / whole.max(1.0);
    print_row("towards-camera", "ssct", subject, SIZE[1], "0", share(towards, towards + away));
    print_row("towards-camera-hits", "ssct", subject, SIZE[1], "0", share(count(&[PathCode::Linear]), towards));
    let linear_hits = hits.texels().filter(|texel| PathCode::from_channel(texel[3]) == Some(PathCode::Linear));
    let off_screen = linear_hits.filter(|hit| hit[..2].iter().any(|uv| !(0.0..=1.0).contains(uv))).count() as f64;
    print_row("search-off-screen", "ssct", subject, SIZE[1], "0", share(off_screen, count(&[PathCode::Linear])));
    print_row("away-hits", "ssct", subject, SIZE[1], "0", share(count(&[PathCode::HiZ, PathCode::Exhausted]), away));
}

/// Prints the megabytes of the effect's images and buffers, with its passes combined and split.
fn print_memory(stage: &mut Stage, subject: (&Scene, &View)) {
    let mut megabytes = |split: bool| {
        let setup = Setup::new(SIZE).with(|p: &mut ThesisDrawing| p.split = split);
        let before = stage.context.gpu().allocated_bytes();
        let effect = Effect::new(&mut stage.context, method("ssct"), &setup, Wants::IMAGE, None).expect("the effect");
        let bytes = stage.context.gpu().allocated_bytes() - before;
        drop(effect);
        bytes as f64 / 1e6
    };
    let [combined, split] = [false, true].map(&mut megabytes);
    print_row("device-mb", "ssct", subject, SIZE[1], "combined", combined);
    print_row("device-mb", "ssct", subject, SIZE[1], "split", split);
}

/// Prints the mean steps of the rays of `sslr`, by roughness.
fn print_uniform_steps(bench: &Bench, stage: &mut Stage, subject: (&Scene, &View)) {
    for roughness in [0.0, 0.1, 0.3, 0.6] {
        let counting = CountShot {
            method: "sslr",
            edits: SSLR_COUNTS,
            change: SAME,
            size: SIZE,
            globals: globals(roughness, 0.1),
        };
        let (_, hits) = counting.draw(bench, stage, subject);
        // The edited shaders write the number of steps in place of the hit, and a path code beside it.
        let has_ray = |texel: &&[f32]| PathCode::from_channel(texel[3]).is_some_and(|code| code != PathCode::None);
        let steps = mean(hits.texels().filter(has_ray).map(|texel| f64::from(texel[0])));
        print_row("ray-steps", "sslr", subject, SIZE[1], &roughness.to_string(), steps);
    }
}

/// Prints the mean steps of Schmidt's marches, by pixels a step and by the height of the image.
fn print_marches(bench: &Bench, stage: &mut Stage, subject: (&Scene, &View)) {
    let pixel_steps: [(&str, Change); 4] = [
        ("1", SAME),
        ("5", |s| s.with(|p: &mut SsrParams| p.pixel_step = 5)),
        ("10", |s| s.with(|p: &mut SsrParams| p.pixel_step = 10)),
        ("20", |s| s.with(|p: &mut SsrParams| p.pixel_step = 20)),
    ];
    let mut print_mean_steps = |method, variant, change, height: u32| {
        let size = [height * 16 / 9, height];
        let counting = CountShot { method, edits: MARCH_COUNTS, change, size, globals: globals(0.0, 0.0) };
        let (image, _) = counting.draw(bench, stage, subject);
        print_row("ray-steps", method, subject, height, variant, mean_count(&image, 0));
    };
    pixel_steps.into_iter().for_each(|(variant, change)| print_mean_steps("ssr", variant, change, 180));
    for height in [360, 720] {
        print_mean_steps("ssr", "1", SAME, height);
    }
    for height in [180, 360, 720] {
        print_mean_steps("ssr-fast", "1", SAME, height);
    }
}

/// Prints every count that is asked for.
pub fn run(bench: &Bench) {
    println!("claim,method,scene,view,size,variant,value");
    for (name, views) in THESIS {
        let scene = scene(name);
        let mut stage = Stage::new(&bench.gpu, &scene).expect("device memory");
        for view in scene.views.iter().filter(|v| views.contains(&v.name.as_str())) {
            let subject = (&scene, view);
            if bench.wants("cone-samples") {
                print_cones(bench, &mut stage, subject);
            }
            if bench.wants("towards-camera") {
                print_directions(bench, &mut stage, subject);
            }
            if bench.wants("ray-steps") {
                print_uniform_steps(bench, &mut stage, subject);
            }
            if bench.wants("device-mb") {
                print_memory(&mut stage, subject);
            }
        }
    }
    if !bench.wants("ray-steps") {
        return;
    }
    for (name, view) in [("street", "puddles"), ("museum", "museum"), ("cathedral", "nave")] {
        let scene = scene(name);
        let mut stage = Stage::new(&bench.gpu, &scene).expect("device memory");
        let view = scene.view(view).expect("a view");
        print_marches(bench, &mut stage, (&scene, view));
    }
}
