//! Error over the age of captures: meshes move a step in each frame, and some faces of the captures are renewed. Each
//! frame is compared with a world reference of the moved scene (docs/definitions.md, "Captures in time").

use super::columns::{Column, columns, figure, part, series, time};
use super::compare::rgb;
use super::engine::{Bench, Planned, Row, Study};
use super::exhibit::{Chart, Drawing, Line, Table};
use super::journal::scene_digest;
use super::names::cell_name;
use super::record::{Head, Provenance, RecordSubject, Stats};
use crate::error::{Error, Result};
use crate::stage::gbuffer;
use crate::stage::{Globals, Shot, Stage};
use glam::Vec3;
use serde_json::{Value, json};
use ssct::gpu::frame::Mode;
use ssct::methods::{EffectParams, Fallback, MethodInfo, Setup, Wants};
use ssct_scenes::{GBufferData, Material, Scene, View};
use ssct_truth::metrics::image::masked_rmse;
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world::WorldReference;

/// The scene, the meshes that move in it, and how captures follow the motion.
pub struct AgeStudy {
    /// Scene before anything moves. If it has no captures of its own, the program places captures in this scene.
    pub scene: Scene,
    /// View, which stands still.
    pub view: View,
    /// Methods that trace rays in captures alone, or whose rays go on in captures when the screen loses them.
    pub methods: Vec<&'static MethodInfo>,
    /// Parameters of the methods, with captures.
    pub setup: Setup,
    /// Sizes in pixels.
    pub sizes: Vec<[u32; 2]>,
    /// Global factors.
    pub globals: Vec<Globals>,
    /// The meshes that move, by name.
    pub moving: Vec<String>,
    /// Motion from one frame to the next, in metres along the world's axes.
    pub step_m: Vec3,
    /// Numbers of faces that are renewed in each frame; each number makes a row of each cell.
    pub faces: Vec<u32>,
    /// Frames, ≥ 1, the first of which shows the scene as it was captured.
    pub frames: u32,
    /// Rays a pixel of the world reference, ≥ 1.
    pub rays: u32,
}

/// A cell: a method at a size with a set of factors.
pub struct AgeCell {
    method: &'static MethodInfo,
    /// Setup of the method, with the size.
    setup: Setup,
    globals: Globals,
}

columns! {
    /// A frame of a row.
    #[derive(Copy)]
    pub struct AgeFrame {
        /// Distance in metres of the moving meshes from where they began.
        pub moved_m: f32 = figure(""),
        /// Mean age of the captures' faces: how many frames ago each was drawn.
        pub age_frames: f64 = figure(""),
        /// RMSE of the linear reflection colour against the world of this frame, over reflecting pixels.
        pub rmse: f64 = figure(""),
        /// Share of the reflecting pixels whose rays meet a moving mesh, where the mesh is now or where it began.
        pub touched: f64 = figure(""),
        /// RMSE over the touched pixels alone, the only ones that age; null if no pixel is touched, as in the first
        /// frame.
        pub touched_rmse: Option<f64> = figure(""),
        /// Standard error of the world reference of this frame.
        pub standard_error: f64 = figure(""),
        /// Time of the method in milliseconds, including the renewal of captures.
        pub effect_ms: f64 = time(""),
        /// Time of the renewal of captures in milliseconds, which is a part of `effect_ms`.
        pub capture_ms: f64 = time(""),
    }
}

columns! {
    /// The error over the frames, if one number of faces is renewed in each frame.
    pub struct AgeRecord {
        /// Subject of the record; its setup has `captures_per_frame`.
        #[serde(flatten)]
        pub head: Head = part(),
        /// Names of the meshes that move.
        pub moving: Vec<String>,
        /// Motion of these meshes from one frame to the next, in metres along the world's axes.
        pub step_m: [f32; 3],
        /// Number of faces that are renewed in each frame.
        pub faces_per_frame: u32 = figure("faces a frame"),
        /// Number of faces of all captures.
        pub faces: u32 = figure("of"),
        /// Rays a pixel of the world reference.
        pub rays: u32,
        /// Every frame in order.
        pub frames: Vec<AgeFrame> = series(),
    }
}

impl Row for AgeRecord {
    const KIND: &'static str = "age";
    const TITLE: &'static str = "Error over the age of captures";

    fn program(&self) -> &Provenance {
        &self.head.program
    }

    /// Adds columns of the error in the first and the last frame, of the error of touched pixels in the middle and the
    /// last frame, and of times.
    fn tables(rows: &[Self], _: &Value) -> Vec<Table> {
        let first_rmse = |r: &Self| r.frames.first().map(|f| f.rmse);
        let middle_touched_rmse = |r: &Self| r.frames.get(r.frames.len() / 2).and_then(|f| f.touched_rmse);
        let median = |r: &Self, value: fn(&AgeFrame) -> f64| {
            Stats::from_samples(&r.frames.iter().map(value).collect::<Vec<_>>()).median_ms
        };
        let derived_columns = [
            Column::derived("rmse first", 4, first_rmse),
            Column::derived("last", 4, |r: &Self| r.frames.last().map(|f| f.rmse)),
            Column::derived("of touched, middle", 4, middle_touched_rmse),
            Column::derived("last", 4, |r: &Self| r.frames.last().and_then(|f| f.touched_rmse)),
            Column::derived("touched %", 1, |r: &Self| r.frames.last().map(|f| 100.0 * f.touched)),
            Column::derived("moved m", 2, |r: &Self| r.frames.last().map(|f| f.moved_m)),
            Column::derived("age, frames", 1, |r: &Self| r.frames.last().map(|f| f.age_frames)),
            Column::derived("effect ms median", 3, move |r: &Self| median(r, |f| f.effect_ms)),
            Column::derived("captures ms median", 3, move |r: &Self| median(r, |f| f.capture_ms)),
        ];
        vec![Table::with_columns("table", rows, derived_columns)]
    }

    /// Draws a line for each record: the error of touched pixels over the frames that have touched pixels.
    fn charts(rows: &[Self]) -> Vec<Chart> {
        let heads: Vec<&Head> = rows.iter().map(|r| &r.head).collect();
        let line = |r: &Self| {
            let point = |(frame_index, frame): (usize, &AgeFrame)| Some((frame_index as f64, frame.touched_rmse?));
            let points = r.frames.iter().enumerate().filter_map(point);
            let name = r.head.line_name(&heads, &format!("{} of {} faces", r.faces_per_frame, r.faces));
            Line { name, points: points.collect() }
        };
        let axes = ["frame", "RMSE of the pixels that something moved for"].map(str::to_owned);
        let lines = Drawing::Lines(axes, rows.iter().map(line).collect());
        vec![Chart::new("age", "The error of what something moved for", lines)]
    }
}

impl AgeStudy {
    /// Refuses a study with a method that uses no captures.
    ///
    /// # Errors
    /// [`Usage`](ssct::Error::Usage) with the first such method.
    pub fn check(&self) -> Result<()> {
        let effect = self.setup.effect();
        let uses_captures = |method: &MethodInfo| {
            // A screen-space method has captures only if the setup asks for them.
            let has_captures = effect.captures_wanted().wanted().is_some() || !method.is_screen_space();
            effect.fallback == Fallback::Captures || method.takes_captures && has_captures
        };
        match self.methods.iter().find(|method| !uses_captures(method)) {
            Some(method) => {
                let remedy = if method.takes_captures {
                    "captures must be auto or a number"
                } else {
                    "the fallback must be captures"
                };
                let message =
                    format!("the method {} has no captures whose age could be measured; {remedy}", method.name);
                Err(Error::usage(message))
            }
            None => Ok(()),
        }
    }
}

impl Study for AgeStudy {
    type Cell = AgeCell;
    type Row = AgeRecord;

    fn scenes(&self) -> Vec<&Scene> {
        vec![&self.scene]
    }

    /// Lists a cell for each method, size and set of factors.
    fn cells(&self) -> Vec<Planned<AgeCell>> {
        let digest = scene_digest(&self.scene);
        let motion = json!([self.moving, self.step_m.to_array(), self.faces, self.frames, self.rays]);
        let mut cells = Vec::new();
        for &method in &self.methods {
            for &size in &self.sizes {
                let setup = self.setup.with_extent(size);
                cells.extend(self.globals.iter().map(|&globals| {
                    let variant =
                        json!([method.name, setup.recorded(Some(method)), globals, format!("{:?}", self.view)]);
                    let name = cell_name(&self.scene.name, &self.view.name, size, globals.roughness);
                    Planned {
                        name: format!("{name}-{}", method.name),
                        setup: json!([digest, variant, motion]),
                        cell: AgeCell { method, setup: setup.clone(), globals },
                    }
                }));
            }
        }
        cells
    }

    /// Measures a row for each number of renewed faces. The rows draw every frame in turn, so that they share the
    /// world reference of the frame.
    fn measure(&mut self, cell: &AgeCell, bench: &mut Bench) -> Result<Vec<AgeRecord>> {
        let camera = self.view.camera(&self.scene, cell.setup.extent);
        let materials = cell.globals.materials(&self.scene, &self.view);
        let mut stage = Stage::new(bench.gpu, &self.scene)?;
        let mut rows = Vec::new();
        for &faces in &self.faces {
            let setup = cell.setup.with(|p: &mut EffectParams| p.captures_per_frame = faces);
            let shot = Shot::new(&mut stage, cell.method, &setup, Wants::REFLECTION, camera, materials.clone())?;
            let place = (&self.scene, &self.view);
            let record = AgeRecord {
                head: Head::new("age", bench.gpu, place, RecordSubject::Method(cell.method), &setup, &cell.globals),
                moving: self.moving.clone(),
                step_m: self.step_m.to_array(),
                faces_per_frame: faces,
                faces: shot.capture_faces(),
                rays: self.rays,
                frames: Vec::new(),
            };
            rows.push((shot, record));
        }
        for frame in 0..self.frames {
            let offset = frame as f32 * self.step_m;
            for name in &self.moving {
                stage.scene_mut().place_meshes(name, offset)?;
            }
            let mut truth = None;
            for (shot, record) in &mut rows {
                (bench.go_on)()?;
                let (report, _, output) = stage.output_in(Mode::Timed, shot)?;
                let reflection = gbuffer::reflection(&mut stage.context, &output)?;
                let colors = rgb(&reflection);
                let truth = match &mut truth {
                    Some(truth) => truth,
                    // Every row draws the same G-buffer, so that one truth serves all rows of a frame.
                    missing_truth => {
                        let screen = gbuffer::read(&mut stage.context, shot)?;
                        missing_truth.insert(Truth::new(self, &cell.setup, screen, &materials, offset))
                    }
                };
                let sum_ms = |includes: &dyn Fn(&str) -> bool| {
                    // `fold` makes the sum of no passes 0; `sum` would make it -0.
                    report.passes.iter().filter(|p| p.counted && includes(&p.name)).fold(0.0, |sum, p| sum + p.ms)
                };
                record.frames.push(AgeFrame {
                    moved_m: offset.length(),
                    age_frames: mean_age(record.faces, record.faces_per_frame, frame),
                    rmse: masked_rmse(&truth.color, &colors, &truth.mask),
                    touched: truth.touched_share(),
                    touched_rmse: truth.touched_rmse(&colors),
                    standard_error: truth.standard_error,
                    effect_ms: sum_ms(&|_| true),
                    capture_ms: sum_ms(&|name| name.starts_with("capture/")),
                });
            }
        }
        Ok(rows.into_iter().map(|(_, record)| record).collect())
    }
}

/// Returns the mean age of `faces` faces at a frame, in frames; frames are counted from 0. Faces are renewed in turn,
/// `per_frame` of them in each frame, before the frame is shown. A face that was never renewed is as old as the frame's
/// number.
pub fn mean_age(faces: u32, per_frame: u32, frame: u32) -> f64 {
    if faces == 0 {
        return 0.0;
    }
    let renewed = per_frame.min(faces);
    if renewed == 0 {
        return f64::from(frame);
    }
    // Faces are ranked by when they were drawn: rank 0 is the face drawn last. Each frame draws `renewed` faces.
    let age = |rank: u32| (rank / renewed).min(frame);
    f64::from((0..faces).map(age).sum::<u32>()) / f64::from(faces)
}

/// The world reference of a frame; its lists have an element for each pixel, rows from the top.
struct Truth {
    /// Linear reflection colour.
    color: Vec<[f32; 3]>,
    /// Whether the pixel reflects.
    mask: Vec<bool>,
    /// Whether the pixel reflects and its reflection differs from that in the scene before anything moved.
    touched: Vec<bool>,
    /// Root mean square of the standard errors of the reference over all reflecting pixels.
    standard_error: f64,
}

impl Truth {
    /// Traces the reference of a frame in which the moving meshes stand at `offset`, in metres, from where they began.
    /// `screen` is the frame's G-buffer.
    fn new(study: &AgeStudy, setup: &Setup, screen: GBufferData, materials: &[Material], offset: Vec3) -> Self {
        let mut scene = study.scene.clone();
        for mesh in scene.meshes.iter_mut().filter(|m| study.moving.contains(&m.name)) {
            mesh.translate(offset);
        }
        let world = World::new(&scene, materials);
        let first_hits = FirstHits::shown(&world, &screen);
        // Returns the reflection colours in a world, and their standard error.
        let trace = |world: &World| {
            let seed = 2;
            let reference =
                WorldReference::new(world, &first_hits, &screen.camera, seed).with_bounces(setup.effect().bounces);
            let mut state = reference.start();
            reference.add(&mut state, study.rays);
            let color: Vec<[f32; 3]> = reference.image(&state).reflection.iter().map(Vec3::to_array).collect();
            (color, state.overall_standard_error())
        };
        let (color, standard_error) = trace(&world);
        // One seed traces the same rays in both scenes, so that colours are equal to the bit unless a ray meets a moved
        // mesh.
        let (color_before, _) = trace(&World::new(&study.scene, materials));
        let mask = screen.reflecting();
        let touched = (0..mask.len()).map(|pixel| mask[pixel] && color[pixel] != color_before[pixel]).collect();
        Self { color, mask, touched, standard_error }
    }

    /// Share of the reflecting pixels that are touched; 0 if no pixel reflects.
    fn touched_share(&self) -> f64 {
        let count = |mask: &[bool]| mask.iter().filter(|m| **m).count() as f64;
        if count(&self.mask) > 0.0 { count(&self.touched) / count(&self.mask) } else { 0.0 }
    }

    /// RMSE of a method's reflection colours over the touched pixels; `None` if no pixel is touched.
    fn touched_rmse(&self, colors: &[[f32; 3]]) -> Option<f64> {
        self.touched.contains(&true).then(|| masked_rmse(&self.color, colors, &self.touched))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct::methods;
    use ssct::methods::setup::{BeyondScreen, CaptureCount};

    /// Returns the message that refuses a study of a method; empty if the study is accepted. `change` sets parameters
    /// of the method.
    fn complaint(method: &str, change: fn(&mut EffectParams)) -> String {
        let study = AgeStudy {
            scene: Scene::default(),
            view: View::default(),
            methods: vec![methods::find(method).expect("a method")],
            setup: Setup::new([16, 9]).with(change),
            sizes: vec![[16, 9]],
            globals: vec![Globals::default()],
            moving: Vec::new(),
            step_m: Vec3::ZERO,
            faces: vec![0],
            frames: 1,
            rays: 2,
        };
        study.check().err().map(|e| e.to_string()).unwrap_or_default()
    }

    #[test]
    fn a_method_without_captures_is_refused_with_what_it_needs() {
        assert!(complaint("unified", |_| ()).ends_with("; captures must be auto or a number"));
        assert!(complaint("ssct", |_| ()).ends_with("; the fallback must be captures"));
        assert_eq!(complaint("unified", |effect| effect.captures = CaptureCount::Number(2)), "");
        assert_eq!(complaint("unified", |effect| effect.beyond = BeyondScreen::Captures), "");
        assert_eq!(complaint("ssct", |effect| effect.fallback = Fallback::Captures), "");
        assert_eq!(complaint("captures", |_| ()), "");
    }

    /// Compares the mean age with that of a list that keeps the frame in which each face was drawn last.
    #[test]
    fn the_mean_age_is_that_of_faces_renewed_in_turn() {
        for (faces, per_frame) in [(6, 0), (6, 1), (12, 5), (24, 2), (24, 24), (12, 30)] {
            let mut last_drawn = vec![0_u32; faces as usize];
            let mut next_face = 0;
            for frame in 0..40 {
                for _ in 0..per_frame.min(faces) {
                    last_drawn[next_face as usize] = frame;
                    next_face = (next_face + 1) % faces;
                }
                let mean = last_drawn.iter().map(|drawn| f64::from(frame - drawn)).sum::<f64>() / f64::from(faces);
                assert_eq!(mean_age(faces, per_frame, frame), mean, "{faces}, {per_frame}, {frame}");
            }
        }
    }
}
