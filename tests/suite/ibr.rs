//! Compares `ibr` with the triangles. A plane shows what stands in its box, lit, where the ray meets the plane. Things
//! outside of the box are not in its image, and a rough surface sees the image blurred.

use crate::common::{Builder, Truth, beside_truth, camera, gpu};
use glam::Vec3;
use ssct::gpu::{Gpu, Pixels};
use ssct::methods::Setup;
use ssct::methods::ibr::IbrParams;
use ssct_lab::stage::Globals;
use ssct_scenes::{Impostor, Scene};

/// Size of the image in pixels.
const EXTENT: [u32; 2] = [241, 181];
/// The centre of the picture and of its box, in metres.
const CENTRE: Vec3 = Vec3::new(0.0, 1.5, 6.0);
/// Half of the picture's width, along its rows.
const HALF_U: Vec3 = Vec3::new(1.5, 0.0, 0.0);
/// Half of the picture's height, down its columns.
const HALF_V: Vec3 = Vec3::new(0.0, -0.75, 0.0);

/// Returns a mirror floor before a picture in a box. The picture is red on its left, green on its right, brighter
/// towards the top. If `with_block` is true, a blue block stands a metre and a half before the picture.
fn scene(with_block: bool) -> Scene {
    let mut b = Builder::new("facade");
    let floor = b.mirror();
    b.quad(floor, Vec3::new(-6.0, 0.0, 0.0), Vec3::X * 12.0, Vec3::Z * 6.0, Vec3::Y);
    let colour = |x: u32, y: u32| {
        let bright = 250 - 25 * (y as u8);
        if x < 4 { [bright, 10, 10] } else { [10, bright, 10] }
    };
    let picture = b.picture(8, 8, colour);
    b.quad(picture, CENTRE - HALF_U + HALF_V, 2.0 * HALF_U, -2.0 * HALF_V, -Vec3::Z);
    if with_block {
        let blue = b.matt(Vec3::Z);
        b.quad(blue, Vec3::new(-0.5, 0.0, 4.5), Vec3::X, Vec3::Y * 1.8, -Vec3::Z);
    }
    // `ibr` draws the box itself and does not read the impostor's texture.
    b.0.impostors = vec![Impostor { name: "box".into(), centre: CENTRE, half_u: HALF_U, half_v: HALF_V, texture: 0 }];
    b.0
}

/// Renders a scene by `ibr` with boxes of some depth in metres, and traces the same rays among the triangles.
fn see(gpu: &Gpu, scene: &Scene, depth: f32, roughness: f32) -> Truth {
    let setup = Setup::new(EXTENT).with(|p: &mut IbrParams| p.ibr_depth = depth);
    let camera = camera(Vec3::new(0.3, 1.6, 0.2), Vec3::new(0.0, 0.6, 5.0), EXTENT);
    let globals = Globals { roughness: Some(roughness), ..Globals::default() };
    beside_truth(gpu, scene, camera, "ibr", &setup, &globals)
}

/// Returns the kind of a colour: 0 for black, 1 for red, 2 for green, 3 for blue.
fn kind(color: Vec3) -> usize {
    if color.max_element() < 1e-3 { 0 } else { color.max_position() + 1 }
}

/// Returns the number of pixels of each kind.
fn kinds(reflection: &Pixels) -> [usize; 4] {
    let mut counts = [0; 4];
    reflection.texels().for_each(|t| counts[kind(Vec3::from_slice(t))] += 1);
    counts
}

/// In over 96 % of the pixels, the reflection shows red, green or nothing where the triangles do, with a median error
/// of colour below 3 %. The method lights the image of its box itself.
#[test]
fn a_plane_shows_what_stands_in_its_box_as_it_is_lit() {
    let gpu = gpu();
    let Truth { reflection, world: truth, .. } = see(&gpu, &scene(false), 0.5, 0.0);
    let (mut shown, mut wrong, mut relative_errors) = (0, 0, Vec::new());
    for (texel, truth) in reflection.texels().zip(&truth) {
        let texel = Vec3::from_slice(texel);
        shown += usize::from(kind(*truth) > 0);
        wrong += usize::from(kind(texel) != kind(*truth));
        if kind(texel) == kind(*truth) && kind(texel) > 0 {
            relative_errors.push((texel - *truth).abs().max_element() / truth.max_element());
        }
    }
    relative_errors.sort_by(f32::total_cmp);
    let median = relative_errors[relative_errors.len() / 2];
    println!("{shown} pixels show the picture, {wrong} differ, median error {median}");
    assert!(shown > 1000 && wrong * 30 < shown, "{wrong} of {shown}");
    // Unlike the image of an impostor, the image of the box is lit as the scene is.
    assert!(median < 0.03, "{median}");
}

/// A box of 0.5 m does not show the blue block, which stands 1.5 m in front of it. A box of 2 m does, and the block
/// hides part of the picture.
#[test]
fn a_box_holds_what_stands_in_it_and_nothing_else() {
    let gpu = gpu();
    let counts = |depth| kinds(&see(&gpu, &scene(true), depth, 0.0).reflection);
    let (thin, deep) = (counts(0.5), counts(2.0));
    println!("black, red, green, blue: {thin:?} thin, {deep:?} deep");
    // The block stands in front of the thin box, and the deep box shows it flattened onto its plane.
    assert_eq!(thin[3], 0);
    assert!(deep[3] > 300 && deep[1] + deep[2] < thin[1] + thin[2]);
}

/// At roughness 1, fewer than nine tenths of the pixels that a mirror shows as clearly red or green are still clearly
/// red or green.
#[test]
fn gloss_is_blur() {
    let gpu = gpu();
    let scene = scene(false);
    // The number of pixels that are clearly red or green. A blur mixes red and green with each other, and with the
    // black around.
    let pure = |roughness| {
        let Truth { reflection, .. } = see(&gpu, &scene, 0.5, roughness);
        let is_pure = |t: &&[f32]| t[0] > 4.0 * t[1].max(1e-3) || t[1] > 4.0 * t[0].max(1e-3);
        reflection.texels().filter(is_pure).count()
    };
    let (mirror, rough) = (pure(0.0), pure(1.0));
    println!("{mirror} pure pixels of a mirror, {rough} at roughness 1");
    assert!(mirror > 1000 && rough * 10 < mirror * 9, "{rough} of {mirror}");
}
