//! Measures how much longer rays take because they wait for their neighbours, and because they read memory far from
//! where their neighbours read. Times are those of the tracing pass. Variants, which differ only in the order of the
//! rays, are timed frame by frame in turn.
//!
//! Columns: claim, method, scene, view, roughness, variant, and then three ratios of the pass's time over the first
//! variant's time in the same turn: `ratio` is the median, and `least` and `greatest` are the ends of the middle half.
//!
//! - `order`: each pixel follows the ray of another pixel. `pixels`: each follows its own ray. `kinds`: within a tile
//!   of 64×64 pixels, rays towards the camera come first. `steps`: within a tile, rays are sorted by direction, and
//!   then by their number of steps, so that rays that run in step are about equally long. `mixed`: within a tile, rays
//!   are shuffled. `mixed-kinds`: they are shuffled, and then rays towards the camera come first. `scattered`: the
//!   groups of eight rays are shuffled over the whole image.
//! - `alone`: only one ray in each group of eight is traced, in turn each of the eight; the mean of these times over
//!   the time of the whole image. The ratio is 1 if groups lose nothing by waiting, and an eighth if one long ray
//!   of each group takes all the time.
//! - `in-step`: the mean number of steps of a ray over the number of steps for which its group of 8 or 32 rays runs. It
//!   is counted and not timed. A group runs for its longest ray of each direction, since rays of different directions
//!   take different branches one after the other.
//! - `normals`: rays are reflected at the normals of shading, with all of their bumps, at those of the geometry, or at
//!   the world's up. `steps-…` is the ratio of the mean numbers of steps.

use super::counts::{COUNTER, HIT_OF_SSLR, MARCHED, MISS_OF_SSLR};
use super::edited::Edits;
use super::times::spread;
use super::{Bench, SAME, globals, method, scene};
use ssct::gpu::FrameReport;
use ssct::gpu::frame::Mode;
use ssct::methods::setup::EffectParams;
use ssct::methods::ssct::ThesisDrawing;
use ssct::methods::{Effect, Input, Setup, Wants};
use ssct::passes::PathCode;
use ssct::passes::gbuffer::GBufferImages;
use ssct::passes::trace_normals::TraceNormals;
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer, image};
use ssct_scenes::{Camera, GBufferData, Material, Scene, View};

/// Width and height of the frames in pixels.
const SIZE: [u32; 2] = [960, 540];
/// Number of turns that count. One more turn before them does not.
const TURNS: usize = 7;
/// Width and height in pixels of the group that runs in step on lavapipe.
const GROUP: [u32; 2] = [4, 2];
/// Side in pixels of the tile that a thread of lavapipe fills.
const TILE: u32 = 64;
/// Methods with a roughness, which only the steps of `sslr` depend on.
const METHODS: [(&str, f32); 4] = [("ssct", 0.0), ("hzct", 0.0), ("sslr", 0.0), ("sslr", 0.1)];
const PLACES: [(&str, &str); 4] =
    [("rooms", "two-cylinders"), ("rooms", "window-floor"), ("rooms", "corridor"), ("atrium", "hall")];
const ORDERS: [&str; 6] = ["pixels", "kinds", "steps", "mixed", "mixed-kinds", "scattered"];
const PIXEL: &str = "thesis/pixel.glsl";
const READ: &str = "vec2 material = texelFetch(materialBuffer, coord, 0).rg;";
const OF_MATERIAL: &str = "pixel.roughness = material.g;";

/// Makes a pixel follow the ray of another pixel, whose place stands in its material: the column as roughness, and the
/// row plus 1 as reflectivity. `MIRRORS` and `ROUGH` also make the roughness a constant.
const READ_OTHER_PIXEL: &str = "vec2 material = texelFetch(materialBuffer, coord, 0).rg;\n    coord = max(ivec2(material.g, \
                         material.r - 1.0), 0);\n    fragCoord = vec2(coord) + 0.5;";
const MIRRORS: Edits = &[(PIXEL, READ, READ_OTHER_PIXEL), (PIXEL, OF_MATERIAL, "pixel.roughness = 0.0;")];
const ROUGH: Edits = &[(PIXEL, READ, READ_OTHER_PIXEL), (PIXEL, OF_MATERIAL, "pixel.roughness = 0.1;")];

/// Makes shaders write a ray's number of steps, in the traversal, the marches and the search together, in place of
/// where the ray ended.
const COUNTING: Edits = &[
    COUNTER,
    MARCHED,
    (
        "thesis/linear_ray_march.glsl",
        "        // 37-40: Check if",
        "        counted += 1.0;\n        // 37-40: Check if",
    ),
    (
        "thesis/linear_ray_march.glsl",
        "        // 15-19: Check if",
        "        counted += 1.0;\n        // 15-19: Check if",
    ),
    (
        "thesis/hi_z_ray_trace.glsl",
        "        cellCount = GetCellCount(thesis.resolution, level);\n        cellIndex = GetCell(ray.xy, cellCount);\n\n        // 4",
        "        counted += 1.0;\n        cellCount = GetCellCount(thesis.resolution, level);\n        cellIndex = GetCell(ray.xy, cellCount);\n\n        // 4",
    ),
    ("thesis/ssct.frag", "out_hit = vec4(trace.hit, trace.path);", "out_hit = vec4(counted, 0.0, 0.0, trace.path);"),
    MISS_OF_SSLR,
    HIT_OF_SSLR,
];

/// Returns the setup with a change: rays are traced in a pass of its own.
fn with_tracing_pass(setup: &Setup) -> Setup {
    setup.with(|p: &mut ThesisDrawing| p.split = true)
}

/// Returns the milliseconds of the pass that traces.
fn traced_ms(report: &FrameReport) -> f64 {
    report.passes.iter().filter(|p| p.name == "ray trace").map(|p| p.ms).sum()
}

/// The work of a pixel's ray: whether it runs towards the camera, and its number of steps; `None` if the pixel has no
/// ray.
type Work = Option<(bool, u32)>;

/// Counts the work of every pixel's ray, with a setup and the scene's materials.
fn count_work(bench: &Bench, stage: &mut Stage, subject: &Subject, setup: &Setup, materials: &[Material]) -> Vec<Work> {
    let hits = bench.shaders.run_with(&bench.gpu, COUNTING, || {
        let (info, camera) = (method(subject.method), subject.camera());
        let shot = Shot::new(stage, info, setup, Wants::HITS, camera, materials.to_vec()).expect("a shot");
        let rendered = image::render(stage, &shot, true).expect("an image");
        rendered.intermediates.expect("intermediates").into_iter().find(|(name, ..)| name == "hits").expect("hits").2
    });
    let ray_work = |texel: &[f32]| {
        let code = PathCode::from_channel(texel[3]).filter(|code| *code != PathCode::None)?;
        let steps = if code == PathCode::Untraced { 0 } else { texel[0] as u32 };
        Some((matches!(code, PathCode::Linear | PathCode::LinearMiss | PathCode::Untraced), steps))
    };
    hits.texels().map(ray_work).collect()
}

/// Returns the indices of all pixels: a list for each tile, in which the pixels of a group follow each other.
fn pixels_in_groups() -> Vec<Vec<usize>> {
    let [width, height] = SIZE;
    // Divides a box into boxes of w × h pixels, row by row; the last ones may be smaller.
    let boxes = |[left, top, right, bottom]: [u32; 4], [w, h]: [u32; 2]| {
        let rows = (top..bottom).step_by(h as usize);
        let boxes_in_row = move |y: u32| {
            let (end, columns) = ((y + h).min(bottom), (left..right).step_by(w as usize));
            columns.map(move |x| [x, y, (x + w).min(right), end]).collect::<Vec<_>>()
        };
        rows.flat_map(boxes_in_row).collect::<Vec<_>>()
    };
    let pixels_of_tile = |tile: [u32; 4]| {
        let groups = boxes(tile, GROUP).into_iter().flat_map(|group| boxes(group, [1, 1]));
        groups.map(|[x, y, ..]| (y * width + x) as usize).collect()
    };
    boxes([0, 0, width, height], [TILE; 2]).into_iter().map(pixels_of_tile).collect()
}

/// A random generator, whose field is its state. Its seed is fixed, so that orders are equal in every run.
struct Shuffle(u64);

impl Shuffle {
    /// Returns a number below `end`, by a linear congruential generator.
    fn random_below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % end as u64) as usize
    }

    /// Shuffles items (Fisher and Yates).
    fn shuffle_items<T>(&mut self, items: &mut [T]) {
        for end in (1..items.len()).rev() {
            items.swap(end, self.random_below(end + 1));
        }
    }
}

/// Returns, for each pixel, the index of the pixel whose ray it follows in the order `name` of [`ORDERS`].
fn rays_in_order(name: &str, work: &[Work]) -> Vec<usize> {
    let tiles = pixels_in_groups();
    let mut shuffle = Shuffle(1);
    let mut rays = tiles.clone();
    for tile in &mut rays {
        if name.starts_with("mixed") {
            shuffle.shuffle_items(tile);
        }
        match name {
            "kinds" | "mixed-kinds" => tile.sort_by_key(|&i| work[i].map(|(towards_camera, _)| !towards_camera)),
            "steps" => tile.sort_by_key(|&i| work[i].map(|(towards_camera, steps)| (!towards_camera, steps))),
            _ => (),
        }
    }
    let mut rays = rays.concat();
    if name == "scattered" {
        let mut groups: Vec<_> = rays.chunks((GROUP[0] * GROUP[1]) as usize).map(<[usize]>::to_vec).collect();
        shuffle.shuffle_items(&mut groups);
        rays = groups.concat();
    }
    let mut ray_of_pixel = vec![0; work.len()];
    for (pixel, ray) in tiles.into_iter().flatten().zip(rays) {
        ray_of_pixel[pixel] = ray;
    }
    ray_of_pixel
}

/// Returns a G-buffer whose material says which pixel's ray each pixel follows, if any, as [`READ_OTHER_PIXEL`] reads it.
fn follow_rays(data: &GBufferData, ray_of_pixel: impl Iterator<Item = Option<usize>>) -> GBufferData {
    let mut changed = data.clone();
    let materials = changed.reflectivity.iter_mut().zip(&mut changed.roughness);
    for ((reflectivity, roughness), ray) in materials.zip(ray_of_pixel) {
        let column_and_row = ray.map(|ray| [ray as u32 % data.width, ray as u32 / data.width + 1]);
        [*roughness, *reflectivity] = column_and_row.unwrap_or([0; 2]).map(|number| number as f32);
    }
    changed
}

/// A method at a roughness on a view, on which something is measured.
struct Subject<'a> {
    scene: &'a Scene,
    view: &'a View,
    roughness: f32,
    method: &'a str,
}

impl Subject<'_> {
    /// Prints a row of the table.
    fn print_row(&self, claim: &str, variant: &str, values: [f64; 3]) {
        let [ratio, least, greatest] = values;
        let Self { scene, view, roughness, method } = self;
        println!(
            "{claim},{method},{},{},{roughness},{variant},{ratio:.3},{least:.3},{greatest:.3}",
            scene.name, view.name
        );
    }

    /// The camera of the view.
    fn camera(&self) -> Camera {
        self.view.camera(self.scene, SIZE)
    }
}

/// Times the tracing pass on several G-buffers in turn. Returns for each turn the milliseconds on each G-buffer.
fn time_turns(bench: &Bench, stage: &mut Stage, subject: &Subject, gbuffers: &[GBufferData]) -> Vec<Vec<f64>> {
    let edits = if subject.roughness == 0.0 { MIRRORS } else { ROUGH };
    let setup = with_tracing_pass(&Setup::new(SIZE));
    let images: Vec<_> =
        gbuffers.iter().map(|data| GBufferImages::upload(&mut stage.context, data).expect("an upload")).collect();
    bench.shaders.run_with(&bench.gpu, edits, || {
        let info = method(subject.method);
        let effect = Effect::new(&mut stage.context, info, &setup, Wants::IMAGE, None).expect("the effect");
        let mut turn = || {
            let tracing_ms = |images: &GBufferImages| {
                let mut frame = stage.context.begin(Mode::Timed).expect("a frame");
                frame.begin_effect();
                effect.record(&mut frame, &Input::of_screen(images.gbuffer(), &subject.camera())).expect("the effect");
                traced_ms(&frame.finish().expect("the frame's end"))
            };
            images.iter().map(tracing_ms).collect::<Vec<_>>()
        };
        turn();
        (0..TURNS).map(|_| turn()).collect()
    })
}

/// Returns the mean number of steps of a ray over the number of steps for which its group of `width` × `height` pixels
/// runs.
fn share_in_step(work: &[Work], [width, height]: [usize; 2]) -> f64 {
    let [columns, rows] = SIZE.map(|side| side as usize);
    // The steps of all rays, and the steps for which their groups run, counted for each pixel of a group.
    let (mut ray_steps, mut group_steps) = (0.0, 0.0);
    for (top, left) in (0..rows / height).flat_map(|y| (0..columns / width).map(move |x| (y * height, x * width))) {
        let rays = (0..width * height).filter_map(|i| work[(top + i / width) * columns + left + i % width]);
        // The steps of the longest ray away from the camera, and of the longest one towards it.
        let mut longest = [0; 2];
        for (towards_camera, steps) in rays {
            ray_steps += f64::from(steps);
            longest[usize::from(towards_camera)] = steps.max(longest[usize::from(towards_camera)]);
        }
        group_steps += f64::from(longest[0] + longest[1]) * (width * height) as f64;
    }
    ray_steps / group_steps
}

/// Counts and times rays in other orders, and one in eight rays alone.
fn measure_orders(bench: &Bench, stage: &mut Stage, subject: &Subject) {
    let (setup, materials) = (Setup::new(SIZE), globals(subject.roughness, 0.1).materials(subject.scene, subject.view));
    let work = count_work(bench, stage, subject, &setup, &materials);
    let shot =
        Shot::new(stage, method(subject.method), &setup, Wants::IMAGE, subject.camera(), materials).expect("a shot");
    stage.run(&shot, Mode::Plain).expect("a frame");
    let data = gbuffer::read(&mut stage.context, &shot).expect("the G-buffer");
    let if_it_has_a_ray = |i: usize| work[i].map(|_| i);
    if bench.wants("in-step") {
        for (variant, group) in [("8", [4, 2]), ("32", [8, 4])] {
            subject.print_row("in-step", variant, [share_in_step(&work, group); 3]);
        }
    }
    if bench.wants("order") {
        let gbuffers =
            ORDERS.map(|name| follow_rays(&data, rays_in_order(name, &work).into_iter().map(if_it_has_a_ray)));
        let turns = time_turns(bench, stage, subject, &gbuffers);
        for (index, name) in ORDERS.into_iter().enumerate() {
            subject.print_row("order", name, spread(turns.iter().map(|times| times[index] / times[0])));
        }
    }
    if bench.wants("alone") {
        let place_in_group = |i: usize| [i % SIZE[0] as usize % 4, i / SIZE[0] as usize % 2];
        // Keeps only the rays of one pixel of each group, whose number in the group is `lane`, 0 to 7.
        let rays_of_lane = |lane: usize| {
            let is_in_lane = move |i: usize| place_in_group(i) == [lane % 4, lane / 4];
            follow_rays(&data, (0..work.len()).map(|i| if_it_has_a_ray(i).filter(|i| is_in_lane(*i))))
        };
        let all_rays = follow_rays(&data, (0..work.len()).map(if_it_has_a_ray));
        let gbuffers: Vec<_> = [all_rays].into_iter().chain((0..8).map(rays_of_lane)).collect();
        let turns = time_turns(bench, stage, subject, &gbuffers);
        subject.print_row("alone", "1/8", spread(turns.iter().map(|ms| super::mean(ms[1..].iter().copied()) / ms[0])));
    }
}

/// Compares rays that are reflected at three kinds of normals: their numbers of steps, and the times of tracing them.
fn measure_normals(bench: &Bench, stage: &mut Stage, subject: &Subject) {
    let changes: [(&str, super::Change); 3] = [
        ("shading", SAME),
        ("geometric", |s| s.with(|p: &mut EffectParams| p.trace_normals = TraceNormals::Geometric)),
        ("up", |s| s.with(|p: &mut EffectParams| p.trace_normals = TraceNormals::Up)),
    ];
    // Materials keep their own normal deviations, so that the normals of shading have all bumps.
    let with_all_bumps = Globals { roughness: Some(subject.roughness), ..Globals::default() };
    let materials = with_all_bumps.materials(subject.scene, subject.view);
    let steps = changes.map(|(_, change)| {
        let work = count_work(bench, stage, subject, &change(&Setup::new(SIZE)), &materials);
        super::mean(work.into_iter().flatten().map(|(_, steps)| f64::from(steps)))
    });
    let shots = changes.map(|(_, change)| {
        let (info, setup) = (method(subject.method), change(&with_tracing_pass(&Setup::new(SIZE))));
        Shot::new(stage, info, &setup, Wants::IMAGE, subject.camera(), materials.clone()).expect("a shot")
    });
    let mut turn = || shots.each_ref().map(|shot| traced_ms(&stage.run(shot, Mode::Timed).expect("a frame").0));
    turn();
    let turns: Vec<_> = (0..TURNS).map(|_| turn()).collect();
    for (index, (name, _)) in changes.into_iter().enumerate() {
        subject.print_row("normals", name, spread(turns.iter().map(|times| times[index] / times[0])));
        subject.print_row(&format!("steps-{name}"), name, [steps[index] / steps[0]; 3]);
    }
}

/// Measures the claims that are asked for.
pub fn run(bench: &Bench) {
    println!("claim,method,scene,view,roughness,variant,ratio,least,greatest");
    for (name, view) in PLACES {
        let scene = scene(name);
        let mut stage = Stage::new(&bench.gpu, &scene).expect("device memory");
        let view = scene.view(view).expect("a view");
        for (method, roughness) in METHODS {
            let subject = Subject { scene: &scene, view, roughness, method };
            if ["order", "alone", "in-step"].iter().any(|claim| bench.wants(claim)) {
                measure_orders(bench, &mut stage, &subject);
            }
            if bench.wants("normals") {
                measure_normals(bench, &mut stage, &subject);
            }
        }
    }
}
