//! Where screen space is wrong about the world, and what no choice within it could mend: a table on standard output.
//!
//! Mirror rays of every view of a scene, 480×270, each held against where it ends among the triangles (DEFINITIONS,
//! "World agreement"). For both versions of the oracle, and so for `unified`, which follows them, the reflecting pixels
//! that are wrong, and how: a hit where the world has none, by crossing a block's front or by its side; a hit
//! elsewhere; a miss. `least` is the share that stays wrong whichever of the blocks on its way a ray were told to hit:
//! the screen shows where it ends, but no block there meets it. `ssct` is the share that the thesis's method has wrong.
//!
//! `cargo bench --bench truth [-- SCENE…]`: names of built-in scenes or files.

#![allow(clippy::expect_used)]

use rayon::prelude::*;
use ssct::gpu::{DeviceQuery, Gpu};
use ssct::math::OracleVersion;
use ssct::methods::{Setup, ssct as thesis};
use ssct::metrics::world::{WITHIN_PIXELS, agreement};
use ssct::reference::oracle::{Meeting, Oracle};
use ssct::reference::ray::RaySetup;
use ssct::reference::surface::World;
use ssct::reference::world_hits::world_hits;
use ssct::scene::{Scene, library, scene_file};
use ssct::study::timing::camera;
use ssct::study::{Globals, Shot, Stage, gbuffer};
use std::path::Path;

const SIZE: [u32; 2] = [480, 270];

type Place = Option<[f64; 2]>;

/// Whether a block on the way lies where the ray ends.
fn is_right(meeting: &Meeting, end: [f64; 2]) -> bool {
    (0..2).all(|i| (meeting.position[i] - end[i]).abs() <= WITHIN_PIXELS)
}

fn print_view(scene: &Scene, name: &str, stage: &mut Stage, view: &str) {
    let view = scene.view(view).expect("a view of the scene");
    let materials = Globals { roughness: Some(0.0), ..Globals::default() }.materials(scene, view);
    let setup = Setup { split: true, ..Setup::new(SIZE) };
    let shot = Shot::new(stage, &thesis::INFO, &setup, camera(scene, view, SIZE), materials.clone()).expect("a shot");
    let (_, _, output) = stage.output(&shot).expect("a frame");
    let hits = output.traced.hits.expect("hits of a trace that is a pass of its own");
    let hits = gbuffer::hit_positions(&stage.context.read(hits.0.all()).expect("the hits"));
    let data = gbuffer::read(&mut stage.context, &shot).expect("the G-buffer");

    let ends: Vec<Place> = world_hits(&World::new(scene, &materials), &data)
        .iter()
        .map(|hit| hit.visible_at().map(|p| p.to_array()))
        .collect();
    let (rays, oracle) = (RaySetup::new(&data), Oracle::new(&data));
    let reflects = data.reflecting();
    let meetings: Vec<Vec<Meeting>> = (0..data.depth.len())
        .into_par_iter()
        .map(|i| {
            let (x, y) = (i as u32 % data.width, i as u32 / data.width);
            let segment = rays.mirror(x, y).filter(|_| reflects[i]).and_then(|way| rays.segment(x, y, way));
            segment.map_or(vec![], |segment| oracle.meetings(&segment))
        })
        .collect();
    let pixels = reflects.iter().filter(|r| **r).count() as f64;
    let share = |count: u64| count as f64 / pixels;
    let wrong = |hits: &[Place]| 1.0 - agreement(&reflects, &ends, hits).fraction().expect("pixels that reflect");
    let nowhere = |(met, end): (&Vec<Meeting>, &Place)| end.is_some_and(|end| !met.iter().any(|m| is_right(m, end)));
    let least = meetings.iter().zip(&ends).zip(&reflects).filter(|(pair, r)| **r && nowhere(*pair)).count();
    for version in [OracleVersion::V1, OracleVersion::V2] {
        let first =
            |met: &Vec<Meeting>| met.first().copied().filter(|m| !(version == OracleVersion::V2 && m.from_behind));
        let hit: Vec<Option<Meeting>> = meetings.iter().map(first).collect();
        let places: Vec<Place> = hit.iter().map(|m| m.map(|m| [m.position.x, m.position.y])).collect();
        let counts = agreement(&reflects, &ends, &places);
        let through_front = |(m, end): (&Option<Meeting>, &Place)| end.is_none() && m.is_some_and(|m| m.crosses_front);
        let front = hit.iter().zip(&ends).zip(&reflects).filter(|(pair, r)| **r && through_front(*pair)).count() as u64;
        let columns = [
            wrong(&hits),
            wrong(&places),
            share(front),
            share(counts.false_hits - front),
            share(counts.displaced),
            share(counts.missed),
            share(least as u64),
        ];
        println!("{name},{},{},{}", view.name, u32::from(version), columns.map(|v| format!("{v:.4}")).join(","));
    }
}

fn main() {
    let mut names: Vec<_> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    if names.is_empty() {
        names = ["rooms", "atrium"].map(str::to_owned).to_vec();
    }
    let gpu = Gpu::open(&DeviceQuery::default()).expect("a Vulkan device");
    println!("# {} ({}), ssct {}", gpu.info().name, gpu.info().driver, env!("CARGO_PKG_VERSION"));
    println!("scene,view,oracle,ssct,wrong,false_front,false_side,displaced,missed,least");
    for name in names {
        let from_file = || scene_file::load(Path::new(&name), 1.0).expect("a built-in scene or a file of one");
        let scene = library::scene(&name).unwrap_or_else(from_file);
        let mut stage = Stage::new(&gpu, &scene).expect("device memory");
        for view in &scene.views {
            print_view(&scene, &scene.name, &mut stage, &view.name);
        }
    }
}
