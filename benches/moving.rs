//! Measures what a moving mesh costs among the scene's triangles. Prints a table to standard output.
//!
//! The mesh moves before each frame. `whole_ms` is the time to build the tree over all triangles anew, with its
//! records, and to bring it to the device. `moving_ms` is the time to build a small tree over the moving triangles
//! alone, and to bring that to the device. Both are wall times, medians of [`FRAMES`] frames, in each of which both are
//! measured.

#![allow(clippy::expect_used, clippy::unwrap_used)]

use glam::Vec3;
use ssct::gpu::{DeviceQuery, FrameContext, Gpu};
use ssct::passes::scene_data::SceneData;
use ssct::passes::triangle_scene::TriangleGeometry;
use ssct_ground::scene::tree::{MovingTriangles, Tree, Trees, TriangleRecords};
use ssct_scenes::{Scene, library};
use ssct_truth::metrics::bootstrap::median_of;
use std::time::Instant;

/// Number of frames that count.
const FRAMES: usize = 15;

/// Built-in scenes, each with the name of the mesh that moves.
const MOVING: [(&str, &str); 3] = [("rooms", "ball"), ("museum", "ball"), ("street", "car-body")];

/// Runs an action and returns its wall time in milliseconds.
fn milliseconds(action: impl FnOnce()) -> f64 {
    let begun = Instant::now();
    action();
    1e3 * begun.elapsed().as_secs_f64()
}

/// Times both ways of moving a mesh in each scene of [`MOVING`], and prints a row for each.
fn main() {
    let gpu = Gpu::open(&DeviceQuery::default()).expect("a Vulkan device");
    println!("# {} ({}), ssct {}", gpu.info().name, gpu.info().driver, env!("CARGO_PKG_VERSION"));
    println!("scene,mesh,triangles,moving_triangles,whole_ms,moving_ms");
    for (name, mesh) in MOVING {
        let scene = library::scene(name).expect("a built-in scene");
        let scene_at_rest =
            Scene { meshes: scene.meshes.clone(), materials: scene.materials.clone(), ..Scene::default() };
        let mut context = FrameContext::new(&gpu).expect("a context");
        let mut data = SceneData::upload(&mut context, &scene).expect("device memory");
        data.set_tree_builder(Trees::new(&scene));
        let [mut whole_times, mut moving_times] = [const { Vec::new() }; 2];
        for frame in 1..=FRAMES + 1 {
            let offset = Vec3::Y * 0.01 * frame as f32;
            let whole_ms = milliseconds(|| {
                let mut moved_scene = scene_at_rest.clone();
                moved_scene.meshes.iter_mut().filter(|m| m.name == mesh).for_each(|m| m.translate(offset));
                let tree = Tree::build(&moved_scene).expect("a tree");
                let records = TriangleRecords::new(&moved_scene, &tree);
                TriangleGeometry::new(&mut context, (&tree, &records), &MovingTriangles::default()).expect("memory");
            });
            data.place_meshes(mesh, offset).expect("a mesh");
            let moving_ms = milliseconds(|| {
                data.prepare_triangles(&mut context, false).expect("triangles");
                context.once(|frame| data.copy_moving(frame)).expect("a frame");
            });
            // In the first frame, which does not count, the mesh is also removed from the tree of meshes at rest.
            if frame > 1 {
                whole_times.push(whole_ms);
                moving_times.push(moving_ms);
            }
        }
        let moving_triangles: usize = scene.meshes.iter().filter(|m| m.name == mesh).map(|m| m.indices.len() / 3).sum();
        let (triangles, [whole_ms, moving_ms]) = (scene.triangle_count(), [whole_times, moving_times].map(median_of));
        println!("{name},{mesh},{triangles},{moving_triangles},{whole_ms:.2},{moving_ms:.2}");
    }
}
