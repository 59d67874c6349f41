//! Tests the world reference on Crytek Sponza, if `../shared/scenes` is there: a quarter of a million triangles, and
//! plants with masks.

use crate::common::sponza;
use ssct_scenes::Camera;
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::surface::World;

/// Every ray straight down into the court meets the building. Without masks, no first hit is further away and some are
/// nearer. Cracks between triangles and masks that are read wrongly would show here.
#[test]
fn sponza_is_ready_for_rays_and_has_no_cracks() {
    let Some(scene) = sponza() else { return };
    let world = World::new(&scene, &scene.materials);
    // From the middle of the court straight down, only the floor can be seen.
    let view = scene.views[0].clone();
    let camera = Camera::new(view.eye, view.eye - glam::Vec3::Y, scene.lens, 1.0);
    let first_hits = FirstHits::trace(&world, &camera, [64, 64]);
    assert!(first_hits.view_z_m.iter().all(|z| z.is_finite()), "every ray downwards meets the building");

    // With the masks taken out, the plants are solid: some first hits come nearer, none goes further.
    let mut solid = scene.materials.clone();
    assert!(solid.iter().any(|m| m.alpha_mask.is_some()));
    solid.iter_mut().for_each(|m| m.alpha_mask = None);
    let solid_world = World::new(&scene, &solid);
    let camera = Camera::new(view.eye, view.look_at, scene.lens, 1.5);
    let [masked, solid] = [&world, &solid_world].map(|w| FirstHits::trace(w, &camera, [96, 64]).view_z_m);
    assert!(masked.iter().zip(&solid).all(|(m, s)| s <= m));
    let nearer = masked.iter().zip(&solid).filter(|(m, s)| s < m).count();
    println!("{nearer} of 6144 pixels look through a mask");
    assert!(nearer > 0);
}
