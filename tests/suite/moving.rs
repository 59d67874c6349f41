//! Tests meshes that move among the scene's triangles. Rays meet them at their new places, in a small tree of their
//! own. Nothing is built or recorded while nothing moves.

use crate::common::{check_validation, gpu};
use crate::triangles::{EXTENT, beyond, mirrors, traced};
use glam::{Quat, Vec3};
use ssct::gpu::frame::Mode;
use ssct::gpu::{FrameReport, Gpu, Pixels};
use ssct::methods::unified::FirstTraced;
use ssct::methods::{MethodInfo, Setup, Wants, find};
use ssct_ground::Result;
use ssct_ground::scene::tree::{BuildTrees, MovingTriangles, Tree, Trees, TriangleRecords, most_levels};
use ssct_lab::stage::{Shot, Stage, gbuffer};
use ssct_scenes::{Placement, Scene};
use std::cell::Cell;
use std::rc::Rc;

/// The view of the rooms that is drawn.
const VIEW: &str = "corridor";
/// The mesh that moves.
const MOVING: &str = "ball";

/// Makes a shot of mirrors in the rooms, by a method with its setup.
fn shot(stage: &mut Stage, scene: &Scene, (method, setup): (&MethodInfo, &Setup)) -> Shot {
    let camera = scene.view(VIEW).unwrap().camera(scene, EXTENT);
    Shot::new(stage, method, setup, Wants::REFLECTION, camera, mirrors(scene, VIEW)).unwrap()
}

/// Draws one frame, and returns its report and its reflection.
fn draw(stage: &mut Stage, shot: &Shot) -> (FrameReport, Pixels) {
    let (report, _, output) = stage.output_in(Mode::Timed, shot).unwrap();
    (report, gbuffer::reflection(&mut stage.context, &output).unwrap())
}

/// Returns the number of pixels that differ by more than 0.01.
fn differing(a: &Pixels, b: &Pixels) -> usize {
    a.texels().zip(b.texels()).filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 0.01)).count()
}

/// Returns the rooms with the ball in another place, as a scene file would have them.
fn rooms_with(placement: &Placement) -> Scene {
    let mut scene = crate::common::built_in("rooms");
    scene.meshes.iter_mut().filter(|m| m.name == MOVING).for_each(|m| m.place(placement));
    scene
}

/// Returns the reflection in rooms that were loaded with the ball in its new place.
fn loaded_there(gpu: &Gpu, placement: &Placement, method: (&MethodInfo, &Setup)) -> Pixels {
    let scene = rooms_with(placement);
    let mut stage = Stage::new(gpu, &scene).unwrap();
    let shot = shot(&mut stage, &scene, method);
    draw(&mut stage, &shot).1
}

/// A ball that is moved and turned after loading is reflected as in a scene that was loaded with the ball there, but
/// for 12 pixels at edges. The device transforms rays and normals into the moved mesh's space and back.
#[test]
fn what_moves_is_reflected_as_in_a_scene_that_is_made_so() {
    let gpu = gpu();
    let scene = crate::common::built_in("rooms");
    let ball = scene.meshes.iter().find(|m| m.name == MOVING).unwrap().bounds;
    let centre = 0.5 * (ball.min + ball.max);
    // The ball turned about its own middle and scaled, and then moved by `aside`.
    let turned = |angle: f32, size: f32, aside: Vec3| {
        let turn = Quat::from_rotation_x(angle);
        Placement { turn, size, offset: centre + aside - size * (turn * centre) }
    };
    let places = [Vec3::new(-0.2, 0.0, -0.2).into(), turned(0.8, 1.2, Vec3::new(-0.4, 0.1, 0.0)), Placement::HERE];
    let setups = [beyond(FirstTraced::Screen), beyond(FirstTraced::Triangles)];
    let unified = find("unified").unwrap();
    for (method, setup) in [(traced(), &setups[1]), (unified, &setups[0]), (unified, &setups[1])] {
        let mut stage = Stage::new(&gpu, &scene).unwrap();
        let shot = shot(&mut stage, &scene, (method, setup));
        let (_, still) = draw(&mut stage, &shot);
        for (n, placement) in places.iter().enumerate() {
            stage.scene_mut().place_meshes(MOVING, *placement).unwrap();
            let (_, moved) = draw(&mut stage, &shot);
            let truth = loaded_there(&gpu, placement, (method, setup));
            let (wrong, changed) = (differing(&moved, &truth), differing(&still, &truth));
            println!("{} at place {n}: {wrong} pixels off of {changed} that changed", method.name);
            // Where the device places the ball, its edges are rounded otherwise.
            assert!(wrong <= 12, "{} at place {n}: {wrong} pixels are off", method.name);
            assert!(changed > 60 || *placement == Placement::HERE, "{changed} pixels change");
        }
    }
    check_validation(&gpu).unwrap();
}

/// For every mesh of four scenes that moves alone, and for all meshes that move together, the tree has at most as many
/// levels as the walk's stack has room for. A deeper tree would overwrite other rays' entries.
#[test]
fn walks_have_room_for_whatever_moves() {
    for name in ["rooms", "museum", "street", "cathedral"] {
        let scene = crate::common::built_in(name);
        let (trees, room) = (Trees::new(&scene), most_levels(scene.triangle_count()));
        let mut meshes: Vec<&str> = scene.meshes.iter().map(|m| m.name.as_str()).collect();
        meshes.sort_unstable();
        meshes.dedup();
        let placements: Vec<_> = meshes.iter().map(|mesh| (*mesh, Placement::HERE)).collect();
        for placed in placements.iter().map(std::slice::from_ref).chain([&placements[..]]) {
            let levels = trees.moving(placed).unwrap().tree.levels;
            assert!(levels <= room, "{name}: {levels} levels of {} meshes, and room for {room}", placed.len());
        }
    }
}

/// Builds trees, and counts how often: those of the meshes that stand, and those of the meshes that move.
struct Counting {
    trees: Trees,
    counts: Rc<[Cell<usize>; 2]>,
}

impl BuildTrees for Counting {
    fn standing(&self, moving: &[&str]) -> Result<(Tree, TriangleRecords)> {
        self.counts[0].update(|n| n + 1);
        self.trees.standing(moving)
    }

    fn moving(&self, placed: &[(&str, Placement)]) -> Result<MovingTriangles> {
        self.counts[1].update(|n| n + 1);
        self.trees.moving(placed)
    }
}

/// The tree of standing meshes is rebuilt once, when the ball leaves it. The ball's own tree is rebuilt in each frame
/// in which the ball moves, and in no other. Each build costs time in a frame.
#[test]
fn only_what_moves_is_built_anew_and_only_when_it_moves() {
    let gpu = gpu();
    let scene = crate::common::built_in("rooms");
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let counts = Rc::new([const { Cell::new(0) }; 2]);
    stage.scene_mut().set_tree_builder(Counting { trees: Trees::new(&scene), counts: Rc::clone(&counts) });
    let shot = shot(&mut stage, &scene, (traced(), &Setup::new(EXTENT)));
    // Draws a frame with the ball at an offset along x in metres. Returns the numbers of built trees, and the passes of
    // moving meshes, with whether they count.
    let mut frame = |offset: f32| {
        counts.iter().for_each(|n| n.set(0));
        stage.scene_mut().place_meshes(MOVING, Vec3::X * offset).unwrap();
        let (report, _) = draw(&mut stage, &shot);
        let passes: Vec<String> = report.passes.iter().map(|p| p.name.clone()).collect();
        assert_eq!(passes, report.recorded);
        let moving_passes = report.passes.iter().filter(|p| p.name.starts_with("moving"));
        let moving_passes: Vec<_> = moving_passes.map(|p| (p.name.clone(), p.counted)).collect();
        ([counts[0].get(), counts[1].get()], moving_passes)
    };
    let nothing = ([0, 0], Vec::new());
    // The trees were built with the shot.
    assert_eq!(frame(0.0), nothing);
    // With its first move, the ball leaves the tree of the standing meshes.
    assert_eq!(frame(-0.1), ([1, 1], Vec::new()));
    assert_eq!(frame(-0.1), nothing);
    for n in 2..5 {
        let moving_passes = ["moving/tree", "moving"].map(|name| (name.to_owned(), true)).to_vec();
        assert_eq!(frame(-0.1 * n as f32), ([0, 1], moving_passes));
    }
    assert_eq!(frame(-0.4), nothing);
    check_validation(&gpu).unwrap();
}
