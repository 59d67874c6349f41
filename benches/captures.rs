//! Measures what captures that are placed without knowing a view show of what the mirrors of each view show.
#![allow(clippy::expect_used)]

use rayon::prelude::*;
use ssct::reference::first_hits::FirstHits;
use ssct::reference::surface::World;
use ssct::scene::bvh::WorldRay;
use ssct::scene::placement::{self, place, sees};
use ssct::scene::{Camera, Scene, Triangles, View, library, scene_file};
use std::path::Path;
use std::time::Instant;

const SIZE: [u32; 2] = [192, 108];
const COUNTS: [usize; 7] = [0, 1, 2, 3, 4, 6, 8];

fn on_screen(camera: &Camera, place: glam::DVec3) -> bool {
    let clip = camera.view_to_clip() * camera.world_to_view * place.as_vec3().extend(1.0);
    clip.w > 0.0 && clip.x.abs() <= clip.w && clip.y.abs() <= clip.w
}

fn view_shares(scene: &Scene, view: &View, captures: &[glam::Vec3]) -> Vec<f64> {
    let materials = scene.materials_in(view);
    let world = World::new(scene, &materials);
    let triangles = Triangles::new(scene, &materials);
    let camera = view.camera(scene, SIZE);
    let first = FirstHits::trace(&world, &camera, SIZE);
    // The number of captures that it takes to see the end, or usize::MAX; None for escaped rays.
    let needed: Vec<usize> = first
        .receivers
        .par_iter()
        .flatten()
        .filter_map(|r| {
            let ray = WorldRay { origin: r.position, direction: r.mirror(), t_min: 1e-4, t_max: f64::INFINITY };
            let end = ray.at(world.closest(&ray)?.t);
            if on_screen(&camera, end) && sees(&triangles, view.eye.as_dvec3(), end) {
                return Some(0);
            }
            let found = captures.iter().position(|c| sees(&triangles, c.as_dvec3(), end));
            Some(found.map_or(usize::MAX, |k| k + 1))
        })
        .collect();
    COUNTS.iter().map(|n| needed.iter().filter(|k| *k <= n).count() as f64 / needed.len().max(1) as f64).collect()
}

fn measure(scene: &Scene) {
    let start = Instant::now();
    let placed = place(scene, 8);
    let seconds = start.elapsed().as_secs_f64();
    println!("{}: {} triangles, {seconds:.2} s", scene.name, scene.triangle_count());
    if std::env::var("STANDS").is_ok() {
        let triangles = Triangles::new(scene, &scene.materials);
        let stands = placement::stands(&triangles, scene);
        println!("  {} stands", stands.len());
        let mut levels = std::collections::BTreeMap::<i32, Vec<[f64; 4]>>::new();
        for s in &stands {
            levels.entry(((s.eye.y - 1.5) * 2.0).round() as i32).or_default().push([
                s.roofed,
                s.backs,
                s.nearest_m,
                s.height_m,
            ]);
        }
        for (y, all) in levels.iter().filter(|(_, a)| a.len() > 5) {
            let q = |k: usize, p: f64| {
                let mut v: Vec<f64> = all.iter().map(|a| a[k]).collect();
                v.sort_by(f64::total_cmp);
                v[((v.len() - 1) as f64 * p) as usize]
            };
            println!(
                "    floor {:5.1} m: {:4}  roofed {:.2} {:.2} {:.2} {:.2} {:.2}  backs {:.2} {:.2} {:.2} near {:.2} {:.2} high {:.1} {:.1}",
                *y as f64 / 2.0,
                all.len(),
                q(0, 0.0),
                q(0, 0.25),
                q(0, 0.5),
                q(0, 0.75),
                q(0, 1.0),
                q(1, 0.1),
                q(1, 0.5),
                q(1, 0.9),
                q(2, 0.1),
                q(2, 0.5),
                q(3, 0.1),
                q(3, 0.9)
            );
        }
        for v in &scene.views {
            println!("    view {} at {:.1}", v.name, v.eye);
        }
    }
    for (capture, seen) in placed.captures.iter().zip(&placed.seen) {
        println!("  {:.2} seen {:.3}", capture.position, seen);
    }
    let positions: Vec<glam::Vec3> = placed.captures.iter().map(|c| c.position).collect();
    let mut all: Vec<Vec<f64>> = Vec::new();
    for view in &scene.views {
        let shares = view_shares(scene, view, &positions);
        let text: Vec<String> = shares.iter().map(|s| format!("{:5.1}", 100.0 * s)).collect();
        println!("  {:16} {}", view.name, text.join(" "));
        all.push(shares);
    }
    let median: Vec<String> = (0..COUNTS.len())
        .map(|k| {
            let mut v: Vec<f64> = all.iter().map(|s| s[k]).collect();
            v.sort_by(f64::total_cmp);
            format!("{:5.1}", 50.0 * (v[(v.len() - 1) / 2] + v[v.len() / 2]))
        })
        .collect();
    println!("  {:16} {}", "MEDIAN", median.join(" "));
}

fn main() {
    let named: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let files = ["ssct-rooms/rooms.scene.toml", "sponza/sponza.scene.toml"];
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    let all = library::names().iter().map(|n| n.to_string()).chain(files.map(|f| shared.join(f).display().to_string()));
    for name in if named.is_empty() { all.collect() } else { named } {
        let scene = library::scene(&name).unwrap_or_else(|| scene_file::load(Path::new(&name), 1.0).expect("a scene"));
        measure(&scene);
    }
}
