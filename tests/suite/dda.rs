//! Compares `dda` with the exact oracle: where its hits lie, how refinement and jitter move them, and that no size and
//! no ray breaks it.

use crate::common::{Builder, camera, clutter, clutter_camera, gpu, show, unfaded};
use glam::Vec3;
use ssct::gpu::Pixels;
use ssct::methods::dda::DdaParams;
use ssct::methods::{Setup, Wants, find};
use ssct::passes::PathCode;
use ssct_lab::stage::gbuffer::{self, hit_positions};
use ssct_lab::stage::{Globals, Shot, Stage};
use ssct_scenes::{Camera, Scene, View};
use ssct_truth::metrics::HitAgreement;
use ssct_truth::reference::{Oracle, Outcome};

/// The place of the camera, in metres.
const EYE: Vec3 = Vec3::new(0.0, 1.2, 0.0);
/// The wall stands at this z, in metres.
const WALL_Z: f32 = 6.0;
/// Size of the image in pixels.
const EXTENT: [u32; 2] = [321, 239];

/// Returns a mirror floor that ends at a wall. The wall reaches below the floor, so that no gap lies between them.
fn floor_and_wall() -> Scene {
    let mut b = Builder::new("floor and wall");
    b.light(Vec3::Z);
    let picture = b.picture(64, 64, |x, y| [(4 * x) as u8, (4 * y) as u8, 128]);
    b.quad(picture, Vec3::new(-12.0, -1.0, WALL_Z), Vec3::X * 24.0, Vec3::Y * 12.0, -Vec3::Z);
    let mirror = b.mirror();
    b.quad(mirror, Vec3::new(-12.0, 0.0, 0.0), Vec3::X * 24.0, Vec3::Z * WALL_Z, Vec3::Y);
    b.0
}

/// Returns a mirror that faces the camera, between a floor and a ceiling. Its rays come back towards the camera.
fn facing_mirror() -> Scene {
    let mut b = Builder::new("facing mirror");
    b.light(Vec3::Y);
    let mirror = b.mirror();
    b.quad(mirror, Vec3::new(-3.0, 0.0, 6.0), Vec3::X * 6.0, Vec3::new(0.0, 2.4, 0.4), -Vec3::Z);
    let gray = b.matt(Vec3::splat(0.5));
    b.quad(gray, Vec3::new(-6.0, 0.0, 0.5), Vec3::X * 12.0, Vec3::Z * 8.0, Vec3::Y);
    b.quad(gray, Vec3::new(-6.0, 3.0, 0.5), Vec3::X * 12.0, Vec3::Z * 8.0, -Vec3::Y);
    b.0
}

/// Returns a camera that looks along the z axis.
fn looks_ahead(extent: [u32; 2]) -> Camera {
    camera(EYE, EYE + Vec3::Z, extent)
}

/// Returns a setup without fade, with changed parameters of `dda`.
fn setup(extent: [u32; 2], change: impl FnOnce(&mut DdaParams)) -> Setup {
    unfaded(extent).with(change)
}

/// Renders a scene by `dda`. Returns the image of the hits, and how they agree with the oracle on the same G-buffer.
fn judged(scene: &Scene, camera: Camera, setup: &Setup) -> (Pixels, HitAgreement) {
    let gpu = gpu();
    let mut stage = Stage::new(&gpu, scene).unwrap();
    let materials = Globals::default().materials(scene, &View::default());
    let shot = Shot::new(&mut stage, find("dda").unwrap(), setup, Wants::HITS, camera, materials).unwrap();
    let (_, _, output) = stage.output(&shot).unwrap();
    let hits = stage.context.read(output.traced.hits.unwrap().0.all()).unwrap();
    let data = gbuffer::read(&mut stage.context, &shot).unwrap();
    let oracle = Oracle::new(&data);
    let reflects: Vec<_> = (0..data.depth.len()).map(|i| data.reflects(i)).collect();
    let truth: Vec<_> = (0..data.depth.len() as u32)
        .map(|i| match oracle.trace(i % data.width, i / data.width).outcome {
            Outcome::Hit { position, .. } => Some([position.x, position.y]),
            _ => None,
        })
        .collect();
    let agreement = HitAgreement::new(&reflects, &hit_positions(&hits), &truth);
    gpu.check_validation().unwrap();
    (hits, agreement)
}

/// With a stride of 1 and no jitter, over 99 % of the hits agree with the oracle, and half of them lie within 0.75
/// pixels. An error of the march's start or of its step would shift them. Two sizes are tried, with and without
/// refinement.
#[test]
fn a_sample_a_pixel_ends_where_the_oracle_says() {
    for extent in [[512, 256], EXTENT] {
        for refine in [false, true] {
            let plain = setup(extent, |p| (p.dda_stride, p.dda_jitter, p.dda_refine) = (1, false, refine));
            let (_, agreement) = judged(&floor_and_wall(), looks_ahead(extent), &plain);
            println!("{extent:?}, refined {refine}: {agreement:?}");
            assert!(agreement.pixels > 10_000 && agreement.hit_agreement.unwrap() > 0.99, "{agreement:?}");
            assert!(agreement.hit_error_px_p50.unwrap() < 0.75, "{agreement:?}");
        }
    }
}

/// With a stride of 16, refinement divides the median error of hits by more than 4, and raises the share of agreeing
/// hits by more than 0.3, with jitter and without.
#[test]
fn refinement_brings_hits_nearer() {
    for jitter in [false, true] {
        let [plain, refined] = [false, true].map(|refine| {
            let setup = setup(EXTENT, |p| (p.dda_stride, p.dda_jitter, p.dda_refine) = (16, jitter, refine));
            judged(&floor_and_wall(), looks_ahead(EXTENT), &setup).1
        });
        println!("jitter {jitter}: {plain:?}, refined {refined:?}");
        assert!(refined.hit_error_px_p50.unwrap() < 0.25 * plain.hit_error_px_p50.unwrap(), "{plain:?} {refined:?}");
        assert!(refined.hit_agreement.unwrap() > plain.hit_agreement.unwrap() + 0.3, "{plain:?} {refined:?}");
    }
}

/// Two runs with jitter give equal hits, so that images do not flicker. In over 90 % of neighbouring pixels of two
/// columns, jitter moves the hits apart by more than 1.5 pixels; without jitter all are closer than 0.5.
#[test]
fn jitter_is_the_same_in_every_frame_and_not_in_neighbours() {
    let hits = |jitter| {
        let setup = setup(EXTENT, |p| (p.dda_stride, p.dda_jitter, p.dda_refine) = (16, jitter, false));
        judged(&floor_and_wall(), looks_ahead(EXTENT), &setup).0
    };
    let (jittered, again, plain) = (hits(true), hits(true), hits(false));
    assert_eq!(jittered, again);
    // The floor's rays go straight up the screen from the middle column on, so that without jitter neighbours in a row
    // end in the same row. With it, they end as far apart as the pattern shifts them: by an eighth of a stride or more.
    let row_distances = |hits: &Pixels| {
        let x = EXTENT[0] / 2;
        let is_hit = |t: &[f32]| PathCode::from_channel(t[3]).unwrap().is_hit();
        let pairs =
            (0..EXTENT[1]).map(|y| (hits.texel(x, y), hits.texel(x + 1, y))).filter(|(a, b)| is_hit(a) && is_hit(b));
        pairs.map(|(a, b)| (a[1] - b[1]).abs() * EXTENT[1] as f32).collect::<Vec<_>>()
    };
    let (jittered_distances, plain_distances) = (row_distances(&jittered), row_distances(&plain));
    assert!(jittered_distances.len() > 50 && plain_distances.len() > 50);
    assert!(plain_distances.iter().all(|d| *d < 0.5), "{plain_distances:?}");
    let differ = jittered_distances.iter().filter(|d| **d > 1.5).count();
    assert!(differ * 10 > jittered_distances.len() * 9, "{differ} of {}", jittered_distances.len());
}

/// At tiny and odd sizes, strides and thicknesses, in three scenes, no value is infinite or NaN. No ray exhausts its
/// steps, and each hit lies on the screen. Rays that run into the camera or along an axis divide by numbers near 0.
#[test]
fn no_size_and_no_ray_breaks_the_march() {
    let gpu = gpu();
    for extent in [[1, 1], [1, 37], [127, 61]] {
        for stride in [1, 4, 16] {
            for (scene, view) in [
                (clutter(), clutter_camera(extent)),
                (facing_mirror(), looks_ahead(extent)),
                // The camera looks straight down on the floor, so that rays run back into the camera.
                (floor_and_wall(), camera(Vec3::new(0.0, 1.2, 3.0), Vec3::new(0.0, 0.0, 3.001), extent)),
            ] {
                for (jitter, refine, thickness) in [(false, false, 0.0), (true, true, 0.25), (true, false, 1000.0)] {
                    let setup = setup(extent, |p| {
                        (p.dda_stride, p.dda_jitter, p.dda_refine) = (stride, jitter, refine);
                        p.dda_thickness = thickness;
                    });
                    let case = format!("{extent:?}, {}, stride {stride}, thickness {thickness}", scene.name);
                    let shown = show(&gpu, &scene, view, "dda", &setup, &Globals::default());
                    for name in ["reflection", "hits", "composite"] {
                        assert!(shown.get(name).texels().flatten().all(|v| v.is_finite()), "{case}: {name}");
                    }
                    for t in shown.get("hits").texels() {
                        let code = PathCode::from_channel(t[3]).unwrap();
                        assert!(!code.is_exhausted(), "{case}");
                        let is_on_screen = t[..3].iter().all(|v| (0.0..=1.0).contains(v));
                        assert!(if code.is_hit() { is_on_screen } else { t[..3] == [-1.0; 3] }, "{case}: {t:?}");
                    }
                }
            }
        }
    }
}

/// On a mirror that faces the camera, over 90 % of the hits agree with the oracle. Such rays must end before the near
/// plane, where the projection turns them round.
#[test]
fn rays_towards_the_camera_are_traced_and_end_where_the_oracle_says() {
    let exact = setup(EXTENT, |p| (p.dda_stride, p.dda_jitter) = (1, false));
    let (_, agreement) = judged(&facing_mirror(), looks_ahead(EXTENT), &exact);
    println!("{agreement:?}");
    assert!(agreement.pixels > 5_000 && agreement.hit_agreement.unwrap() > 0.9, "{agreement:?}");
}

/// With 4 steps only, most rays end with the code of an exhausted march and reflect black, while short rays still hit.
/// An exhausted ray must not pass for a hit or a miss.
#[test]
fn a_march_without_enough_steps_says_so_and_misses() {
    let short = setup(EXTENT, |p| (p.dda_stride, p.dda_steps) = (1, 4));
    let shown = show(&gpu(), &floor_and_wall(), looks_ahead(EXTENT), "dda", &short, &Globals::default());
    let (mut exhausted, mut hits) = (0, 0);
    for (hit, color) in shown.get("hits").texels().zip(shown.get("reflection").texels()) {
        let code = PathCode::from_channel(hit[3]).unwrap();
        exhausted += usize::from(code == PathCode::LinearExhausted);
        hits += usize::from(code == PathCode::Linear);
        assert!(code.is_hit() || color == [0.0; 4]);
    }
    println!("{exhausted} exhausted, {hits} hits");
    assert!(exhausted > 10_000 && hits > 100, "{exhausted} {hits}");
}
