//! Tests that `unified` in fragment and in compute shaders (`--trace-stage`, `--resolve-stage`, `--history-stage`)
//! makes the same images, to the bit and in passes of the same names.

use crate::common::engine::{Engine, ForeignGBuffer, NATIVE, bits, info, view_of_rooms};
use crate::common::{check_validation, gpu, is_gpu_assisted};
use crate::gloss_twin::{mixed, noise, rooms};
use glam::Vec3;
use ssct::gpu::frame::Mode;
use ssct::gpu::{FrameContext, Gpu};
use ssct::methods::setup::StageChoice::{self, Compute, Fragment};
use ssct::methods::setup::{BeyondScreen, HistoryUse};
use ssct::methods::unified::{FirstTraced, HitColor, UnifiedParams};
use ssct::methods::{EffectParams, Fallback, Input, Setup, Wants, unified};
use ssct::passes::gbuffer::GBufferImages;
use ssct::passes::pyramid::PyramidPass;
use ssct::passes::{GBuffer, Reflectors};
use ssct::{Reflections, ReflectionsInfo};
use ssct_ground::math::OracleVersion::{self, V1, V2};
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{Camera, Capture, GBufferData, Scene};

/// The kinds of shader of the passes that trace and of the passes that gather. Each pair must make the images of the
/// first pair. The last two pairs run the programs of the first two, and hand images from one kind to the other.
const STAGES: [[StageChoice; 2]; 4] = [[Fragment; 2], [Compute; 2], [Compute, Fragment], [Fragment, Compute]];

/// Number of pairs, from the first on, in which all passes have one kind of shader. Most cases try these alone.
const UNMIXED: usize = 2;

/// The images of a frame, as bits by their names, and the passes that the frame recorded.
struct MadeFrame {
    images: Vec<(&'static str, Vec<u32>)>,
    passes: Vec<String>,
}

/// Returns the setup with the kinds of shader for tracing and for gathering. A history has the kind of gathering.
fn in_stages(setup: &Setup, stages: [StageChoice; 2]) -> Setup {
    let setup = setup.with(|p: &mut UnifiedParams| [p.trace_stage, p.resolve_stage] = stages);
    setup.with(|p: &mut EffectParams| p.history_stage = stages[1])
}

/// Checks that the images and the passes of the first `pairs` pairs of stages equal those of fragment shaders.
fn check_same(case: &str, pairs: usize, mut make: impl FnMut([StageChoice; 2]) -> MadeFrame) {
    let MadeFrame { images: expected, passes } = make(STAGES[0]);
    // Compiling an instrumented shader takes half a minute.
    let tried = &STAGES[1..if is_gpu_assisted() { UNMIXED } else { pairs }];
    for stages in tried {
        let MadeFrame { images: found, passes: recorded } = make(*stages);
        assert_eq!(found.len(), expected.len(), "{case}, {stages:?}");
        for ((name, found), (_, expected)) in found.iter().zip(&expected) {
            let differing: Vec<_> = found.iter().zip(expected).enumerate().filter(|(_, (a, b))| a != b).collect();
            let first = differing.first().map(|(i, (a, b))| (i, f32::from_bits(**a), f32::from_bits(**b)));
            assert!(
                found.len() == expected.len() && differing.is_empty(),
                "{case}, {stages:?}, {name}: {} numbers differ, the first: {first:?}",
                differing.len()
            );
        }
        // A compute program has no attachment that is cleared along with it: a pass of its own clears the hits.
        let is_clear = |pass: &&String| **pass == "hits" || pass.ends_with("/hits");
        let without_clears = |passes: &[String]| passes.iter().filter(|p| !is_clear(p)).cloned().collect::<Vec<_>>();
        assert_eq!(without_clears(&recorded), without_clears(&passes), "{case}, {stages:?}");
    }
}

/// Returns the images that a frame of the method alone makes of a G-buffer, and its passes. `reflectors` says which
/// kinds of reflector the frame may have.
fn alone(
    gpu: &Gpu,
    images: &GBufferImages,
    (camera, reflectors): (&Camera, Reflectors),
    (setup, wants): (&Setup, Wants),
) -> MadeFrame {
    let method = unified::INFO.make_alone(gpu, setup, wants).unwrap();
    let mut context = FrameContext::new(gpu).unwrap();
    let mut frame = context.begin(Mode::Plain).unwrap();
    let gbuffer = GBuffer { reflectors, ..images.gbuffer() };
    let output = method.record(&mut frame, &Input::of_screen(gbuffer, camera)).unwrap();
    let report = frame.finish().unwrap();
    let images = [
        ("composite", output.composite),
        ("reflection", output.reflection.map(|r| r.0)),
        ("hits", output.hits.map(|h| h.0)),
    ];
    let read = |(name, image): (_, Option<&ssct::gpu::Image>)| {
        image.map(|image| (name, bits(&context.read(image.level(0)).unwrap())))
    };
    MadeFrame { images: images.into_iter().filter_map(read).collect(), passes: report.recorded }
}

/// Returns sizes of images: with sides of one texel, with odd sides, and with more tiles than a row of workgroups has.
fn sizes() -> Vec<[u32; 2]> {
    let sizes = [[1, 1], [1, 37], [53, 1], [2, 2], [5, 3], [16, 16], [66, 65], [161, 97], [641, 359]];
    sizes.into_iter().filter(|size| !is_gpu_assisted() || [[5, 3], [66, 65]].contains(size)).collect()
}

/// The wanted images, the version of the oracle, and the fallback of each way in which a G-buffer is drawn.
const WAYS: [(Wants, OracleVersion, Fallback); 3] = [
    (Wants::HITS, V1, Fallback::None),
    (Wants::REFLECTION, V2, Fallback::Environment),
    (Wants::IMAGE, V1, Fallback::None),
];

/// Over noise and views at nine sizes, of one roughness and mixed, all pairs of kinds of shader make equal images.
/// Workgroups cover tiles and borders otherwise than drawn squares do.
#[test]
fn over_any_gbuffer_both_stages_make_the_same_images() {
    let gpu = gpu();
    let _compiled = PyramidPass::new(&gpu, [1, 1]).unwrap();
    let mut shown = [0; 2];
    for extent in sizes() {
        let mut cases: Vec<(String, GBufferData, Reflectors)> = Vec::new();
        for (kind, roughness) in [0.0, 0.1, 0.5].into_iter().enumerate() {
            let mut data =
                if extent[0] < 100 { noise(extent) } else { rooms(&gpu, "corridor", extent, roughness, 1.0) };
            data.roughness.fill(half::f16::from_f32(roughness).to_f32());
            let known = Reflectors { mirrors: kind == 0, narrow: kind == 1, wide: kind == 2, everywhere: true };
            cases.push((format!("{extent:?} whole, roughness {roughness}"), data, known));
        }
        for block in [1, 5, 24] {
            let (_, wide_lobes, _) = &cases[2];
            let data = mixed(wide_lobes, block);
            cases.push((format!("{extent:?} over tiles, mixed in blocks of {block}"), data, Reflectors::UNKNOWN));
        }
        // The other sizes test how tiles and workgroups cover an image, for which one way is enough.
        let all_ways = [[5, 3], [66, 65], [161, 97]].contains(&extent) && !is_gpu_assisted();
        let ways = if all_ways { &WAYS } else { &WAYS[..1] };
        for (name, data, reflectors) in &cases {
            let images = GBufferImages::upload(&mut FrameContext::new(&gpu).unwrap(), data).unwrap();
            for (wants, oracle, fallback) in ways {
                let set = |p: &mut EffectParams| (p.oracle, p.fallback) = (*oracle, *fallback);
                let setup = Setup::on_screen(extent).with(set);
                let pairs = if extent == [66, 65] { STAGES.len() } else { UNMIXED };
                check_same(&format!("{name}, {oracle:?}, {fallback:?}, {wants:?}"), pairs, |stages| {
                    let made = alone(&gpu, &images, (&data.camera, *reflectors), (&in_stages(&setup, stages), *wants));
                    let lit =
                        made.images.iter().any(|(name, bits)| *name == "reflection" && bits.iter().any(|b| *b != 0));
                    shown[usize::from(*reflectors == Reflectors::UNKNOWN)] += usize::from(lit);
                    made
                });
                check_validation(&gpu).unwrap_or_else(|e| panic!("{name}: {e}"));
            }
        }
    }
    assert!(shown.iter().all(|n| *n > 20 || is_gpu_assisted()), "{shown:?} images show something");
}

/// Draws a number of frames of the whole effect in a view by its name. Returns the images and passes of the last frame.
/// `roughness` is that of all materials, or `None` for their own.
fn effect(
    stage: &mut Stage,
    (scene, view): (&Scene, &str),
    setup: &Setup,
    (roughness, frames): (Option<f32>, usize),
) -> MadeFrame {
    let view = scene.view(view).unwrap();
    let materials = Globals { roughness, ..Globals::default() }.materials(scene, view);
    let camera = view.camera(scene, setup.extent);
    let shot = Shot::new(stage, &unified::INFO, setup, Wants::HITS, camera, materials).unwrap();
    for _ in 1..frames {
        stage.run(&shot, Mode::Plain).unwrap();
    }
    let (report, _, output) = stage.output(&shot).unwrap();
    let reflection = bits(&gbuffer::reflection(&mut stage.context, &output).unwrap());
    let composite = bits(&stage.context.read(output.composite.level(0)).unwrap());
    let hits = bits(&stage.context.read(output.traced.hits.unwrap().0.all()).unwrap());
    let images = vec![("composite", composite), ("reflection", reflection), ("hits", hits)];
    MadeFrame { images, passes: report.recorded }
}

/// With captures, fallbacks, a history and two bounces in the street, at four roughnesses, all pairs of kinds of shader
/// make equal images. Each of these features adds passes with a program in either stage.
#[test]
fn with_captures_fallbacks_and_histories_both_stages_make_the_same_images() {
    let gpu = gpu();
    let _compiled = PyramidPass::new(&gpu, [1, 1]).unwrap();
    let mut scene = crate::common::built_in("street");
    let eye = scene.view("puddles").unwrap().eye;
    let places = [eye + Vec3::Y, eye - Vec3::new(1.0, 0.0, 2.0)];
    scene.captures = places.map(|place| Capture { resolution: 33, ..Capture::placed_at(place) }).to_vec();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    type Change = fn(&mut EffectParams);
    let cases: [(&str, Change, usize); 5] = [
        ("captures", |p| p.beyond = BeyondScreen::Captures, 1),
        (
            "captures over the environment",
            |p| (p.beyond, p.fallback) = (BeyondScreen::Captures, Fallback::Environment),
            1,
        ),
        ("the environment", |p| p.fallback = Fallback::Environment, 1),
        ("a history", |p| (p.history, p.history_frames) = (HistoryUse::On, 4), 3),
        ("two bounces", |p| p.bounces = 2, 1),
    ];
    let case_count = if is_gpu_assisted() { 1 } else { cases.len() };
    for (name, change, frames) in &cases[..case_count] {
        for roughness in [None, Some(0.0), Some(0.1), Some(0.5)] {
            let setup = Setup::on_screen([127, 61]).with(change);
            // The street's own materials have all kinds of lobes.
            let pairs = if roughness.is_none() { STAGES.len() } else { UNMIXED };
            check_same(&format!("{name}, roughness {roughness:?}"), pairs, |stages| {
                let made = effect(&mut stage, (&scene, "puddles"), &in_stages(&setup, stages), (roughness, *frames));
                let follows = made.passes.iter().any(|pass| pass.starts_with("follow"));
                assert_eq!(follows, name.starts_with("captures"), "{:?}", made.passes);
                made
            });
            check_validation(&gpu).unwrap_or_else(|e| panic!("{name}: {e}"));
        }
    }
}

/// With rays that go on among triangles, and with either source of hit colours, all pairs of kinds of shader make equal
/// images. Tracing hands each lost ray to another pass, whose list either stage writes.
#[test]
fn among_triangles_both_stages_see_the_same_on_the_screen() {
    let gpu = gpu();
    let scene = crate::common::built_in("street");
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    for hit_color in [HitColor::Triangles, HitColor::Screen] {
        for roughness in [None, Some(0.0), Some(0.1), Some(0.5)] {
            let set = |p: &mut UnifiedParams| (p.first, p.hit_color) = (FirstTraced::Screen, hit_color);
            let setup = Setup::new([127, 61]).with(set);
            let pairs = if roughness.is_none() { STAGES.len() } else { UNMIXED };
            check_same(&format!("{hit_color:?}, roughness {roughness:?}"), pairs, |stages| {
                let made = effect(&mut stage, (&scene, "puddles"), &in_stages(&setup, stages), (roughness, 1));
                let has_chain = made.passes.iter().any(|pass| pass.starts_with("color"));
                assert_eq!(has_chain, hit_color == HitColor::Screen, "{:?}", made.passes);
                made
            });
            check_validation(&gpu).unwrap_or_else(|e| panic!("{hit_color:?}: {e}"));
        }
    }
}

/// Through the interface for engines, parameters choose the kinds of shader, and both make one image. An unknown kind
/// is refused with a sentence, since a default in its place would go unnoticed.
#[test]
fn through_the_door_both_stages_make_the_same_image() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = mixed(&view_of_rooms(&gpu, [97, 61]), 24);
    let theirs = ForeignGBuffer::new(&mut engine, &data, NATIVE);
    let context = engine.context();
    let mut show = |parameters: &[(&str, &str)]| {
        let info = ReflectionsInfo { parameters, ..info(&data, "unified") };
        let mut reflections = Reflections::new(&context, &info)?;
        let recorded = engine.frame(&mut reflections, &theirs.input()).unwrap();
        Ok::<_, ssct::Error>([recorded.composite, recorded.reflection].map(|o| bits(&engine.read(&o.unwrap()))))
    };
    let fragment = show(&[]).unwrap();
    let compute = show(&[("trace-stage", "compute"), ("resolve_stage", "compute")]).unwrap();
    assert!(fragment == compute && fragment[1].iter().any(|b| *b != 0));
    let refused = show(&[("trace-stage", "vertex")]).err().unwrap().to_string();
    assert!(refused.contains("trace-stage") && refused.contains("auto, fragment, compute"), "{refused}");
    gpu.check_validation().unwrap();
}
