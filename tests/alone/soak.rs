//! Soak tests: frames are drawn while sizes and methods change. In the end, no more objects and memory may be in use
//! than after the first rounds, on the device and on the host.

use crate::common::engine::{Engine, ForeignGBuffer, NATIVE, info, view_of_rooms};
use crate::common::{clutter_camera, two_quads};
use crate::{is_alone, memory};
use ssct::gpu::frame::Mode;
use ssct::gpu::{DeviceQuery, Gpu, Watch};
use ssct::methods::{self, METHODS, MethodInfo, Setup, Wants};
use ssct::{FrameInput, Reflections};
use ssct_lab::stage::image::render;
use ssct_lab::stage::{Globals, Shot, Stage};
use ssct_scenes::View;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Write;
use std::sync::Arc;

/// The objects and the memory in use at the end of a round.
#[derive(Debug, Clone, PartialEq)]
struct Held {
    /// Kinds of objects on the device and their counts, as one hash: the list itself would take memory that the test
    /// then counts.
    live: u64,
    /// Bytes of device memory that objects use, and bytes of the blocks that are reserved for them.
    device: [u64; 2],
    /// Bytes that Rust code has allocated on the host.
    heap: usize,
    /// Bytes of the whole process in memory, with the driver and its compiler; 0 where the system does not say.
    resident: u64,
}

impl Held {
    /// Measures what is in use after a number of frames, and prints it.
    fn now(gpu: &Gpu, watch: &Watch, frames: usize) -> Self {
        let statm = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
        let pages: u64 = statm.split(' ').nth(1).and_then(|p| p.parse().ok()).unwrap_or(0);
        let held = Self {
            live: digest(&watch.live()),
            device: [gpu.allocated_bytes(), gpu.reserved_bytes()],
            heap: memory::live(),
            resident: pages * 4096,
        };
        // A test keeps the text of `println` in memory until it ends, so that this text goes to standard error.
        let printed = writeln!(
            std::io::stderr(),
            "{frames} frames: device {} B in use, {} B in blocks, {} objects; host {} B of Rust's, {:.1} MB resident",
            held.device[0],
            held.device[1],
            watch.live().values().sum::<i64>(),
            held.heap,
            held.resident as f64 / 1e6
        );
        printed.unwrap();
        assert!(held.resident < 10_000_000_000, "the driver fills the machine");
        held
    }
}

/// Returns a hash of the counts of live objects.
fn digest(live: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    live.hash(&mut hasher);
    hasher.finish()
}

/// Widths and heights in pixels; small, so that ten thousand frames take a minute or two on a CPU.
const SIZES: [[u32; 2]; 5] = [[1, 1], [5, 3], [37, 20], [20, 37], [64, 64]];

/// Draws rounds of all methods at all sizes, `frames_each` frames of each method at each size, in modes by turns.
/// Returns what is in use after each round. The scene is uploaded anew in every round.
fn soak(methods: &[&'static MethodInfo], sizes: &[[u32; 2]], frames_each: usize, rounds: usize) -> Vec<Held> {
    let watch = Arc::<Watch>::default();
    let gpu = Gpu::open(&DeviceQuery { watch: Some(Arc::clone(&watch)), ..DeviceQuery::default() }).unwrap();
    println!("{} ({}), {} methods, sizes {sizes:?}", gpu.info().name, gpu.info().driver, methods.len());
    let scene = two_quads();
    let (mut usages, mut frames) = (Vec::with_capacity(rounds), 0);
    for round in 0..rounds {
        let mut stage = Stage::new(&gpu, &scene).unwrap();
        for n in 0..methods.len() * sizes.len() {
            // Consecutive shots differ in method and in size.
            let (method, extent) = (methods[n % methods.len()], sizes[(n + n / methods.len()) % sizes.len()]);
            let roughness = Some([0.0, 0.05, 0.3][(n + round) % 3]);
            let materials = Globals { roughness, ..Globals::default() }.materials(&scene, &View::default());
            let camera = clutter_camera(extent);
            let shot =
                Shot::new(&mut stage, method, &Setup::new(extent), Wants::REFLECTION, camera, materials).unwrap();
            for frame in 1..frames_each {
                stage.run(&shot, [Mode::Plain, Mode::Timed, Mode::Counted][frame % 3]).unwrap();
            }
            assert_eq!(render(&mut stage, &shot, false).unwrap().composite.width, extent[0]);
            frames += frames_each;
        }
        drop(stage);
        usages.push(Held::now(&gpu, &watch, frames));
    }
    usages
}

/// Returns whether a number has grown by no more than a hundredth.
fn is_flat(before: u64, after: u64) -> bool {
    after as f64 <= 1.01 * before as f64
}

/// Checks every round after the round `warm`: it has the same objects and device memory in use as that round, and at
/// most a hundredth more memory on the host.
fn check(usages: &[Held], warm: usize) {
    let first = &usages[warm];
    for (n, later) in usages.iter().enumerate().skip(warm + 1) {
        assert_eq!(later.live, first.live, "round {n}");
        assert_eq!(later.device, first.device, "round {n}");
        assert!(is_flat(first.heap as u64, later.heap as u64), "round {n}: {} of {}", later.heap, first.heap);
    }
}

/// Four methods at three sizes leave nothing behind from round to round, once the first two rounds have filled what is
/// kept for reuse.
#[test]
fn nothing_grows_while_sizes_and_methods_change() {
    if !is_alone() {
        return;
    }
    let methods = ["unified", "ssct", "sslr", "planar"].map(|name| methods::find(name).unwrap());
    let usages = soak(&methods, &SIZES[1..4], 8, 4);
    check(&usages, 1);
}

/// Ten thousand frames of all methods leave nothing behind. A leak of a few bytes a frame would hide in a short test.
#[test]
#[ignore = "minutes: ten thousand frames (make soak)"]
fn nothing_grows_in_ten_thousand_frames() {
    if !is_alone() {
        return;
    }
    let methods: Vec<_> = METHODS.iter().collect();
    let (rounds, frames_each) = (5, 32);
    assert!(rounds * frames_each * methods.len() * SIZES.len() >= 10_000);
    let usages = soak(&methods, &SIZES, frames_each, rounds);
    check(&usages, 1);
    check_resident(&usages);
}

/// Checks that the memory of the whole process, with the driver's, does not grow after the third round. The driver's
/// heap still grows before that.
fn check_resident(usages: &[Held]) {
    let (warm, last) = (usages[2].resident, usages[usages.len() - 1].resident);
    assert!(is_flat(warm, last), "resident memory: {warm} to {last} B");
}

/// Draws rounds of frames through the door for other renderers, by two `Reflections` in turn. Their methods, sizes and
/// slots change, and every second frame is timed. Returns what is in use after each round.
fn soak_embedded(methods: &[&'static MethodInfo], sizes: &[[u32; 2]], frames_each: usize, rounds: usize) -> Vec<Held> {
    let watch = Arc::<Watch>::default();
    let gpu = Gpu::open(&DeviceQuery { watch: Some(Arc::clone(&watch)), ..DeviceQuery::default() }).unwrap();
    let mut engine = Engine::new(&gpu);
    let data: Vec<_> = sizes.iter().map(|size| view_of_rooms(&gpu, *size)).collect();
    let gbuffers: Vec<_> = data.iter().map(|data| ForeignGBuffer::new(&mut engine, data, NATIVE)).collect();
    let context = engine.context();
    let (mut usages, mut frames) = (Vec::with_capacity(rounds), 0);
    for _ in 0..rounds {
        for (n, method) in methods.iter().enumerate() {
            let next = methods[(n + 1) % methods.len()];
            let mut reflections = [method, &next].map(|m| Reflections::new(&context, &info(&data[0], m.name)).unwrap());
            for gbuffer in &gbuffers {
                for frame in 0..frames_each {
                    let reflections = &mut reflections[frame % 2];
                    if frame < 2 {
                        reflections.resize(gbuffer.color.extent()).unwrap();
                    }
                    let input = FrameInput { slot: frame / 2 % 2, timed: frame % 2 == 0, ..gbuffer.input() };
                    engine.frame(reflections, &input).unwrap();
                    frames += 1;
                }
            }
        }
        engine.reset();
        usages.push(Held::now(&gpu, &watch, frames));
    }
    usages
}

/// Frames that another renderer records through the door leave nothing behind from round to round, though reflections
/// are made, resized and dropped.
#[test]
fn nothing_grows_while_others_record_into_their_frames() {
    if !is_alone() {
        return;
    }
    let methods = ["unified", "ssct", "sslr"].map(|name| methods::find(name).unwrap());
    check(&soak_embedded(&methods, &SIZES[1..4], 6, 4), 1);
}

/// Ten thousand frames through the door leave nothing behind, in all methods that see the screen alone.
#[test]
#[ignore = "minutes: ten thousand frames (make soak)"]
fn nothing_grows_in_ten_thousand_frames_of_others() {
    if !is_alone() {
        return;
    }
    let methods: Vec<_> = METHODS.iter().filter(|m| m.is_screen_space()).collect();
    let (rounds, frames_each) = (5, 60);
    assert!(rounds * frames_each * methods.len() * SIZES.len() >= 10_000, "{}", methods.len());
    let usages = soak_embedded(&methods, &SIZES, frames_each, rounds);
    check(&usages, 1);
    check_resident(&usages);
}
