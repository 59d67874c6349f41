//! Computes the errors of the shown methods against the world reference, if `ssct render --method reference` has cached
//! one for the same view, size and materials. Another thread looks up the reference and compares with it.

use glam::Vec3;
use ssct::methods::EffectParams;
use ssct_lab::app::reference::{default_cache, state_file};
use ssct_lab::study::compare::display;
use ssct_scenes::{Camera, Material, Scene};
use ssct_truth::metrics::flip::FlipMap;
use ssct_truth::metrics::image::{masked_relative_mse, masked_rmse};
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world::WorldReference;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// The input of a comparison.
pub struct ComparisonRequest {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The scene's materials in the view, with the global factors applied.
    pub materials: Vec<Material>,
    /// The camera.
    pub camera: Camera,
    /// Width and height in pixels.
    pub extent: [u32; 2],
    /// The parameters of the effect, of which only the number of bounces counts for the world reference.
    pub effect: EffectParams,
    /// The reflection colours of each method, before fade and reflectivity.
    pub reflections: Vec<Vec<[f32; 3]>>,
}

/// The result of a comparison.
#[derive(Debug, Clone, PartialEq)]
pub enum ComparisonOutcome {
    /// No reference for this view, size, number of bounces and these materials is cached.
    NoReference,
    /// A reference was found.
    Errors {
        /// Rays per pixel of the reference.
        samples: u32,
        /// The reference's own expected error, as an RMSE.
        standard_error: f64,
        /// The errors of each method.
        methods: Vec<ImageErrors>,
    },
}

/// The errors of a reflection colour over the reflecting pixels (docs/definitions.md, "Image error").
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageErrors {
    /// Root mean square error, linear.
    pub rmse: f64,
    /// Mean square error divided by the reference's mean square; `None` if that is 0.
    pub relative_mse: Option<f64>,
    /// Mean ꟻLIP error of the display images.
    pub flip: f64,
}

/// A comparison with the reference that is running or finished.
#[derive(Default)]
pub struct ReferenceComparison {
    /// Receives the outcome of the running comparison; `None` if none is running.
    waiting: Option<Receiver<ComparisonOutcome>>,
    /// The last outcome, unless the view has changed since.
    pub outcome: Option<ComparisonOutcome>,
}

impl ReferenceComparison {
    /// Starts a comparison on another thread. The thread calls `wake` when the outcome can be taken, unless the view
    /// has changed in the meantime.
    pub fn start(&mut self, request: ComparisonRequest, wake: impl FnOnce() + Send + 'static) {
        let (sender, receiver) = channel();
        self.waiting = Some(receiver);
        self.outcome = None;
        std::thread::spawn(move || {
            // Nobody receives the outcome if the view has changed in the meantime.
            if sender.send(compare(&request, default_cache())).is_ok() {
                wake();
            }
        });
    }

    /// Drops the comparison and its outcome, because the view has changed.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// Stores the outcome if it has arrived.
    pub fn poll(&mut self) {
        match self.waiting.as_ref().map(Receiver::try_recv) {
            Some(Ok(outcome)) => *self = Self { waiting: None, outcome: Some(outcome) },
            Some(Err(TryRecvError::Disconnected)) => self.waiting = None,
            Some(Err(TryRecvError::Empty)) | None => {}
        }
    }

    /// Returns whether a comparison is running.
    pub fn is_waiting(&self) -> bool {
        self.waiting.is_some()
    }
}

/// Compares the methods' reflections with the reference, if the cache folder has one.
fn compare(request: &ComparisonRequest, cache: Option<PathBuf>) -> ComparisonOutcome {
    let entries = cache.as_ref().and_then(|folder| std::fs::read_dir(folder).ok());
    let is_state = |entry: std::io::Result<std::fs::DirEntry>| {
        entry.is_ok_and(|entry| entry.path().extension().is_some_and(|extension| extension == "world"))
    };
    // If the cache is empty, the first hits, which determine the file's name, need not be traced.
    let (Some(folder), true) = (cache, entries.is_some_and(|mut entries| entries.any(is_state))) else {
        return ComparisonOutcome::NoReference;
    };
    let world = World::new(&request.scene, &request.materials);
    let first_hits = FirstHits::trace(&world, &request.camera, request.extent);
    let reference = WorldReference::new(&world, &first_hits, &request.camera, 1).with_bounces(request.effect.bounces);
    let Ok(state) = reference.load(&state_file(&folder, &reference)) else { return ComparisonOutcome::NoReference };
    let truth: Vec<[f32; 3]> = reference.image(&state).reflection.iter().map(Vec3::to_array).collect();
    let mask: Vec<bool> = first_hits.receivers.iter().map(Option::is_some).collect();
    let [width, height] = request.extent;
    let errors = |color: &Vec<[f32; 3]>| ImageErrors {
        rmse: masked_rmse(&truth, color, &mask),
        relative_mse: masked_relative_mse(&truth, color, &mask),
        flip: FlipMap::new(&display(&truth), &display(color), width, height).mean(),
    };
    ComparisonOutcome::Errors {
        samples: state.samples(),
        standard_error: state.overall_standard_error(),
        methods: request.reflections.iter().map(errors).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct::methods::Setup;
    use ssct_lab::stage::Globals;
    use ssct_scenes::library;

    #[test]
    fn the_cached_reference_is_found_only_for_its_own_inputs() {
        let extent = [32, 18];
        let scene = Arc::new(library::scene("rooms").unwrap());
        let view = scene.views[0].clone();
        let globals = Globals { roughness: Some(0.0), ..Globals::default() };
        let materials = globals.materials(&scene, &view);
        let camera = view.camera(&scene, extent);
        let cache = tempfile::tempdir().unwrap();
        let black = vec![[0.0; 3]; 32 * 18];
        let request = |reflections, materials, effect: EffectParams| ComparisonRequest {
            scene: Arc::clone(&scene),
            materials,
            camera,
            extent,
            effect,
            reflections,
        };
        let outcome = |inputs: &ComparisonRequest| compare(inputs, Some(cache.path().to_path_buf()));
        let effect = Setup::new(extent).effect();
        let first = request(vec![black.clone()], materials.clone(), effect);
        assert_eq!(outcome(&first), ComparisonOutcome::NoReference);
        assert_eq!(compare(&first, None), ComparisonOutcome::NoReference);

        let world = World::new(&scene, &materials);
        let first_hits = FirstHits::trace(&world, &camera, extent);
        let reference = WorldReference::new(&world, &first_hits, &camera, 1);
        let mut state = reference.start();
        reference.add(&mut state, 16);
        state.save(&state_file(cache.path(), &reference)).unwrap();
        let truth: Vec<[f32; 3]> = reference.image(&state).reflection.iter().map(Vec3::to_array).collect();
        let found = outcome(&request(vec![truth, black], materials.clone(), effect));
        let ComparisonOutcome::Errors { samples: 16, methods, .. } = found else { panic!("{found:?}") };
        assert_eq!((methods[0].rmse, methods[0].relative_mse, methods[0].flip), (0.0, Some(0.0), 0.0));
        assert!(
            methods[1].rmse > 0.05
                && methods[1].relative_mse.is_some_and(|v| (v - 1.0).abs() < 1e-12)
                && methods[1].flip > 0.05,
            "{methods:?}"
        );

        let twice = EffectParams { bounces: 2, ..effect };
        assert_eq!(outcome(&request(Vec::new(), materials, twice)), ComparisonOutcome::NoReference);
        let rougher = Globals { roughness: Some(0.5), ..globals }.materials(&scene, &view);
        assert_eq!(outcome(&request(Vec::new(), rougher, effect)), ComparisonOutcome::NoReference);
    }
}
