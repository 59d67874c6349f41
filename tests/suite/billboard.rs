//! Compares `billboard` with the triangles: an impostor that stands exactly where a picture hangs must be seen where
//! the picture's reflection is. With occlusion, whatever hides the picture must hide the impostor, too.

use crate::common::{Builder, Truth, beside_truth, camera, gpu, show};
use glam::Vec3;
use ssct::gpu::{Gpu, Pixels};
use ssct::methods::Setup;
use ssct::methods::billboard::BillboardParams;
use ssct::passes::billboard::{Blur, Occlusion, Order};
use ssct_lab::stage::Globals;
use ssct_scenes::{Encoding, Impostor, Scene, Texture};
use ssct_truth::reference::first_hits::Receiver;

/// Size of the image in pixels.
const EXTENT: [u32; 2] = [241, 181];
/// The centre of the picture and of its impostor, in metres.
const CENTRE: Vec3 = Vec3::new(0.0, 1.5, 6.0);
/// Half of the picture's width, along its rows.
const HALF_U: Vec3 = Vec3::new(1.5, 0.0, 0.0);
/// Half of the picture's height, down its columns.
const HALF_V: Vec3 = Vec3::new(0.0, -0.75, 0.0);

/// Returns the texel of the picture in column x and row y, in sRGB: red on the left, green on the right, brighter
/// towards the top. A method that mirrors the picture in x or y thus fails the tests.
fn colour(x: u32, y: u32) -> [u8; 3] {
    let bright = 250 - 25 * (y as u8);
    if x < 4 { [bright, 10, 10] } else { [10, bright, 10] }
}

/// Returns a mirror floor before a picture that has an impostor. If `with_block` is true, a blue block stands between
/// the floor and the picture.
fn scene(with_block: bool) -> Scene {
    let mut b = Builder::new("picture");
    let floor = b.mirror();
    b.quad(floor, Vec3::new(-6.0, 0.0, 0.0), Vec3::X * 12.0, Vec3::Z * 6.0, Vec3::Y);
    let picture = b.picture(8, 8, colour);
    b.quad(picture, CENTRE - HALF_U + HALF_V, 2.0 * HALF_U, -2.0 * HALF_V, -Vec3::Z);
    if with_block {
        let blue = b.matt(Vec3::new(0.0, 0.0, 1.0));
        b.quad(blue, Vec3::new(-0.5, 0.0, 4.5), Vec3::X * 0.7, Vec3::Y * 1.1, -Vec3::Z);
        b.quad(blue, Vec3::new(-0.5, 0.0, 5.0), Vec3::X * 0.7, Vec3::Y * 1.1, Vec3::Z);
    }
    let impostor = Impostor { name: "picture".into(), centre: CENTRE, half_u: HALF_U, half_v: HALF_V, texture: 0 };
    b.0.impostors = vec![impostor];
    // The scene has no lights, so that ambient light alone shows the colours of the picture.
    let texels = (0..64).flat_map(|k| [colour(k % 8, k / 8).as_slice(), &[255]].concat()).collect();
    b.0.textures.push(Texture { name: "impostor".into(), width: 8, height: 8, rgba: texels, encoding: Encoding::Srgb });
    b.0.impostors[0].texture = 1;
    b.0
}

/// Renders a scene by `billboard` with changed parameters, and traces the same rays among the triangles.
fn shown_with(gpu: &Gpu, scene: &Scene, change: impl FnOnce(&mut BillboardParams)) -> Truth {
    let camera = camera(Vec3::new(0.3, 1.6, 0.2), Vec3::new(0.0, 0.6, 5.0), EXTENT);
    beside_truth(gpu, scene, camera, "billboard", &Setup::new(EXTENT).with(change), &Globals::default())
}

/// Renders a scene by `billboard` with an order of impostors and a kind of occlusion, and traces the same rays among
/// the triangles.
fn see(gpu: &Gpu, scene: &Scene, order: Order, occlusion: Occlusion) -> Truth {
    shown_with(gpu, scene, |p| (p.billboard_order, p.billboard_occlusion) = (order, occlusion))
}

/// Returns the kind of a colour: 0 for black, 1 for red, 2 for green, 3 for blue.
fn kind(color: Vec3) -> u8 {
    match color.max_position() {
        _ if color.max_element() < 1e-3 => 0,
        channel => channel as u8 + 1,
    }
}

/// A pixel shows red, green or nothing exactly where the triangles do, but for 3 % of pixels at edges, in all three
/// orders of impostors. A wrong axis or sign of the impostor's rectangle would mirror or shift the picture.
#[test]
fn an_impostor_is_seen_where_the_thing_is() {
    let gpu = gpu();
    for order in [Order::Printed, Order::Unbroken, Order::Nearest] {
        let seen = see(&gpu, &scene(false), order, Occlusion::None);
        let (mut shown, mut wrong) = (0, 0);
        let mut ratios = Vec::new();
        for ((texel, truth), receiver) in seen.reflection.texels().zip(&seen.world).zip(&seen.first_hits.receivers) {
            let texel = Vec3::from_slice(texel);
            assert!(receiver.is_some() || texel == Vec3::ZERO);
            shown += u32::from(kind(*truth) > 0);
            wrong += u32::from(kind(texel) != kind(*truth));
            if kind(texel) == kind(*truth) && kind(texel) > 0 {
                ratios.push(texel.max_element() / truth.max_element());
            }
        }
        // The picture is lit by the ambient light of 0.2 alone, while its impostor shows the image unlit: the ratio is
        // 1 / 0.2 = 5.
        ratios.sort_by(f32::total_cmp);
        let median = ratios[ratios.len() / 2];
        println!("{order:?}: {shown} pixels show the picture, {wrong} differ, {median} as bright");
        assert!(shown > 1000 && f64::from(wrong) < 0.03 * f64::from(shown), "{order:?}: {wrong} of {shown}");
        assert!((median - 5.0).abs() < 0.2, "{median}");
    }
}

/// A blue block hides part of the picture. Without occlusion the impostor shows through the block, as in figure 41.
/// With occlusion by depth it does so in less than 5 % of the hidden pixels, and few open pixels lose it.
#[test]
fn what_hides_the_thing_hides_its_impostor_with_occlusion() {
    let gpu = gpu();
    // The share of hidden pixels where the impostor shows through, and the share of open pixels where the impostor is
    // lost.
    let through = |occlusion| {
        let seen = see(&gpu, &scene(true), Order::Nearest, occlusion);
        let (mut hidden, mut shows, mut open, mut lost) = (0, 0, 0, 0);
        for (texel, truth) in seen.reflection.texels().zip(&seen.world) {
            let drawn = kind(Vec3::from_slice(texel)) > 0;
            match kind(*truth) {
                3 => (hidden, shows) = (hidden + 1, shows + u32::from(drawn)),
                1 | 2 => (open, lost) = (open + 1, lost + u32::from(!drawn)),
                _ => {}
            }
        }
        println!("{occlusion:?}: shows through {shows} of {hidden} hidden pixels, lost in {lost} of {open}");
        assert!(hidden > 300 && open > 800, "{hidden}, {open}");
        [f64::from(shows) / f64::from(hidden), f64::from(lost) / f64::from(open)]
    };
    let [shows, lost] = through(Occlusion::None);
    assert!(shows > 0.3 && lost < 0.03, "missing occlusion, as figure 41 shows it: {shows}, {lost}");
    let [shows, lost] = through(Occlusion::Depth);
    assert!(shows < 0.05 && lost < 0.08, "{shows}, {lost}");
}

/// The printed loop takes impostors in the order of the list: it ends at one behind the camera, and a later transparent
/// one erases an earlier one. The order by nearness has neither fault.
#[test]
fn the_printed_order_is_that_of_the_list() {
    let gpu = gpu();
    // The number of pixels that show an impostor.
    let count = |scene: &Scene, order| {
        let seen = see(&gpu, scene, order, Occlusion::None);
        seen.reflection.texels().filter(|t| t[3] > 0.0).count()
    };
    let whole = count(&scene(false), Order::Printed);
    // A second impostor, behind the camera and first in the list: the printed loop ends with it and shows nothing.
    let mut behind = scene(false);
    let back = Impostor { centre: Vec3::new(0.0, 1.5, -20.0), ..behind.impostors[0].clone() };
    behind.impostors.insert(0, back);
    assert_eq!(count(&behind, Order::Printed), 0, "break");
    assert_eq!(count(&behind, Order::Unbroken), whole);
    assert_eq!(count(&behind, Order::Nearest), whole);
    // A transparent impostor in front of the picture's, last in the list: in the printed order it erases the picture.
    let mut before = scene(false);
    let clear = Texture { rgba: vec![0; 256], ..before.textures[1].clone() };
    before.textures.push(clear);
    before.impostors.push(Impostor { centre: CENTRE - Vec3::Z, texture: 2, ..before.impostors[0].clone() });
    let remaining = count(&before, Order::Printed);
    assert!(remaining < whole / 2, "{remaining} of {whole}");
    assert_eq!(count(&before, Order::Nearest), whole);
}

/// At roughness 0.3, a blur by roughness lowers the contrast of neighbouring pixels, a blur by distance lowers it
/// further, and a mirror stays sharp. Without a blur, roughness changes nothing, as published.
#[test]
fn a_blur_widens_with_roughness_and_with_the_way_from_the_viewer() {
    let gpu = gpu();
    let scene = scene(false);
    let view = camera(Vec3::new(0.3, 1.6, 0.2), Vec3::new(0.0, 0.6, 5.0), EXTENT);
    let image = |blur, roughness| {
        let setup = Setup::new(EXTENT).with(|p: &mut BillboardParams| {
            (p.billboard_order, p.billboard_blur) = (Order::Nearest, blur);
        });
        let globals = Globals { roughness: Some(roughness), ..Globals::default() };
        show(&gpu, &scene, view, "billboard", &setup, &globals).get("reflection").clone()
    };
    // The mean difference of neighbouring pixels in a row, which falls where the picture is blurred.
    let contrast = |pixels: &Pixels| {
        let texels: Vec<_> = pixels.texels().collect();
        let pairs = texels.windows(2).filter(|p| p[0][3] > 0.0 && p[1][3] > 0.0);
        let differences: Vec<f32> = pairs.map(|p| (0..3).map(|c| (p[0][c] - p[1][c]).abs()).sum()).collect();
        differences.iter().sum::<f32>() / differences.len() as f32
    };
    let sharp = image(Blur::None, 0.3);
    assert_eq!(sharp, image(Blur::None, 0.0), "as published, roughness has no say");
    for blur in [Blur::Roughness, Blur::Distance] {
        assert_eq!(sharp, image(blur, 0.0), "{blur:?}: a mirror is a mirror");
    }
    let [none, roughness, distance] = [Blur::None, Blur::Roughness, Blur::Distance].map(|b| contrast(&image(b, 0.3)));
    println!("contrast {none}, by roughness {roughness}, by distance {distance}");
    assert!(roughness < 0.8 * none && distance < 0.9 * roughness, "{none}, {roughness}, {distance}");
}

/// Renders a scene by `billboard` with a glow, of a strength and a width in metres. Returns the reflection.
///
/// For each pixel, it also returns how far the mirror ray passes beyond the picture's edges in the picture's plane: [in
/// x, in y, in all], in metres. x and y are signed, and all are 0 inside the picture. `None` means that no ray meets
/// that plane ahead.
fn glowing(gpu: &Gpu, scene: &Scene, occlusion: Occlusion, glow: (f32, f32)) -> (Pixels, Vec<Option<[f64; 3]>>) {
    let Truth { reflection, first_hits, .. } = shown_with(gpu, scene, |p| {
        (p.billboard_order, p.billboard_occlusion) = (Order::Nearest, occlusion);
        (p.billboard_glow, p.billboard_glow_width) = glow;
    });
    let distances_beyond = |receiver: &Receiver| {
        let direction = receiver.mirror();
        let t = (f64::from(CENTRE.z) - receiver.position.z) / direction.z;
        let from_centre = receiver.position + t * direction - CENTRE.as_dvec3();
        let beyond = |v: f64, half: f32| v.signum() * (v.abs() - f64::from(half)).max(0.0);
        let (x, y) = (beyond(from_centre.x, HALF_U.x), beyond(from_centre.y, -HALF_V.y));
        (direction.z > 0.0).then(|| [x, y, x.hypot(y)])
    };
    (reflection, first_hits.receivers.iter().map(|r| r.as_ref().and_then(distances_beyond)).collect())
}

/// The glow of a picture of one colour equals strength · (1 − distance / width)² · colour outside the edges, within
/// 0.002, and nothing changes inside them. The bound covers 16-bit floats and single-precision rays.
#[test]
fn a_glow_fades_beyond_the_edges_of_a_billboard() {
    let gpu = gpu();
    // An image of one colour, so that all its levels are equal.
    let mut even = scene(false);
    even.textures[1].rgba = [255, 188, 0, 255].repeat(64);
    let picture_color = Vec3::new(1.0, ssct_ground::math::srgb_to_linear(188.0 / 255.0), 0.0);
    let (strength, width) = (0.5, 0.75);
    let (plain, _) = glowing(&gpu, &even, Occlusion::None, (0.0, width));
    let (lit, distance) = glowing(&gpu, &even, Occlusion::None, (strength, width));
    let (mut inside, mut glows) = (0, 0);
    for ((plain, lit), distance) in plain.texels().zip(lit.texels()).zip(&distance) {
        let color_found = Vec3::from_slice(lit);
        let Some([.., distance]) = distance else {
            assert_eq!(plain, lit, "no ray meets the plane");
            continue;
        };
        // The device's rays are of single precision: pixels whose ray passes within a millimetre of an edge are left
        // out.
        if *distance == 0.0 && plain[3] == 1.0 {
            inside += 1;
            assert_eq!(plain, lit, "the image itself is as it was");
        } else if *distance > 1e-3 {
            let reach = (1.0 - *distance as f32 / width).max(0.0);
            let expected = strength * reach * reach * picture_color;
            assert!(
                (color_found - expected).abs().max_element() < 2e-3,
                "{distance} m off: {color_found}, not {expected}"
            );
            assert_eq!(lit[3] > 0.0, color_found != Vec3::ZERO, "{lit:?}");
            glows += usize::from(reach > 0.0);
        }
    }
    println!("{inside} pixels show the picture, {glows} its glow");
    assert!(inside > 1000 && glows > 500, "{inside}, {glows}");
    gpu.check_validation().unwrap();
}

/// The glow is red on the left of the picture and green on its right, as the nearest edge is. With occlusion by depth,
/// the blue block hides the glow of a pixel wholly or not at all.
#[test]
fn a_glow_has_the_colours_of_the_edge_that_is_near_and_is_hidden_with_occlusion() {
    let gpu = gpu();
    let (mut red, mut green, mut kept, mut hidden) = (0, 0, 0, 0);
    let (open, distance) = glowing(&gpu, &scene(true), Occlusion::None, (1.0, 0.75));
    let (occluded, _) = glowing(&gpu, &scene(true), Occlusion::Depth, (1.0, 0.75));
    for ((open, occluded), distance) in open.texels().zip(occluded.texels()).zip(&distance) {
        let Some([x, y, distance]) = distance else { continue };
        if (0.01..0.3).contains(&x.abs()) && *y == 0.0 {
            let is_red = open[0] > open[1];
            assert_eq!(is_red, *x < 0.0, "{x} m off: {open:?}");
            (red, green) = (red + usize::from(is_red), green + usize::from(!is_red));
        }
        if *distance > 0.01 && open[0] + open[1] > 0.02 {
            let is_same = open == occluded;
            assert!(is_same || occluded[0] + occluded[1] < 1e-6, "{distance} m off: {open:?} became {occluded:?}");
            (kept, hidden) = (kept + usize::from(is_same), hidden + usize::from(!is_same));
        }
    }
    println!("{red} red, {green} green; occlusion hides {hidden}, and leaves {kept}");
    assert!(red > 30 && green > 30 && hidden > 10 && kept > 300, "{red}, {green}; {hidden}, {kept}");
}
