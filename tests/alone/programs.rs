//! Only the first frames make programs, even if the camera moves. Some drivers compile a program anew for each
//! dispatch, or for each value in its uniform blocks, which takes hundreds of times as long as the dispatch
//! (docs/devices.md). Drivers that run on the CPU keep compiled programs in the memory of the process, where this test
//! counts their bytes.

use crate::common::{built_in, own_gpu};
use crate::is_alone;
use glam::Vec3;
use ssct::gpu::frame::Mode;
use ssct::methods::setup::{BeyondScreen, HistoryUse, OwnRays, Stage as ShaderStage, StageChoice};
use ssct::methods::unified::{self, FirstTraced, UnifiedParams};
use ssct::methods::{EffectParams, METHODS, MethodInfo, Setup, Wants};
use ssct_lab::stage::{Globals, Shot, Stage};
use ssct_scenes::Capture;

const EXTENT: [u32; 2] = [33, 18];

/// Returns the number of bytes of executable memory in this process that come from no file: the programs that drivers
/// have compiled. It is 0 where the system does not list the memory of a process.
fn program_bytes() -> u64 {
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap_or_default();
    let length = |range: &str| {
        let (from, to) = range.split_once('-')?;
        Some(u64::from_str_radix(to, 16).ok()? - u64::from_str_radix(from, 16).ok()?)
    };
    let executable_bytes = |line: &str| {
        let mut words = line.split_ascii_whitespace();
        let (range, rights) = (words.next()?, words.next()?);
        // The next words are the offset, the device, the number of the file, and its name if the memory is a file's.
        (rights.contains('x') && words.nth(3).is_none()).then(|| length(range)).flatten()
    };
    maps.lines().filter_map(executable_bytes).sum()
}

/// Frames before the measured ones. A driver makes programs in them, and the first frames of a history record other
/// passes.
const WARM: usize = 6;
/// Frames during which the bytes of programs must not grow.
const MEASURED: usize = 4;

/// No method, stage or option compiles a program after its first frames, at three values of roughness and with a moving
/// camera. A value that changes from frame to frame must therefore reach shaders in a way that compiles nothing.
#[test]
fn frames_make_no_programs() {
    if !is_alone() {
        return;
    }
    let gpu = own_gpu();
    let mut scene = built_in("rooms");
    let view = scene.view("corridor").unwrap().clone();
    let places = [view.eye + 0.2 * Vec3::Y, view.eye - Vec3::new(0.3, 0.0, 0.2), view.eye + 0.3 * Vec3::X];
    scene.captures = places.map(|place| Capture { resolution: 33, ..Capture::placed_at(place) }).to_vec();
    let mut stage = Stage::new(&gpu, &scene).unwrap();

    let plain = Setup::new(EXTENT);
    let variant =
        |name, change: fn(&mut EffectParams)| (format!("unified, {name}"), &unified::INFO, plain.clone().with(change));
    let screen = plain.clone().with(|p: &mut UnifiedParams| p.first = FirstTraced::Screen);
    let mut cases: Vec<(String, &MethodInfo, Setup)> =
        METHODS.iter().map(|method| (method.name.to_owned(), method, plain.clone())).collect();
    let in_compute = plain.clone().with(|p: &mut EffectParams| p.stage = ShaderStage::Compute);
    cases.extend(METHODS.iter().map(|method| (format!("{} in compute", method.name), method, in_compute.clone())));
    cases.push(("unified, the screen first".into(), &unified::INFO, screen));
    cases.push(variant("on the screen", |p| p.beyond = BeyondScreen::None));
    cases.push(variant("captures", |p| p.beyond = BeyondScreen::Captures));
    cases.push(variant("own rays", |p| p.own_rays = OwnRays::Four));
    cases.push(variant("own rays on the screen", |p| (p.beyond, p.own_rays) = (BeyondScreen::None, OwnRays::Four)));
    cases.push(variant("a history", |p| (p.history, p.history_frames) = (HistoryUse::On, 3)));
    cases.push(variant("a history in compute", |p| {
        (p.history, p.history_frames, p.history_stage) = (HistoryUse::On, 3, StageChoice::Compute);
    }));
    cases.push(variant("two bounces", |p| p.bounces = 2));
    let mut recompiled = Vec::new();
    for (name, method, setup) in cases {
        for roughness in [0.0, 0.1, 0.4] {
            let materials = Globals { roughness: Some(roughness), ..Globals::default() }.materials(&scene, &view);
            let camera = |frame: usize| {
                let mut moved = view.clone();
                moved.eye += 0.001 * frame as f32 * Vec3::X;
                moved.camera(&scene, EXTENT)
            };
            let mut shot = Shot::new(&mut stage, method, &setup, Wants::IMAGE, camera(0), materials).unwrap();
            let mut run = |frames: std::ops::Range<usize>| {
                for frame in frames {
                    shot.camera = camera(frame);
                    stage.run(&shot, Mode::Plain).unwrap();
                }
                program_bytes()
            };
            let before = run(0..WARM);
            let after = run(WARM..WARM + MEASURED);
            if after != before {
                recompiled.push(format!("{name} at {roughness}: {} bytes", after as i64 - before as i64));
            }
        }
    }
    assert!(!gpu.info().is_cpu() || program_bytes() > 0, "the driver's programs are counted");
    assert!(recompiled.is_empty(), "programs made in {MEASURED} frames:\n{}", recompiled.join("\n"));
}
