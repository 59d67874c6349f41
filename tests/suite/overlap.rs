//! Tests surfaces in one place: the G-buffer shows the one that the scene lists first.

use crate::common::{check_validation, gpu};
use glam::Vec3;
use ssct::gpu::Gpu;
use ssct_lab::stage::{Shot, Stage, gbuffer};
use ssct_scenes::{Material, Mesh, Scene, Vertex};

/// Size of the images in pixels.
const EXTENT: [u32; 2] = [96, 54];

/// Returns the depths, normals and reflectivities of a scene's G-buffer.
fn drawn(gpu: &Gpu, scene: &Scene) -> (Vec<f32>, Vec<Vec3>, Vec<f32>) {
    let view = scene.view("corridor").unwrap();
    let mut stage = Stage::new(gpu, scene).unwrap();
    let shot = Shot::of_scene(&mut stage, EXTENT, view.camera(scene, EXTENT), scene.materials_in(view)).unwrap();
    stage.draw(&shot).unwrap();
    let images = gbuffer::read(&mut stage.context, &shot).unwrap();
    (images.depth, images.normal, images.reflectivity)
}

/// Adds every triangle of a mesh a second time, in one place with the first and with the opposite normals.
fn double(mesh: &mut Mesh) {
    let first = mesh.vertices.len() as u32;
    let turned = |v: &Vertex| Vertex { normal: v.normal.map(|n| -n), ..*v };
    mesh.vertices.extend(mesh.vertices.iter().map(turned).collect::<Vec<_>>());
    mesh.indices.extend(mesh.indices.iter().map(|index| index + first).collect::<Vec<_>>());
}

/// If every surface is repeated in its place, by later meshes or by later triangles, the G-buffer does not change.
/// Which of two surfaces of one depth wins must not depend on the driver.
#[test]
fn what_stands_where_something_came_before_is_not_seen() {
    let gpu = gpu();
    let scene = crate::common::built_in("rooms");
    let alone = drawn(&gpu, &scene);
    // Later meshes repeat every surface, in a material that reflects nothing.
    let mut covered = scene.clone();
    let material = covered.materials.len();
    covered.materials.push(Material { reflectivity: 0.0, ..Material::default() });
    covered.meshes.extend(scene.meshes.iter().cloned().map(|mesh| Mesh { material, ..mesh }));
    assert!(alone == drawn(&gpu, &covered), "a mesh is covered by one that comes after it");
    let mut doubled = scene.clone();
    doubled.meshes.iter_mut().for_each(double);
    assert!(alone == drawn(&gpu, &doubled), "a triangle is covered by one that comes after it");
    check_validation(&gpu).unwrap();
}
