//! Measures how much of what mirrors reflect the screen and automatically placed captures show. Prints a table in CSV
//! to standard output.
//!
//! For each view, the mirror ray of every reflecting pixel of a small image is followed to where it ends among the
//! triangles. The table gives the share of these ends that the screen shows. It also gives the shares that the screen or
//! one of the first 1, 2, 3, 4 and 8 captures shows. All are found by exact tests of visibility. The last row has the
//! medians over the scene's views. Rays without an end do not count. The placement does not depend on the views.
//! The lines before the table of a scene give the places, the shares that the placement itself expects to be seen, and
//! how long it took.
//!
//! Usage: `cargo bench --bench captures [-- SCENE…]`, with names of built-in scenes or files, relative ones from `lab/`.

#![allow(clippy::expect_used)]

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use ssct_geometry::bvh::WorldRay;
use ssct_geometry::placement::{WantedCaptures, place, sees};
use ssct_geometry::triangles::Triangles;
use ssct_scenes::{Camera, Capture, Scene, View, library};
use ssct_truth::metrics::bootstrap::median_of;
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world::RAY_START_M;
use std::time::Instant;

/// Width and height of the images in pixels.
const SIZE: [u32; 2] = [192, 108];
/// The numbers of captures that are compared.
const COUNTS: [usize; 6] = [0, 1, 2, 3, 4, 8];

/// True if a place lies inside the image, hidden or not.
fn is_on_screen(camera: &Camera, place: DVec3) -> bool {
    let clip = camera.view_to_clip() * camera.world_to_view * place.as_vec3().extend(1.0);
    clip.w > 0.0 && clip.x.abs() <= clip.w && clip.y.abs() <= clip.w
}

/// Returns, for each number of [`COUNTS`], the share of the ends of a view's mirror rays that the screen or one of that
/// many captures shows.
fn shown_shares(scene: &Scene, view: &View, captures: &[Capture]) -> [f64; COUNTS.len()] {
    let materials = scene.materials_in(view);
    let (world, triangles) = (World::new(scene, &materials), Triangles::new(scene, &materials));
    let camera = view.camera(scene, SIZE);
    let first = FirstHits::trace(&world, &camera, SIZE);
    // For each end, how many captures are needed until one shows it: 0 if the screen shows it, and `None` if nothing
    // does.
    let needed: Vec<Option<usize>> = first
        .receivers
        .par_iter()
        .flatten()
        .filter_map(|r| {
            let ray = WorldRay { origin: r.position, direction: r.mirror(), t_min: RAY_START_M, t_max: f64::INFINITY };
            let end = ray.point_at(world.closest(&ray)?.t);
            let sees = |from: Vec3| sees(&triangles, from.as_dvec3(), end);
            if is_on_screen(&camera, end) && sees(view.eye) {
                return Some(Some(0));
            }
            Some(captures.iter().position(|c| sees(c.position)).map(|index| index + 1))
        })
        .collect();
    let ends = needed.len().max(1) as f64;
    COUNTS.map(|count| needed.iter().flatten().filter(|needed| **needed <= count).count() as f64 / ends)
}

/// Places captures in a scene, and prints the scene's lines and table.
fn print_scene(scene: &Scene) {
    let start = Instant::now();
    let placed = place(scene, WantedCaptures::Count(8));
    println!("{}: {} triangles, placed in {:.1} s", scene.name, scene.triangle_count(), start.elapsed().as_secs_f64());
    for (capture, seen) in placed.captures.iter().zip(&placed.seen) {
        println!("{:.2}, {:.1} % seen", capture.position, 100.0 * seen);
    }
    println!("{},view,{}", scene.name, COUNTS.map(|n| n.to_string()).join(","));
    let print_row = |name: &str, shares: &[f64; COUNTS.len()]| {
        println!("{},{name},{}", scene.name, shares.map(|s| format!("{:.1}", 100.0 * s)).join(","));
    };
    let rows: Vec<_> =
        scene.views.iter().map(|view| (&view.name, shown_shares(scene, view, &placed.captures))).collect();
    rows.iter().for_each(|(name, shares)| print_row(name, shares));
    print_row("median", &std::array::from_fn(|column| median_of(rows.iter().map(|(_, shares)| shares[column]))));
}

fn main() {
    let named: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let names = if named.is_empty() { library::names().iter().map(|n| n.to_string()).collect() } else { named };
    for name in names {
        let scene = library::scene_or_file(&name).expect("a built-in scene or a file of one");
        print_scene(&scene);
    }
}
