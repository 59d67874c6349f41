//! Measures how often rays on the screen end elsewhere than in the world, and how much of that no rule for rays on the
//! screen could avoid. Prints a table to standard output.
//!
//! Mirror rays of every view of a scene, at 960×540 and 641×479, are compared with where they end among the scene's
//! triangles (docs/definitions.md, "World agreement"). There is a row for each version of the oracle; `unified` ends
//! rays where the oracle does. `wrong` is the share of the reflecting pixels whose ray is wrong, and the next columns
//! divide it by kind:
//!
//! - `false_front` and `false_side`: a hit where the world has none, by crossing a block's front, or by its side;
//! - `displaced`: a hit at another place;
//! - `missed`: a miss, although the screen shows where the ray ends in the world.
//!
//! `least` is the share that remains wrong whichever of the blocks on its path a ray hits: the screen shows where the
//! ray ends, but no block there meets it. `ssct` is the share that the thesis's method gets wrong.
//!
//! Usage: `cargo bench --bench truth [-- SCENE…]`, with names of built-in scenes or files, relative ones from `lab/`.

#![allow(clippy::expect_used)]

use rayon::prelude::*;
use ssct::gpu::{DeviceQuery, Gpu};
use ssct::methods::{Setup, Wants, ssct as thesis};
use ssct_ground::math::OracleVersion;
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{Scene, View, library};
use ssct_truth::metrics::world::{agreement, is_same_place};
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::oracle::{Meeting, Oracle};
use ssct_truth::reference::ray::RaySetup;
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world_hits::world_hits;

/// Sizes of the pictures in pixels.
const SIZES: [[u32; 2]; 2] = [[960, 540], [641, 479]];

/// The place of a hit in pixels; `None` for a miss.
type HitPlace = Option<[f64; 2]>;

/// Traces the mirror rays of a view by the thesis's method and by the oracle, and compares where they end with where
/// they end in the world. Prints a row for each version of the oracle.
fn print_view(scene: &Scene, view: &View, size: [u32; 2], stage: &mut Stage) {
    let materials = Globals { roughness: Some(0.0), ..Globals::default() }.materials(scene, view);
    let setup = Setup::on_screen(size);
    let shot = Shot::new(stage, &thesis::INFO, &setup, Wants::HITS, view.camera(scene, size), materials.clone())
        .expect("a shot");
    let (_, _, output) = stage.output(&shot).expect("a frame");
    let thesis_hits = output.traced.hits.expect("hits of a trace that is a pass of its own");
    let thesis_hits = gbuffer::hit_positions(&stage.context.read(thesis_hits.0.all()).expect("the hits"));
    let data = gbuffer::read(&mut stage.context, &shot).expect("the G-buffer");

    // The places on the screen where the rays end in the world, if the screen shows them.
    let world = World::new(scene, &materials);
    let true_ends: Vec<HitPlace> = world_hits(&world, &data, &FirstHits::shown(&world, &data))
        .iter()
        .map(|hit| hit.visible_at().map(|p| p.to_array()))
        .collect();
    let (rays, oracle) = (RaySetup::new(&data), Oracle::new(&data));
    let reflects = data.reflecting();
    let pixels =
        (0..data.depth.len()).into_par_iter().map(|index| (index as u32 % data.width, index as u32 / data.width));
    let direction = |x, y| rays.mirror(x, y).filter(|_| reflects[data.index(x, y)]);
    let segment = |x, y| direction(x, y).and_then(|direction| rays.segment(x, y, direction));
    let blocks_met = |(x, y)| segment(x, y).map_or(vec![], |segment| oracle.meetings(&segment));
    let meetings: Vec<Vec<Meeting>> = pixels.clone().map(blocks_met).collect();
    let place_of = |meeting: &Meeting| [meeting.position.x, meeting.position.y];
    // The number of reflecting pixels for which a condition holds.
    let count =
        |holds: &dyn Fn(usize) -> bool| (0..reflects.len()).filter(|i| reflects[*i] && holds(*i)).count() as u64;
    let reflecting = count(&|_| true) as f64;
    let share = |number: u64| number as f64 / reflecting;
    let wrong =
        |hits: &[HitPlace]| 1.0 - agreement(&reflects, &true_ends, hits).fraction().expect("pixels that reflect");
    let meets = |i: usize, end| meetings[i].iter().any(|m| is_same_place(place_of(m), end));
    let unavoidable = count(&|i| true_ends[i].is_some_and(|end| !meets(i, end)));
    for version in [OracleVersion::V1, OracleVersion::V2] {
        let oracle = oracle.clone().of_version(version);
        let oracle_hit = |(x, y)| segment(x, y).and_then(|segment| oracle.trace_segment(&segment).position_px());
        let oracle_hits: Vec<HitPlace> = pixels.clone().map(oracle_hit).collect();
        let counts = agreement(&reflects, &true_ends, &oracle_hits);
        let crosses = |i: usize, hit| meetings[i].iter().any(|m| m.crosses_front && place_of(m) == hit);
        let false_front = count(&|i| true_ends[i].is_none() && oracle_hits[i].is_some_and(|hit| crosses(i, hit)));
        let columns = [
            wrong(&thesis_hits),
            wrong(&oracle_hits),
            share(false_front),
            share(counts.false_hits - false_front),
            share(counts.displaced),
            share(counts.missed),
            share(unavoidable),
        ];
        println!(
            "{},{},{}x{},{},{}",
            scene.name,
            view.name,
            size[0],
            size[1],
            u32::from(version),
            columns.map(|v| format!("{v:.4}")).join(",")
        );
    }
}

/// Prints the rows of the scenes that the command line names, or of the rooms and the atrium.
fn main() {
    let mut names: Vec<_> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    if names.is_empty() {
        names = ["rooms", "atrium"].map(str::to_owned).to_vec();
    }
    let gpu = Gpu::open(&DeviceQuery::default()).expect("a Vulkan device");
    println!("# {} ({}), ssct {}", gpu.info().name, gpu.info().driver, env!("CARGO_PKG_VERSION"));
    println!("scene,view,size,oracle,ssct,wrong,false_front,false_side,displaced,missed,least");
    for name in names {
        let scene = library::scene_or_file(&name).expect("a built-in scene or a file of one");
        let mut stage = Stage::new(&gpu, &scene).expect("device memory");
        for (view, size) in scene.views.iter().flat_map(|view| SIZES.map(|size| (view, size))) {
            print_view(&scene, view, size, &mut stage);
        }
    }
}
