//! Compares the cost of reflections through the door for other renderers with their cost in the command. Prints a table
//! to standard output.
//!
//! Each method records the same frames in two ways, in turn: as the command does, after its scene passes, and through
//! the door, from images of another renderer that have the same G-buffer. Times are those of the passes that count, by
//! the device's timestamps: the median of [`FRAMES`] frames. `import` is the pass that only the door has; it does not
//! count. The ratio is the median of the ratios of neighbouring frames.
//!
//! In both ways the method is told which kinds of reflectors the frame may have ([`ssct::Reflectors`]).

#![allow(clippy::expect_used, clippy::unwrap_used)]

#[path = "../tests/common/engine.rs"]
mod engine;

use engine::{Engine, ForeignGBuffer, NATIVE, counted};
use ssct::gpu::frame::Mode;
use ssct::gpu::{DeviceQuery, Gpu};
use ssct::methods::{self, Setup, Wants};
use ssct::{FrameInput, Reflections, ReflectionsInfo};
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::library;
use ssct_truth::metrics::bootstrap::median_of;

/// Number of frames that are timed.
const FRAMES: usize = 11;
/// Number of frames before them that are not.
const WARMUP: usize = 2;
/// Width and height of the frames in pixels.
const SIZE: [u32; 2] = [960, 540];
/// The roughness values of all surfaces; `None` for the materials of the scene, which differ from pixel to pixel.
const ROUGHNESS: [Option<f32>; 3] = [None, Some(0.0), Some(0.1)];

/// Times each method at each roughness on each view of the rooms, in the command and through the door, and prints a row
/// for each. Prints the median ratio of each method at each roughness at the end.
fn main() {
    let gpu = Gpu::open(&DeviceQuery::default()).expect("a Vulkan device");
    let scene = library::scene("rooms").expect("a built-in scene");
    let mut stage = Stage::new(&gpu, &scene).expect("device memory");
    let mut engine = Engine::new(&gpu);
    let context = engine.context();
    println!("# {} ({}), ssct {}", gpu.info().name, gpu.info().driver, env!("CARGO_PKG_VERSION"));
    println!("# {}x{}, {FRAMES} frames each; bytes: of the device that the door's view holds", SIZE[0], SIZE[1]);
    println!("method,roughness,view,command_ms,door_ms,ratio,import_ms,bytes");
    let mut ratios = Vec::new();
    for roughness in ROUGHNESS {
        let globals = Globals { roughness, ..Globals::default() };
        for view in &scene.views {
            for method in ["unified", "ssct", "hzct"].map(|name| methods::find(name).expect("a method")) {
                let (camera, materials) = (view.camera(&scene, SIZE), globals.materials(&scene, view));
                let shot = Shot::new(&mut stage, method, &Setup::on_screen(SIZE), Wants::IMAGE, camera, materials)
                    .expect("a shot");
                let (_, drawn) = stage.run(&shot, Mode::Plain).expect("a frame");
                let data = gbuffer::read(&mut stage.context, &shot).expect("the G-buffer");
                let foreign_gbuffer = ForeignGBuffer::new(&mut engine, &data, NATIVE);
                let bytes_before = context.allocated_bytes();
                let info =
                    ReflectionsInfo { extent: SIZE, method: method.name, reflection: false, ..Default::default() };
                let mut reflections = Reflections::new(&context, &info).expect("reflections");
                let bytes = context.allocated_bytes() - bytes_before;
                let input = FrameInput { timed: true, reflectors: drawn.reflectors, ..foreign_gbuffer.input() };
                // The milliseconds of each frame: in the command, through the door, and of the import.
                let mut frame_times = Vec::new();
                for frame in 0..WARMUP + FRAMES {
                    let (report, _) = stage.run(&shot, Mode::Timed).expect("a frame");
                    engine.frame(&mut reflections, &input).expect("a frame");
                    engine.reset();
                    let door_passes = reflections.times(input.slot).expect("times");
                    if frame >= WARMUP {
                        frame_times.push([counted(&report.passes), counted(&door_passes), door_passes[0].ms]);
                    }
                }
                let [command, door, import] =
                    [0, 1, 2].map(|column| median_of(frame_times.iter().map(|ms| ms[column])));
                let ratio = median_of(frame_times.iter().map(|ms| ms[1] / ms[0]));
                let (name, view) = (method.name, &view.name);
                let roughness_label = roughness.map_or("materials".into(), |value| value.to_string());
                println!("{name},{roughness_label},{view},{command:.3},{door:.3},{ratio:.3},{import:.3},{bytes}");
                ratios.push((name, roughness, ratio));
            }
        }
    }
    for (name, roughness) in
        ["unified", "ssct", "hzct"].into_iter().flat_map(|name| ROUGHNESS.map(|value| (name, value)))
    {
        let rows_of_method = ratios.iter().filter(|(method, value, _)| (*method, *value) == (name, roughness));
        let method_ratios = rows_of_method.map(|(.., ratio)| *ratio);
        println!("# {name}, roughness {roughness:?}: median ratio {:.3}", median_of(method_ratios));
    }
}
