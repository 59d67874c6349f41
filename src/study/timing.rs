//! The time study: methods interleaved on the same view, warm-up first, one submission a sample.

use super::record::{Head, PassRecord, Stats, TimeRecord};
use super::stage::{Globals, Shot, Stage};
use crate::error::Result;
use crate::gpu::frame::Mode;
use crate::gpu::{FrameReport, Gpu};
use crate::methods::{MethodInfo, Setup};
use crate::scene::{Camera, Lens, Scene, View};

/// What is timed: every combination of sizes, roughness values and methods.
pub struct TimeSpec<'a> {
    /// Device.
    pub gpu: &'a Gpu,
    /// Scene.
    pub scene: &'a Scene,
    /// View of the scene.
    pub view: &'a View,
    /// Methods, taken in turn within each size and roughness.
    pub methods: Vec<&'static MethodInfo>,
    /// Sizes in pixels.
    pub sizes: Vec<[u32; 2]>,
    /// Global factors of each run.
    pub globals: Vec<Globals>,
    /// Preset, split, filter and fade; the size is each of `sizes`.
    pub setup: Setup,
    /// Frames before the first that counts.
    pub warmup: usize,
    /// Frames that count.
    pub samples: usize,
}

impl TimeSpec<'_> {
    /// Frames that [`time`] will submit.
    pub fn frames(&self) -> usize {
        self.methods.len() * self.sizes.len() * self.globals.len() * (self.warmup + self.samples + 1)
    }
}

/// The lens and camera of a view at a size.
pub fn camera(scene: &Scene, view: &View, extent: [u32; 2]) -> Camera {
    let lens: Lens = view.lens.unwrap_or(scene.lens);
    Camera::new(view.eye, view.look_at, lens, extent[0] as f32 / extent[1] as f32)
}

/// Runs the study. `progress` is called after each frame.
pub fn time(spec: &TimeSpec, progress: &mut dyn FnMut()) -> Result<Vec<TimeRecord>> {
    let mut stage = Stage::new(spec.gpu, spec.scene)?;
    let mut records = Vec::new();
    for &extent in &spec.sizes {
        let camera = camera(spec.scene, spec.view, extent);
        let setup = Setup { extent, ..spec.setup };
        let mut shots: Vec<Shot> = Vec::new();
        for globals in &spec.globals {
            let materials = globals.materials(spec.scene, spec.view);
            if shots.is_empty() {
                for method in &spec.methods {
                    shots.push(Shot::new(&mut stage, method, &setup, camera, materials.clone())?);
                }
            } else {
                for shot in &mut shots {
                    shot.set_materials(&mut stage, materials.clone())?;
                }
            }
            records.extend(time_shots(spec, &mut stage, &shots, extent, globals, progress)?);
        }
    }
    Ok(records)
}

/// Times some shots of one size in turn.
fn time_shots(
    spec: &TimeSpec,
    stage: &mut Stage,
    shots: &[Shot],
    extent: [u32; 2],
    globals: &Globals,
    progress: &mut dyn FnMut(),
) -> Result<Vec<TimeRecord>> {
    let mut reports: Vec<Vec<FrameReport>> = vec![Vec::new(); shots.len()];
    for sample in 0..spec.warmup + spec.samples {
        for (shot, reports) in shots.iter().zip(&mut reports) {
            let (report, _) = stage.run(shot, Mode::Timed)?;
            if sample >= spec.warmup {
                reports.push(report);
            }
            progress();
        }
    }
    let mut records = Vec::new();
    for ((shot, reports), method) in shots.iter().zip(reports).zip(&spec.methods) {
        let (counted, drawn) = stage.run(shot, Mode::Counted)?;
        progress();
        let setup = Setup { extent, ..spec.setup };
        let head = Head::new("time", spec.scene, spec.view, method.name, &setup, globals, spec.gpu);
        let samples: Vec<Vec<f64>> = reports.iter().map(|r| r.passes.iter().map(|p| p.ms).collect()).collect();
        let first = reports.first();
        let passes = first.map_or(&[][..], |r| &r.passes).iter().enumerate();
        let passes = passes
            .map(|(i, p)| PassRecord {
                name: p.name.clone(),
                counted: p.counted,
                stats: Stats::of(&samples.iter().map(|s| s[i]).collect::<Vec<_>>()),
                work: counted.work.get(i).copied(),
            })
            .collect();
        let sum = |r: &FrameReport| r.passes.iter().filter(|p| p.counted).map(|p| p.ms).sum::<f64>();
        records.push(TimeRecord {
            head,
            split: spec.setup.split,
            fallback: spec.setup.fallback,
            passes,
            total: Stats::of(&reports.iter().map(sum).collect::<Vec<_>>()),
            frame: Stats::of(&reports.iter().map(|r| r.frame_ms).collect::<Vec<_>>()),
            drawn,
            recorded: first.map(|r| r.recorded.clone()).unwrap_or_default(),
            skipped: first.map(|r| r.skipped.clone()).unwrap_or_default(),
            samples,
        });
    }
    Ok(records)
}
