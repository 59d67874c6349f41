//! Measures the GPU time of each method's passes in the corridor of the built-in rooms, at 480×270 and roughness 0.1.
//! Criterion's statistics are those of times by the device's timestamps, and not by the host's clock.

#![allow(clippy::expect_used)]

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use ssct::gpu::frame::Mode;
use ssct::gpu::{DeviceQuery, Gpu};
use ssct::methods::{METHODS, Setup, Wants};
use ssct_lab::stage::{Globals, Shot, Stage};
use ssct_scenes::library;
use std::time::Duration;

/// Width and height of the frames in pixels.
const SIZE: [u32; 2] = [480, 270];

/// Times the passes of every method that count, without the scene passes.
fn time_methods(criterion: &mut Criterion) {
    let gpu = Gpu::open(&DeviceQuery::default()).expect("a Vulkan device");
    let scene = library::scene("rooms").expect("a built-in scene");
    let view = scene.view("corridor").expect("a view of the rooms");
    let globals = Globals { roughness: Some(0.1), reflectivity: 1.0, normal_deviation: Some(0.1) };
    let mut stage = Stage::new(&gpu, &scene).expect("device memory");
    let mut group = criterion.benchmark_group("gpu time");
    group.sample_size(10);
    for method in METHODS {
        let camera = view.camera(&scene, SIZE);
        let shot = Shot::new(
            &mut stage,
            method,
            &Setup::new(SIZE),
            Wants::REFLECTION,
            camera,
            globals.materials(&scene, view),
        )
        .expect("a shot");
        group.bench_function(BenchmarkId::new(method.name, "480x270"), |bencher| {
            bencher.iter_custom(|iterations| {
                let mut ms = 0.0;
                for _ in 0..iterations {
                    let (report, _) = stage.run(&shot, Mode::Timed).expect("a frame");
                    ms += report.passes.iter().filter(|p| p.counted).map(|p| p.ms).sum::<f64>();
                }
                Duration::from_secs_f64(ms * 1e-3)
            });
        });
    }
    group.finish();
}

criterion_group!(benches, time_methods);
criterion_main!(benches);
