//! Compares `planar` with the triangles. On a flat mirror both find what one ray sees: the method by a mirrored camera,
//! the reference by tracing the ray.

use crate::common::{Builder, Shown, Truth, beside_truth, camera, gpu, show};
use glam::Vec3;
use ssct::methods::Setup;
use ssct::methods::planar::PlanarParams;
use ssct::methods::setup::{EffectParams, Fallback};
use ssct::passes::planar::MirrorDrawing;
use ssct_lab::stage::Globals;
use ssct_scenes::{Camera, Scene};

/// Size of the images in pixels.
const EXTENT: [u32; 2] = [321, 239];

/// Returns a mirror that leans forward, coloured boards in front of it, and a red board behind it, which it must not
/// show. A second, smaller mirror stands at its side.
fn scene() -> Scene {
    let mut b = Builder::new("mirrors");
    b.light(Vec3::new(0.3, -0.6, 0.5));
    b.0.lights.push(ssct_scenes::Light::Point { position: Vec3::new(-1.0, 2.0, 2.0), energy: 3.0 });
    let mirror = b.mirror();
    let up = Vec3::new(0.0, 1.0, -0.15).normalize();
    b.quad(mirror, Vec3::new(-2.5, 0.0, 5.0), Vec3::X * 5.0, up * 3.0, Vec3::X.cross(up) * -1.0);
    let side = b.mirror();
    b.quad(side, Vec3::new(3.0, 0.0, 1.5), Vec3::Z * 3.0, Vec3::Y * 2.0, -Vec3::X);
    let red = b.matt(Vec3::new(1.0, 0.0, 0.0));
    b.quad(red, Vec3::new(-4.0, -1.0, 6.5), Vec3::X * 8.0, Vec3::Y * 5.0, -Vec3::Z);
    let floor = b.matt(Vec3::new(0.3, 0.5, 0.4));
    b.quad(floor, Vec3::new(-6.0, -0.01, -3.0), Vec3::X * 12.0, Vec3::Z * 8.0, Vec3::Y);
    for n in 0..5 {
        let board = b.matt(Vec3::new(0.2 * n as f32, 0.9 - 0.15 * n as f32, 0.3 + 0.1 * n as f32));
        let corner = Vec3::new(-2.2 + 0.9 * n as f32, 0.2, 3.6 - 0.5 * n as f32);
        b.quad(board, corner, Vec3::new(0.5, 0.0, 0.2), Vec3::Y * (0.5 + 0.2 * n as f32), Vec3::new(0.2, 0.0, -0.5));
    }
    b.0
}

/// Returns a camera that looks at the mirror, for an image size in pixels.
fn facing_mirror(extent: [u32; 2]) -> Camera {
    camera(Vec3::new(0.3, 1.4, 0.0), Vec3::new(0.5, 1.0, 4.0), extent)
}

/// Returns a setup of `planar` with a kind of drawing and a number of mirrored planes.
fn setup(variant: MirrorDrawing, planes: u32) -> Setup {
    Setup::new(EXTENT).with(|p: &mut PlanarParams| (p.planar_variant, p.planar_planes) = (variant, planes))
}

/// In over 99 % of the pixels of the mirrors, `planar` shows the traced colour within 0.01. Both kinds of drawing give
/// one image; with one plane, the second mirror is black. Without a clip at the mirror, the board behind it would show.
#[test]
fn a_mirror_shows_what_its_rays_meet() {
    let gpu = gpu();
    let scene = scene();
    let mut images = Vec::new();
    for variant in [MirrorDrawing::Stencil, MirrorDrawing::Target] {
        for planes in [1, 2] {
            let setup = setup(variant, planes);
            let Truth { reflection, world: truth, first_hits } =
                beside_truth(&gpu, &scene, facing_mirror(EXTENT), "planar", &setup, &Globals::default());
            // Only the first mirror reflects unless both are mirrored; the second stands to the right of it.
            let (mut mirror_pixels, mut alike, mut lit) = (0, 0, 0);
            for ((texel, truth), receiver) in reflection.texels().zip(&truth).zip(&first_hits.receivers) {
                let Some(receiver) = receiver else {
                    assert_eq!(texel, [0.0; 4], "a reflection where nothing reflects");
                    continue;
                };
                if planes == 1 && receiver.position.x > 2.9 {
                    assert_eq!(texel, [0.0; 4], "the second plane");
                    continue;
                }
                mirror_pixels += 1;
                let error = (Vec3::from_slice(texel) - *truth).abs().max_element();
                alike += u32::from(error < 0.01);
                lit += u32::from(truth.max_element() > 0.0);
                assert!(truth.max_element() == 0.0 || texel[0] < 0.9 || truth.x > 0.8, "the board behind the mirror");
            }
            println!("{variant:?}, {planes}: {alike} of {mirror_pixels} pixels alike, {lit} not black");
            assert!(mirror_pixels > 8_000 && lit > mirror_pixels / 3, "{mirror_pixels}, {lit}");
            // Pixels differ at edges, and where a ray meets the other mirror, which is shown black.
            assert!(f64::from(alike) > 0.99 * f64::from(mirror_pixels), "{variant:?}: {alike} of {mirror_pixels}");
            images.push(reflection.values);
        }
    }
    let [stencil_one, stencil_two, target_one, target_two] = &images[..] else { panic!("four images") };
    assert!(stencil_one == target_one && stencil_two == target_two, "both variants show the same");
    assert!(stencil_one != stencil_two, "the second plane shows");
}

/// With the stencil, the mirrored scene covers fewer than nine tenths of the pixels that it covers without. The stencil
/// changes no image, so that only the work shows that it is used.
#[test]
fn the_stencil_spares_what_the_mirror_does_not_show() {
    let gpu = gpu();
    let scene = scene();
    let drawn = |variant| {
        let setup = setup(variant, 1);
        let shown = show(&gpu, &scene, facing_mirror(EXTENT), "planar", &setup, &Globals::default());
        shown.get("mirrored-normal").texels().filter(|n| n[..3] != [0.0; 3]).count()
    };
    let (stencil, target) = (drawn(MirrorDrawing::Stencil), drawn(MirrorDrawing::Target));
    println!("{stencil} pixels drawn inside the stencil, {target} without");
    assert!(stencil > 4_000 && stencil < target * 9 / 10, "{stencil} of {target}");
}

/// If `planar` is the fallback of `ssct`, it shows exactly its own colour in pixels that `ssct` misses. If only `ssct`
/// shows something, its colour stays.
#[test]
fn as_a_fallback_the_mirror_shows_where_the_screen_does_not() {
    let gpu = gpu();
    let scene = scene();
    let shown = |method, fallback| {
        let setup = Setup::on_screen(EXTENT).with(|p: &mut EffectParams| p.fallback = fallback);
        show(&gpu, &scene, facing_mirror(EXTENT), method, &setup, &Globals::default())
    };
    let mirror = shown("planar", Fallback::None);
    let (alone, over_planar) = (shown("ssct", Fallback::None), shown("ssct", Fallback::Planar));
    let texels = |shown: &Shown| shown.get("reflection").texels().map(<[f32]>::to_vec).collect::<Vec<_>>();
    let (mut missed, mut kept) = (0, 0);
    for ((mirror, alone), shown) in texels(&mirror).iter().zip(texels(&alone)).zip(texels(&over_planar)) {
        if alone[3] == 0.0 {
            assert_eq!(&shown, mirror, "what the screen misses is what the mirror shows, or nothing");
            missed += u32::from(mirror[3] == 1.0);
        } else if mirror[3] == 0.0 {
            assert!((shown[0] - alone[0]).abs() <= 1e-3 && (shown[3] - alone[3]).abs() <= 1e-3, "{shown:?} {alone:?}");
            kept += 1;
        }
    }
    println!("{missed} pixels that the mirror alone shows, {kept} that the screen alone shows");
    assert!(missed > 2_000 && kept > 100, "{missed} {kept}");
}
