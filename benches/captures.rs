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

/// True if a point of the world projects into the camera's image, hidden or not.
fn is_on_screen(camera: &Camera, point: DVec3) -> bool {
    let clip = camera.view_to_clip() * camera.world_to_view * point.as_vec3().extend(1.0);
    clip.w > 0.0 && clip.x.abs() <= clip.w && clip.y.abs() <= clip.w
}

/// Returns, for each number of [`COUNTS`], the share of the ends of a view's mirror rays that the screen or one of that
/// many captures shows.
fn shown_shares(scene: &Scene, view: &View, captures: &[Capture]) -> [f64; COUNTS.len()] {
    let materials = scene.materials_in(view);
    let (world, triangles) = (World::new(scene, &materials), Triangles::new(scene, &materials));
    let camera = view.camera(scene, SIZE);
    let first_hits = FirstHits::trace(&world, &camera, SIZE);
    // For each end of a ray, the number of captures that are needed until one shows it: 0 if the screen shows it, and
    // `None` if nothing does.
    let captures_needed: Vec<Option<usize>> = first_hits
        .receivers
        .par_iter()
        .flatten()
        .filter_map(|receiver| {
            let (origin, direction) = (receiver.position, receiver.mirror());
            let ray = WorldRay { origin, direction, t_min: RAY_START_M, t_max: f64::INFINITY };
            let end = ray.point_at(world.closest(&ray)?.t);
            let sees_end = |eye: Vec3| sees(&triangles, eye.as_dvec3(), end);
            if is_on_screen(&camera, end) && sees_end(view.eye) {
                return Some(Some(0));
            }
            Some(captures.iter().position(|capture| sees_end(capture.position)).map(|index| index + 1))
        })
        .collect();
    let end_count = captures_needed.len().max(1) as f64;
    COUNTS.map(|count| captures_needed.iter().flatten().filter(|n| **n <= count).count() as f64 / end_count)
}

/// Places 8 captures in a scene, and prints a line for each: its place, and the share of what mirrors show beyond the
/// screen that the captures so far see. Then prints a row of [`shown_shares`] for each view, and their medians.
fn print_scene(scene: &Scene) {
    let start = Instant::now();
    let placed = place(scene, WantedCaptures::Count(8));
    println!("{}: {} triangles, placed in {:.1} s", scene.name, scene.triangle_count(), start.elapsed().as_secs_f64());
    for (capture, seen) in placed.captures.iter().zip(&placed.seen) {
        println!("{:.2}, {:.1} % seen", capture.position, 100.0 * seen);
    }
    println!("{},view,{}", scene.name, COUNTS.map(|count| count.to_string()).join(","));
    let print_row = |name: &str, shares: &[f64; COUNTS.len()]| {
        println!("{},{name},{}", scene.name, shares.map(|s| format!("{:.1}", 100.0 * s)).join(","));
    };
    let rows: Vec<_> =
        scene.views.iter().map(|view| (&view.name, shown_shares(scene, view, &placed.captures))).collect();
    rows.iter().for_each(|(name, shares)| print_row(name, shares));
    print_row("median", &std::array::from_fn(|column| median_of(rows.iter().map(|(_, shares)| shares[column]))));
}

/// Prints the tables of the scenes that the command line names, or of all built-in scenes.
fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let names = if arguments.is_empty() { library::names().iter().map(|n| n.to_string()).collect() } else { arguments };
    for name in names {
        let scene = library::scene_or_file(&name).expect("a built-in scene or a file of one");
        print_scene(&scene);
    }
}
