//! Tests that every method makes the same images with its passes in fragment and in compute shaders (`--stage`), to the
//! bit and by passes of the same names. In compute shaders, no pass over the whole image is drawn. `unified_stages`
//! tests `unified` with stages of its own.

use crate::common::engine::bits;
use crate::common::{
    built_in, check_validation, clutter, clutter_camera, gpu, is_gpu_assisted, values, with_small_captures,
};
use glam::Vec3;
use ssct::gpu::FrameReport;
use ssct::gpu::frame::Mode;
use ssct::gpu::timing::PassWork;
use ssct::methods::ibr::{self, IbrParams};
use ssct::methods::layers::LayerParams;
use ssct::methods::planar::{self, PlanarParams};
use ssct::methods::setup::{HistoryUse, Stage as ShaderStage};
use ssct::methods::ssct::ThesisDrawing;
use ssct::methods::sslr::SslrParams;
use ssct::methods::ssr_fast::SsrFastParams;
use ssct::methods::stochastic::{self, StochasticParams};
use ssct::methods::{EffectParams, Fallback, METHODS, MethodInfo, Setup, Wants, hzct, poster, ssct as thesis, sslr};
use ssct::methods::{dda, ssr, ssr_fast};
use ssct::passes::color_chain::{ChainFilter, ChainMask};
use ssct::passes::mask_chain::MaskFilter;
use ssct::passes::trace_normals::TraceNormals;
use ssct_ground::parameter::{Preset, Value};
use ssct_lab::stage::image::render;
use ssct_lab::stage::{Globals, Shot, Stage};
use ssct_lab::study::sweep;
use ssct_scenes::{Camera, Capture, Material, Scene, View};
use std::collections::{BTreeMap, HashSet};

/// The bits of a frame's images by their names, its passes, and what the device counted in each.
struct MadeFrame {
    images: BTreeMap<String, Vec<u32>>,
    passes: Vec<String>,
    work: Vec<(String, PassWork)>,
}

/// The stage of the laboratory, which holds the scene, with the camera and the materials of the frames.
struct Place<'s> {
    stage: &'s mut Stage,
    camera: Camera,
    materials: &'s [Material],
}

/// Makes a frame with every intermediate image. If the setup's stage is compute shaders, another frame counts the work
/// of each pass.
fn make(place: &mut Place, method: &MethodInfo, setup: &Setup, wants: Wants) -> MadeFrame {
    let Place { stage, camera, materials } = place;
    let shot = Shot::new(stage, method, setup, wants, *camera, materials.to_vec()).unwrap();
    let image = render(stage, &shot, true).unwrap();
    let passes = image.report.recorded.clone();
    let images = image.intermediates.unwrap().into_iter().map(|(name, _, pixels)| (name, bits(&pixels))).collect();
    let is_counted = setup.effect().stage == ShaderStage::Compute;
    let counted = if is_counted { stage.run(&shot, Mode::Counted).unwrap().0 } else { FrameReport::default() };
    MadeFrame { images, passes, work: counted.recorded.into_iter().zip(counted.work).collect() }
}

/// Returns whether a pass may draw even in the compute stage: it copies, draws the scene, or marks a stencil.
fn is_drawn_anyway(pass: &str) -> bool {
    // A blur has a pass for each direction, such as "color/1h".
    let is_blur = |rest: &str| rest.strip_suffix(['h', 'v']).is_some_and(|level| level.parse::<u32>().is_ok());
    let is_blit = |folder: &str| pass.rsplit_once(folder).is_some_and(|(_, rest)| !is_blur(rest));
    let copies = ["color/", "filter/", "blur/"].into_iter().any(is_blit);
    let scene = ["g-buffer", "mirror mark", "capture/lighting"].into_iter().any(|part| pass.contains(part));
    copies || scene || pass == "lighting" || pass.ends_with("/encode")
}

/// Checks that a method's images and passes in compute shaders equal those in fragment shaders. Returns 1 if the
/// reflection shows something, else 0.
fn check_same(place: &mut Place, method: &MethodInfo, setup: &Setup, wants: Wants) -> usize {
    let [drawn, stored] = [ShaderStage::Fragment, ShaderStage::Compute]
        .map(|stage| make(place, method, &setup.with(|p: &mut EffectParams| p.stage = stage), wants));
    let case = format!("{}, {setup:?}, {wants:?}", method.name);
    assert_eq!(drawn.images.keys().collect::<Vec<_>>(), stored.images.keys().collect::<Vec<_>>(), "{case}");
    for ((name, expected), found) in drawn.images.iter().zip(stored.images.values()) {
        let differing: Vec<_> = found.iter().zip(expected).enumerate().filter(|(_, (a, b))| a != b).collect();
        let first = differing.first().map(|(i, (a, b))| (i, f32::from_bits(**a), f32::from_bits(**b)));
        assert!(
            found.len() == expected.len() && differing.is_empty(),
            "{case}, {name}: {} numbers differ, the first: {first:?}",
            differing.len()
        );
    }
    let without_encoding =
        |passes: &[String]| passes.iter().filter(|p| !p.ends_with("/encode")).cloned().collect::<Vec<_>>();
    assert_eq!(without_encoding(&stored.passes), drawn.passes, "{case}");
    for (pass, work) in &stored.work {
        assert!(work.fragment_invocations == 0 || is_drawn_anyway(pass), "{case}: the pass {pass} is drawn: {work:?}");
    }
    let is_empty = |name: &str| drawn.images[name].iter().all(|word| *word == 0);
    usize::from(!is_empty("reflection"))
}

/// Returns setups of a method, each with the wanted images, that together run all of its programs.
fn setups(method: &MethodInfo, extent: [u32; 2]) -> Vec<(Setup, Wants)> {
    let usual = if method.is_screen_space() { Setup::on_screen(extent) } else { Setup::new(extent) };
    let usual = with_small_captures(&usual);
    let mut setups: Vec<(Setup, Wants)> = sweep::setups(method, &usual)
        .into_iter()
        .chain([usual.of_preset(Preset::Author)])
        .map(|s| (s, Wants::REFLECTION))
        .collect();
    setups.push((usual.clone(), Wants::HITS));
    if [thesis::INFO.name, hzct::INFO.name].contains(&method.name) {
        for mask in [ChainMask::None, ChainMask::Covered, ChainMask::Surface] {
            let set = |p: &mut ThesisDrawing| {
                (p.split, p.hi_z_maximum, p.chain_filter, p.chain_mask) = (true, true, ChainFilter::Gaussian, mask);
            };
            setups.push((usual.with(set), Wants::HITS));
        }
    }
    if method.name == sslr::INFO.name {
        setups.push((usual.with(|p: &mut SslrParams| p.mask_filter = MaskFilter::Hardware), Wants::HITS));
    }
    if [poster::INFO.name, ssr::INFO.name, ssr_fast::INFO.name, dda::INFO.name].contains(&method.name) {
        let layered = usual.with(|p: &mut LayerParams| p.layers = 2);
        let blurred = |p: &mut SsrFastParams| (p.distance_blur, p.chain_filter) = (true, ChainFilter::Gaussian);
        setups.push((layered.with(blurred), Wants::HITS));
    }
    // The two kinds of shader read numbers by the same code, so that one value of each is enough.
    let mut seen = HashSet::new();
    setups.retain(|(setup, wants)| {
        let choices = values(method, setup, |value| matches!(value, Value::Switch(_) | Value::Choice(_)));
        seen.insert((choices, wants.hits))
    });
    if method.name == planar::INFO.name {
        setups.push((usual.with(|p: &mut PlanarParams| p.planar_planes = 4), Wants::REFLECTION));
    }
    if method.name == ibr::INFO.name {
        setups.push((usual.with(|p: &mut IbrParams| p.ibr_depth = 2.0), Wants::REFLECTION));
    }
    if method.name == stochastic::INFO.name {
        setups.push((usual.with(|p: &mut StochasticParams| p.stochastic_rays = 4), Wants::REFLECTION));
    }
    setups
}

/// Returns setups of the effect around a screen-space method: fallbacks, half resolution, bounces, other normals, and a
/// history.
fn effect_setups(extent: [u32; 2]) -> Vec<Setup> {
    let changes: [fn(&mut EffectParams); 7] = [
        |p| p.fallback = Fallback::Environment,
        |p| (p.fallback, p.resolution_scale) = (Fallback::Pccm, 0.5),
        |p| p.fallback = Fallback::Captures,
        |p| p.fallback = Fallback::Planar,
        |p| p.bounces = 2,
        |p| (p.trace_normals, p.bump_after) = (TraceNormals::Geometric, 0.2),
        |p| (p.history, p.history_frames) = (HistoryUse::On, 3),
    ];
    changes.map(|change| Setup::on_screen(extent).with(change)).to_vec()
}

/// Returns whether a method has the parameter `stage` and is not `unified`, which has stages of its own.
fn has_one_stage(method: &&MethodInfo) -> bool {
    method.name != "unified" && method.read_parameters().iter().any(|p| p.name == "stage")
}

/// Every method with each of its settings, at four sizes, makes equal images in both kinds of shader, without a message
/// of the validation layers. A workgroup that misses a row at the border, or arithmetic that a compiler rounds
/// otherwise, would differ.
#[test]
fn every_method_makes_the_same_images_in_either_stage() {
    let gpu = gpu();
    let scene = clutter();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let materials = Globals { roughness: Some(0.2), ..Globals::default() }.materials(&scene, &View::default());
    let mut shown = BTreeMap::new();
    // An instrumented shader compiles for half a minute. A driver may compile each shader anew for a side that is a
    // power of two. Only two sizes have such a side: one column, and one texel, whose chains have one level.
    let sizes = if is_gpu_assisted() { &[[33, 18]][..] } else { &[[29, 19], [24, 24], [1, 9], [1, 1]] };
    for (n, extent) in sizes.iter().enumerate() {
        let mut place = Place { stage: &mut stage, camera: clutter_camera(*extent), materials: &materials };
        for method in METHODS.iter().filter(has_one_stage) {
            let setups = setups(method, *extent);
            // The other sizes test how workgroups cover an image and its chain, for which one setup is enough.
            let tried = if n == 0 && !is_gpu_assisted() { &setups[..] } else { &setups[setups.len() - 1..] };
            for (setup, wants) in tried {
                *shown.entry(method.name).or_insert(0) += check_same(&mut place, method, setup, *wants);
                check_validation(&gpu).unwrap_or_else(|e| panic!("{}, {setup:?}: {e}", method.name));
            }
        }
    }
    // Three methods may show nothing, since the scene has no place for a capture, and no probe.
    let may_show_nothing = |name: &str| ["captures", "local-map", "pccm"].contains(&name);
    assert!(shown.iter().all(|(name, lit)| *lit > 0 || may_show_nothing(name)), "{shown:?} images show something");
}

/// Fallbacks, half resolution, bounces, bumps and a history around a method make equal images in both kinds of
/// shader, and so do methods that see the scene. These passes have compute programs of their own, which could differ
/// from the drawn ones.
#[test]
fn what_stands_around_a_method_makes_the_same_images_in_either_stage() {
    let gpu = gpu();
    let mut scene: Scene = built_in("rooms");
    let view = scene.view("corridor").unwrap().clone();
    scene.captures = vec![Capture { resolution: 33, ..Capture::placed_at(view.eye + 0.2 * Vec3::Y) }];
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let materials = Globals { roughness: Some(0.2), ..Globals::default() }.materials(&scene, &view);
    let extent = [67, 38];
    let mut place = Place { stage: &mut stage, camera: view.camera(&scene, extent), materials: &materials };
    for (n, setup) in effect_setups(extent).iter().enumerate() {
        // Passes around a method do not depend on the method, so that one setup alone is tried with three methods.
        let methods = [&thesis::INFO, &sslr::INFO, &dda::INFO];
        for method in &methods[..if n == 1 { 3 } else { 1 }] {
            assert_eq!(check_same(&mut place, method, setup, Wants::REFLECTION), 1, "{setup:?}");
        }
        check_validation(&gpu).unwrap_or_else(|e| panic!("{setup:?}: {e}"));
    }
    let captured =
        Setup::new(extent).with(|p: &mut EffectParams| p.captures = ssct::methods::setup::CaptureCount::Auto);
    let sees_scene = |m: &&MethodInfo| has_one_stage(m) && !m.is_screen_space() && m.unmet_needs(&scene).is_empty();
    for method in METHODS.iter().filter(sees_scene) {
        assert_eq!(check_same(&mut place, method, &captured, Wants::REFLECTION), 1, "{}", method.name);
        check_validation(&gpu).unwrap_or_else(|e| panic!("{}: {e}", method.name));
    }
}
