//! The cells of the error study: scene, view, size and roughness. A cell is all variants, which are timed in turn.

use super::{ErrorRecord, ErrorSpec, Variant, measure, pictures};
use crate::error::Result;
use crate::scene::{Scene, View};
use crate::stage::{Globals, Stage};
use crate::study::engine::{Bench, Last, Planned, Study};
use crate::study::journal::scene_digest;
use crate::study::names::cell_name;
use serde_json::json;

/// Each view at each size with each of the global factors.
pub struct ErrorStudy {
    /// Scenes, each with its views and its digest.
    scenes: Vec<(Scene, Vec<View>, String)>,
    sizes: Vec<[u32; 2]>,
    globals: Vec<Globals>,
    variants: Vec<Variant>,
    samples: usize,
    rays: u32,
    stage: Last<usize, Stage>,
}

/// A cell: the numbers of its scene and of the view there, the size, and the factors.
pub type ErrorCell = (usize, usize, [u32; 2], Globals);

impl ErrorStudy {
    /// The study of some scenes with their views, of some variants, with so many timed frames of each, at least one, and
    /// so many rays a pixel of the references, at least two.
    pub fn new(
        scenes: Vec<(Scene, Vec<View>)>,
        sizes: Vec<[u32; 2]>,
        globals: Vec<Globals>,
        variants: Vec<Variant>,
        (samples, rays): (usize, u32),
    ) -> Self {
        let digested = |(scene, views): (Scene, Vec<View>)| {
            let digest = scene_digest(&scene);
            (scene, views, digest)
        };
        let scenes = scenes.into_iter().map(digested).collect();
        Self { scenes, sizes, globals, variants, samples, rays, stage: Last::default() }
    }

    fn spec(&self, &(scene, view, extent, globals): &ErrorCell) -> ErrorSpec<'_> {
        let (scene, views, digest) = &self.scenes[scene];
        ErrorSpec {
            scene,
            view: &views[view],
            extent,
            globals,
            variants: &self.variants,
            warmup: 1,
            samples: self.samples,
            rays: self.rays,
            scene_digest: digest.clone(),
        }
    }

    fn name(&self, &(scene, view, extent, globals): &ErrorCell) -> String {
        let (scene, views, _) = &self.scenes[scene];
        cell_name(&scene.name, &views[view].name, extent, globals.roughness)
    }
}

impl Study for ErrorStudy {
    type Cell = ErrorCell;
    type Row = ErrorRecord;

    fn scenes(&self) -> Vec<&Scene> {
        self.scenes.iter().map(|(scene, ..)| scene).collect()
    }

    fn cells(&self) -> Vec<Planned<ErrorCell>> {
        let mut cells = Vec::new();
        for (n, (_, views, _)) in self.scenes.iter().enumerate() {
            for view in 0..views.len() {
                for &size in &self.sizes {
                    cells.extend(self.globals.iter().map(|globals| (n, view, size, *globals)));
                }
            }
        }
        let planned = |cell: ErrorCell| {
            let setup = json!([self.spec(&cell).settings(), self.samples, self.rays]);
            Planned { name: self.name(&cell), setup, cell }
        };
        cells.into_iter().map(planned).collect()
    }

    fn measure(&mut self, cell: &ErrorCell, bench: &mut Bench) -> Result<Vec<ErrorRecord>> {
        let mut stages = std::mem::take(&mut self.stage);
        let spec = self.spec(cell);
        let stage = stages.of(cell.0, || Stage::new(bench.gpu, spec.scene))?;
        let go_on = bench.go_on;
        let made = measure(bench.gpu, &spec, stage, bench.journal, &mut || go_on())?;
        self.stage = stages;
        pictures::files(&self.name(cell), &made).iter().try_for_each(|file| (bench.keep)(file))?;
        Ok(made.records)
    }
}
