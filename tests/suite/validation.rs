//! The validation layers (core, synchronization, best practices; with SSCT_GPU_AV=1 GPU-assisted, too) give no message
//! about any method in any mode, except messages on the allow-list. Each entry of the list is a message that they do
//! give. A hazard in `gpu::validation` shows that the layers listen at all.

use crate::common::{
    check_validation, clutter, clutter_camera, expected_failures, is_gpu_assisted, own_gpu, values, with_small_captures,
};
use ash::vk;
use ssct::gpu::frame::Mode;
use ssct::gpu::memory::MemoryPlace;
use ssct::gpu::programs::Classify;
use ssct::gpu::shader::UnifiedBlock;
use ssct::gpu::validation::{ALLOWED, LAYER};
use ssct::gpu::{Buffer, ComputePipeline, Frame, FrameContext, Image, ImageDesc};
use ssct::methods::linear::LinearParams;
use ssct::methods::poster::PosterParams;
use ssct::methods::setup::{BeyondScreen, StageChoice};
use ssct::methods::ssct::ThesisDrawing;
use ssct::methods::ssr_fast::SsrFastParams;
use ssct::methods::unified::{FirstTraced, HitColor, UnifiedParams};
use ssct::methods::{EffectParams, Fallback, METHODS, MethodInfo, Setup, Wants};
use ssct::passes::PosterFilter;
use ssct::passes::color_chain::ChainFilter;
use ssct::passes::linear_trace::LinearMarch;
use ssct::passes::pyramid::PyramidPass;
use ssct::passes::tiles::ARGUMENT_BYTES;
use ssct_ground::parameter::{Preset, Value};
use ssct_lab::stage::image::render;
use ssct_lab::stage::{Globals, Shot, Stage};
use ssct_lab::study::sweep;
use ssct_scenes::View;
use std::collections::HashSet;

/// Returns the values of a setup that decide which passes and programs a method has.
fn choices(method: &MethodInfo, setup: &Setup) -> Vec<(&'static str, String)> {
    values(method, setup, |value| !matches!(value, Value::Number(_)))
}

/// Returns setups of a method for a size in pixels, with the wanted images. A method that sees the screen alone has all
/// its modes at the middle size, and one setup at the others. All other methods have one setup.
fn setups(method: &MethodInfo, extent: [u32; 2]) -> Vec<(Setup, Wants)> {
    use StageChoice::{Compute, Fragment};
    let usual = if method.is_screen_space() { Setup::on_screen(extent) } else { Setup::new(extent) };
    let usual = with_small_captures(&usual);
    // The modes do not depend on the size, so that only the middle size has all. The largest image is a flat strip,
    // whose chains are as long as those of a whole image.
    if !method.is_screen_space() || extent[0] > 500 || extent == [1, 1] {
        return vec![(usual, Wants::REFLECTION)];
    }
    let mut setups = Vec::new();
    for preset in [Preset::Published, Preset::Author] {
        for (split, wants) in [(false, Wants::REFLECTION), (false, Wants::HITS), (true, Wants::HITS)] {
            for (chain_filter, march, poster_filter) in [
                (ChainFilter::Hardware, LinearMarch::Growing, PosterFilter::Mip),
                (ChainFilter::Gaussian, LinearMarch::Fixed, PosterFilter::Volume),
            ] {
                let setup = usual.of_preset(preset);
                let setup = setup.with(|p: &mut ThesisDrawing| (p.split, p.chain_filter) = (split, chain_filter));
                let setup = setup.with(|p: &mut LinearParams| p.march = march);
                setups.push((setup.with(|p: &mut PosterParams| p.poster_filter = poster_filter), wants));
            }
        }
    }
    let with_effect = |change: &dyn Fn(&mut EffectParams)| usual.with(|p: &mut EffectParams| change(p));
    let blurred =
        with_effect(&|p| p.fallback = Fallback::Environment).with(|p: &mut SsrFastParams| p.distance_blur = true);
    setups.push((blurred, Wants::REFLECTION));
    setups.push((with_effect(&|p| p.fallback = Fallback::Pccm), Wants::REFLECTION));
    setups.push((with_effect(&|p| p.resolution_scale = 0.5), Wants::HITS));
    let has_stages = method.own_parameters().iter().any(|p| p.name == "trace_stage");
    for stages in [[Compute; 2], [Compute, Fragment], [Fragment, Compute]].into_iter().filter(|_| has_stages) {
        for beyond in [BeyondScreen::None, BeyondScreen::Triangles] {
            let setup = with_effect(&|p| p.beyond = beyond)
                .with(|p: &mut UnifiedParams| [p.trace_stage, p.resolve_stage] = stages);
            setups.extend([Wants::REFLECTION, Wants::HITS].map(|wants| (setup.clone(), wants)));
        }
    }
    if has_stages {
        for first in [FirstTraced::Screen, FirstTraced::Triangles] {
            let set = |p: &mut UnifiedParams| (p.first, p.hit_color) = (first, HitColor::Screen);
            setups.push((with_effect(&|p| p.beyond = BeyondScreen::Triangles).with(set), Wants::HITS));
        }
    }
    let quarter = with_effect(&|p| (p.resolution_scale, p.fallback) = (0.25, Fallback::Environment));
    setups.push((quarter, Wants::REFLECTION));
    // Most methods have but few of these parameters, and no other way to draw.
    let mut seen = HashSet::new();
    setups.retain(|(setup, wants)| seen.insert((choices(method, setup), wants.hits)));
    setups
}

/// Every method in all its modes and settings, at three sizes, plain, timed and counted, draws and is read back without
/// a message. Each allowed message is still given. A missing barrier often shows only in the messages of the layers.
#[test]
fn every_method_in_every_mode_is_valid() {
    let gpu = own_gpu();
    // With GPU-assisted validation, this pass compiles for half a minute. Methods that are made while it is kept share
    // its pipelines.
    let compiled = PyramidPass::new(&gpu, [1, 1]).unwrap();
    let scene = clutter();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let materials = Globals { roughness: Some(0.2), ..Globals::default() }.materials(&scene, &View::default());
    let mut frames = 0;
    // Instrumented shaders are the same at every size, and slow.
    let sizes = &[[1, 1], [33, 17], [641, 17]][..if is_gpu_assisted() { 2 } else { 3 }];
    for &extent in sizes {
        for method in METHODS {
            for (setup, wants) in setups(method, extent) {
                let camera = clutter_camera(extent);
                let shot = Shot::new(&mut stage, method, &setup, wants, camera, materials.clone()).unwrap();
                let case = format!("{}, {setup:?}", method.name);
                // Each kind of barrier runs twice, since those of the second frame start from the states that the first
                // frame left. Frames that are counted have the barriers of frames that are timed.
                for mode in [Mode::Plain, Mode::Plain, Mode::Timed, Mode::Counted] {
                    let (report, drawn) = stage.run(&shot, mode).unwrap();
                    check_validation(&gpu).unwrap_or_else(|e| panic!("{case}, {mode:?}: {e}"));
                    assert!(drawn.meshes > 0, "{case}");
                    assert_eq!(report.passes.len(), if mode == Mode::Timed { report.recorded.len() } else { 0 });
                    frames += 1;
                }
                let image = render(&mut stage, &shot, true).unwrap();
                check_validation(&gpu).unwrap_or_else(|e| panic!("{case}, read back: {e}"));
                assert_eq!([image.composite.width, image.composite.height], extent);
            }
        }
    }
    // Then each setting of each method, since settings that are off by default are not covered above.
    for method in METHODS {
        let base = with_small_captures(&Setup::new([33, 17]));
        let mut seen = HashSet::from([choices(method, &base)]);
        for setup in sweep::setups(method, &base) {
            if !seen.insert(choices(method, &setup)) {
                continue;
            }
            let camera = clutter_camera(setup.extent);
            let shot = Shot::new(&mut stage, method, &setup, Wants::REFLECTION, camera, materials.clone()).unwrap();
            for mode in [Mode::Plain, Mode::Plain, Mode::Timed] {
                stage.run(&shot, mode).unwrap();
                check_validation(&gpu).unwrap_or_else(|e| panic!("{}, {setup:?}, {mode:?}: {e}", method.name));
                frames += 1;
            }
        }
    }
    println!("{frames} frames without a message");
    // The layers also give no message when all resources are destroyed.
    drop((stage, compiled));
    check_validation(&gpu).unwrap();
    let is_given = |id: &str| gpu.validation().iter().any(|m| m.id == id);
    // SAFETY: enumeration has no preconditions.
    let layers = unsafe { gpu.shared().entry.enumerate_instance_layer_properties() }.unwrap();
    let version = layers.iter().find(|l| l.layer_name_as_c_str() == Ok(LAYER)).unwrap().spec_version;
    let driver = &gpu.info().driver;
    for allowed in ALLOWED.iter().filter(|a| a.versions.contains(&version) && driver.starts_with(a.driver)) {
        assert!(is_given(allowed.id), "the layer of version {version:#x} does not give this message: {allowed:?}");
    }
    for id in expected_failures("gpu-assisted", &gpu).iter().filter(|_| is_gpu_assisted()) {
        assert!(is_given(id), "nothing says {id} any more: take it off the expected failures");
    }
}

/// Under GPU-assisted validation, a shader that writes beyond its buffer gives a message, so that silence elsewhere
/// means something.
#[test]
fn instrumented_shaders_tell_of_a_write_beyond_a_buffer() {
    if !is_gpu_assisted() {
        println!("skipped: SSCT_GPU_AV is not 1");
        return;
    }
    // Returns the messages about a shader whose buffer of counts has so many bytes.
    let violations = |bytes: u64| {
        let gpu = own_gpu();
        let material = Image::target(&gpu, "material", vk::Format::R16G16_SFLOAT, [4, 4]).unwrap();
        let buffer = |name, size| {
            Buffer::new(&gpu, name, size, vk::BufferUsageFlags::STORAGE_BUFFER, MemoryPlace::Device).unwrap()
        };
        let (counts, lists) = (buffer("counts", bytes), buffer("tiles", 4));
        let listed_image = ImageDesc {
            name: "listed tiles",
            format: vk::Format::R32_UINT,
            extent: [1, 1],
            levels: 1,
            layers: 1,
            usage: vk::ImageUsageFlags::STORAGE,
        };
        let listed_image = Image::new(&gpu, &listed_image).unwrap();
        let pipeline = ComputePipeline::new(&gpu).unwrap();
        // The block of an image without pixels, so that the shader writes the numbers of instances alone.
        let block = UnifiedBlock::default();
        let classify = Classify {
            unified: &block,
            material_buffer: material.all(),
            Counts: &counts,
            Tiles: &lists,
            listed_image: listed_image.all(),
        };
        let record = |frame: &mut Frame| {
            frame.clear("material", material.all(), [0.0; 4])?;
            frame.compute("classify", &pipeline, &classify, [1; 3])
        };
        FrameContext::new(&gpu).unwrap().once(record).unwrap();
        gpu.violations()
    };
    let whole = violations(ARGUMENT_BYTES);
    assert!(whole.is_empty(), "{whole:?}");
    let cut_off = violations(16);
    assert!(cut_off.iter().any(|m| m.text.contains("access out of bounds")), "{cut_off:?}");
}
