//! Measures what the colour of a hit costs through the door for other renderers: meshes that have one colour each, and meshes
//! with textures. Prints a table to standard output.
//!
//! For both kinds of meshes, the mirror rays of the same views are followed through the same triangles, frame by frame
//! in turn. Times are those of the passes that count, by the device's timestamps: the median of [`FRAMES`] frames, and
//! the median of the ratios of neighbouring frames.

#![allow(clippy::expect_used, clippy::unwrap_used)]

#[path = "../tests/common/engine.rs"]
mod engine;

use engine::{Engine, ForeignGBuffer, NATIVE, counted, meshes_of, textures_of, upload, vertices_of};
use ssct::gpu::{DeviceQuery, Gpu};
use ssct::methods::{self, Setup, Wants};
use ssct::{FrameInput, HitTexture, Reflections, ReflectionsInfo, Triangles};
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::library;
use ssct_truth::metrics::bootstrap::median_of;
use std::time::Instant;

/// Number of frames that are timed.
const FRAMES: usize = 11;
/// Number of frames before them that are not.
const WARMUP: usize = 2;
/// Width and height of the frames in pixels.
const SIZE: [u32; 2] = [960, 540];
/// The built-in scenes.
const SCENES: [&str; 3] = ["rooms", "street", "atrium"];

/// Times `traced` on each view of the scenes, with meshes of one colour each and with textures, and prints the rows.
fn main() {
    let gpu = Gpu::open(&DeviceQuery::default()).expect("a Vulkan device");
    let mut engine = Engine::new(&gpu);
    let context = engine.context();
    println!("# {} ({}), ssct {}", gpu.info().name, gpu.info().driver, env!("CARGO_PKG_VERSION"));
    println!("# traced, roughness 0, {}x{}, {FRAMES} frames each", SIZE[0], SIZE[1]);
    println!("scene,view,color_ms,texture_ms,ratio,color_made_ms,texture_made_ms,color_bytes,texture_bytes");
    for name in SCENES {
        let scene = library::scene(name).expect("a built-in scene");
        let mut stage = Stage::new(&gpu, &scene).expect("device memory");
        let (vertices, textures) = (vertices_of(&scene), textures_of(&scene));
        // The triangles without and with textures, each with the milliseconds and the bytes that making them took.
        let scene_triangles = [false, true].map(|are_textured| {
            let (bytes_before, begun) = (context.allocated_bytes(), Instant::now());
            let meshes = meshes_of(&scene, &vertices, are_textured);
            let used_textures: &[HitTexture] = if are_textured { &textures } else { &[] };
            let mut triangles = Triangles::with_textures(&context, &meshes, used_textures).expect("triangles");
            let made_ms = 1e3 * begun.elapsed().as_secs_f64();
            upload(&engine, &mut triangles);
            (triangles, made_ms, context.allocated_bytes() - bytes_before)
        });
        let globals = Globals { roughness: Some(0.0), ..Globals::default() };
        for view in &scene.views {
            let method = methods::find("traced").expect("a method");
            let (camera, materials) = (view.camera(&scene, SIZE), globals.materials(&scene, view));
            let setup = Setup::on_screen(SIZE);
            let shot = Shot::new(&mut stage, method, &setup, Wants::IMAGE, camera, materials).expect("a shot");
            stage.draw(&shot).expect("a frame");
            let data = gbuffer::read(&mut stage.context, &shot).expect("the G-buffer");
            let foreign_gbuffer = ForeignGBuffer::new(&mut engine, &data, NATIVE);
            let mut reflections = scene_triangles.each_ref().map(|(triangles, ..)| {
                let defaults = ReflectionsInfo { triangles: Some(triangles), method: "traced", ..Default::default() };
                let info = ReflectionsInfo { extent: SIZE, reflection: false, ..defaults };
                Reflections::new(&context, &info).expect("reflections")
            });
            // The milliseconds of each frame, without and with textures.
            let mut frame_times = Vec::new();
            for frame in 0..WARMUP + FRAMES {
                let times_ms = [0, 1].map(|kind| {
                    let (triangles, ..) = &scene_triangles[kind];
                    let input = FrameInput { timed: true, triangles: Some(triangles), ..foreign_gbuffer.input() };
                    engine.frame(&mut reflections[kind], &input).expect("a frame");
                    engine.reset();
                    counted(&reflections[kind].times(input.slot).expect("times"))
                });
                if frame >= WARMUP {
                    frame_times.push(times_ms);
                }
            }
            let [color, texture] = [0, 1].map(|kind| median_of(frame_times.iter().map(|ms| ms[kind])));
            let ratio = median_of(frame_times.iter().map(|ms| ms[1] / ms[0]));
            let [(_, color_made, color_bytes), (_, texture_made, texture_bytes)] = &scene_triangles;
            println!(
                "{name},{},{color:.3},{texture:.3},{ratio:.3},{color_made:.1},{texture_made:.1},{color_bytes},{texture_bytes}",
                view.name
            );
        }
    }
}
