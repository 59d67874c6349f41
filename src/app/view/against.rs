//! The error of what is seen against the world reference, where `ssct render --method reference` left
//! one for the same view, size and materials. Found and compared on a thread of its own.

use crate::app::reference::{default_cache, kept_in};
use crate::metrics::flip::FlipMap;
use crate::metrics::image::{masked_relative_mse, masked_rmse};
use crate::reference::first_hits::FirstHits;
use crate::reference::surface::World;
use crate::reference::world::{Escape, WorldReference};
use crate::scene::{Camera, Material, Scene};
use crate::study::error::display;
use glam::Vec3;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// What is compared.
pub struct Question {
    /// The scene.
    pub scene: Arc<Scene>,
    /// Its materials in the view, with the global factors.
    pub materials: Vec<Material>,
    /// The camera.
    pub camera: Camera,
    /// Width and height in pixels.
    pub extent: [u32; 2],
    /// What escaped rays bring: as for the methods, the environment where that is behind them.
    pub escape: Escape,
    /// The reflection colours of each method, before fade and reflectivity.
    pub reflections: Vec<Vec<[f32; 3]>>,
}

/// What came out.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// There is no reference of this view, size and these materials.
    NoReference,
    /// There is.
    Errors {
        /// Rays a pixel that the reference has.
        samples: u32,
        /// What the reference itself is expected to err by, as an RMSE.
        standard_error: f64,
        /// Each method's errors.
        methods: Vec<ImageErrors>,
    },
}

/// Errors of a reflection colour over the reflecting pixels (DEFINITIONS, "Image error").
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageErrors {
    /// Root mean square error, linear.
    pub rmse: f64,
    /// Mean square error over the reference's mean square; `None` if that is 0.
    pub relative_mse: Option<f64>,
    /// Mean FLIP of the display images.
    pub flip: f64,
}

/// A comparison under way or done.
#[derive(Default)]
pub struct Against {
    waiting: Option<Receiver<Answer>>,
    /// The last answer, if it is still of what is seen.
    pub answer: Option<Answer>,
}

impl Against {
    /// Asks; `wake` is called from the other thread when the answer is there.
    pub fn ask(&mut self, question: Question, wake: impl FnOnce() + Send + 'static) {
        let (sender, receiver) = channel();
        self.waiting = Some(receiver);
        self.answer = None;
        std::thread::spawn(move || {
            // Nobody listens any more once something else is seen.
            if sender.send(answer(&question, default_cache())).is_ok() {
                wake();
            }
        });
    }

    /// Forgets what was asked: something else is seen.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// Takes the answer if it came.
    pub fn poll(&mut self) {
        match self.waiting.as_ref().map(Receiver::try_recv) {
            Some(Ok(answer)) => *self = Self { waiting: None, answer: Some(answer) },
            Some(Err(TryRecvError::Disconnected)) => self.waiting = None,
            Some(Err(TryRecvError::Empty)) | None => {}
        }
    }

    /// Whether an answer is being worked out.
    pub fn is_waiting(&self) -> bool {
        self.waiting.is_some()
    }
}

fn answer(q: &Question, cache: Option<PathBuf>) -> Answer {
    let states = cache.as_ref().and_then(|folder| std::fs::read_dir(folder).ok());
    let is_state = |e: std::io::Result<std::fs::DirEntry>| {
        e.is_ok_and(|e| e.path().extension().is_some_and(|extension| extension == "world"))
    };
    // Without any there is no need to trace first hits, which the name is made of.
    let (Some(folder), true) = (cache, states.is_some_and(|mut all| all.any(is_state))) else {
        return Answer::NoReference;
    };
    let world = World::new(&q.scene, &q.materials);
    let first_hits = FirstHits::trace(&world, &q.camera, q.extent);
    let reference = WorldReference { world: &world, first_hits: &first_hits, escape: q.escape, seed: 1 };
    let Ok(state) = reference.load(&kept_in(&folder, &reference)) else { return Answer::NoReference };
    let truth: Vec<[f32; 3]> = reference.image(&state).reflection.iter().map(Vec3::to_array).collect();
    let mask: Vec<bool> = first_hits.receivers.iter().map(Option::is_some).collect();
    let [width, height] = q.extent;
    let errors = |color: &Vec<[f32; 3]>| ImageErrors {
        rmse: masked_rmse(&truth, color, &mask),
        relative_mse: masked_relative_mse(&truth, color, &mask),
        flip: FlipMap::new(&display(&truth), &display(color), width, height).mean(),
    };
    Answer::Errors {
        samples: state.samples,
        standard_error: state.overall_standard_error(),
        methods: q.reflections.iter().map(errors).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::library;
    use crate::study::Globals;

    #[test]
    fn the_kept_reference_is_found_and_only_for_what_it_is_of() {
        let extent = [32, 18];
        let scene = Arc::new(library::scene("rooms").unwrap());
        let view = scene.views[0].clone();
        let globals = Globals { roughness: Some(0.0), ..Globals::default() };
        let materials = globals.materials(&scene, &view);
        let camera = view.camera(&scene, extent);
        let cache = tempfile::tempdir().unwrap();
        let black = vec![[0.0; 3]; 32 * 18];
        let question = |reflections, materials, escape| Question {
            scene: Arc::clone(&scene),
            materials,
            camera,
            extent,
            escape,
            reflections,
        };
        let ask = |q: &Question| answer(q, Some(cache.path().to_path_buf()));
        let first = question(vec![black.clone()], materials.clone(), Escape::Black);
        assert_eq!(ask(&first), Answer::NoReference);
        assert_eq!(answer(&first, None), Answer::NoReference);

        let world = World::new(&scene, &materials);
        let first_hits = FirstHits::trace(&world, &camera, extent);
        let reference = WorldReference { world: &world, first_hits: &first_hits, escape: Escape::Black, seed: 1 };
        let mut state = reference.start();
        reference.add(&mut state, 2);
        state.save(&kept_in(cache.path(), &reference)).unwrap();
        let truth: Vec<[f32; 3]> = reference.image(&state).reflection.iter().map(Vec3::to_array).collect();
        let answered = ask(&question(vec![truth, black], materials.clone(), Escape::Black));
        let Answer::Errors { samples: 2, methods, .. } = answered else { panic!("{answered:?}") };
        assert_eq!((methods[0].rmse, methods[0].relative_mse, methods[0].flip), (0.0, Some(0.0), 0.0));
        assert!(
            methods[1].rmse > 0.05
                && methods[1].relative_mse.is_some_and(|v| (v - 1.0).abs() < 1e-12)
                && methods[1].flip > 0.05,
            "{methods:?}"
        );

        assert_eq!(ask(&question(Vec::new(), materials, Escape::Environment)), Answer::NoReference);
        let rougher = Globals { roughness: Some(0.5), ..globals }.materials(&scene, &view);
        assert_eq!(ask(&question(Vec::new(), rougher, Escape::Black)), Answer::NoReference);
    }
}
