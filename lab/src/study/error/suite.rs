//! The cells of the error study: each is a view of a scene, at a size, with a set of factors, such as the roughness.

use super::{ErrorRecord, ErrorSpec, LoadedScene, Variant, measure, pictures};
use crate::error::Result;
use crate::stage::Globals;
use crate::study::engine::{Bench, LastMade, Planned, Study};
use crate::study::journal::scene_digest;
use crate::study::names::cell_name;
use serde_json::json;
use ssct_scenes::{Scene, View};

/// The error study: each view of each scene, at each size, with each set of global factors.
pub struct ErrorStudy {
    scenes: Vec<StudiedScene>,
    sizes: Vec<[u32; 2]>,
    globals: Vec<Globals>,
    /// Number of timed frames of each variant.
    samples: usize,
    /// Rays a pixel of the references.
    rays: u32,
    /// The scene of the last cell on the device, by its index.
    loaded_scene: LastMade<usize, LoadedScene>,
}

/// A scene of the study.
struct StudiedScene {
    scene: Scene,
    views: Vec<View>,
    /// Digest of the scene, which the keys of results include.
    digest: String,
    /// The variants whose methods find what they need in the scene.
    variants: Vec<Variant>,
}

/// A cell of the error study.
#[derive(Clone, Copy)]
pub struct ErrorCell {
    /// Index of the scene in the study.
    scene: usize,
    /// Index of the view among the views of the scene.
    view: usize,
    extent: [u32; 2],
    globals: Globals,
}

impl ErrorStudy {
    /// Makes the study of some scenes, each with its views, and of some variants. `samples` is the number of timed
    /// frames of a variant, at least one; `rays` is the number of rays a pixel of the references, at least two. A
    /// method is left out in a scene that lacks what it needs.
    pub fn new(
        scenes: Vec<(Scene, Vec<View>)>,
        sizes: Vec<[u32; 2]>,
        globals: Vec<Globals>,
        variants: Vec<Variant>,
        (samples, rays): (usize, u32),
    ) -> Self {
        let studied_scene = |(scene, views): (Scene, Vec<View>)| {
            let variants = variants.iter().filter(|v| v.method.unmet_needs(&scene).is_empty()).cloned().collect();
            StudiedScene { digest: scene_digest(&scene), scene, views, variants }
        };
        let scenes = scenes.into_iter().map(studied_scene).filter(|studied| !studied.variants.is_empty()).collect();
        Self { scenes, sizes, globals, samples, rays, loaded_scene: LastMade::default() }
    }

    /// Returns the inputs of a cell's measurement.
    fn spec(&self, &ErrorCell { scene, view, extent, globals }: &ErrorCell) -> ErrorSpec<'_> {
        let StudiedScene { scene, views, digest, variants } = &self.scenes[scene];
        ErrorSpec {
            scene,
            view: &views[view],
            extent,
            globals,
            variants,
            warmup: 1,
            samples: self.samples,
            rays: self.rays,
            scene_digest: digest.clone(),
        }
    }

    /// Returns the name of a cell, with which the names of its files begin.
    fn name(&self, &ErrorCell { scene, view, extent, globals }: &ErrorCell) -> String {
        let StudiedScene { scene, views, .. } = &self.scenes[scene];
        cell_name(&scene.name, &views[view].name, extent, globals.roughness)
    }
}

impl Study for ErrorStudy {
    type Cell = ErrorCell;
    type Row = ErrorRecord;

    fn scenes(&self) -> Vec<&Scene> {
        self.scenes.iter().map(|studied| &studied.scene).collect()
    }

    /// Lists a cell for each view of each scene, at each size, with each set of factors.
    fn cells(&self) -> Vec<Planned<ErrorCell>> {
        let mut cells = Vec::new();
        for (scene, studied) in self.scenes.iter().enumerate() {
            for view in 0..studied.views.len() {
                for &extent in &self.sizes {
                    cells.extend(self.globals.iter().map(|&globals| ErrorCell { scene, view, extent, globals }));
                }
            }
        }
        let planned = |cell: ErrorCell| {
            let setup = json!([self.spec(&cell).settings(), self.samples, self.rays]);
            Planned { name: self.name(&cell), setup, cell }
        };
        cells.into_iter().map(planned).collect()
    }

    /// Measures a cell, and keeps its pictures.
    fn measure(&mut self, cell: &ErrorCell, bench: &mut Bench) -> Result<Vec<ErrorRecord>> {
        let mut last_loaded = std::mem::take(&mut self.loaded_scene);
        let spec = self.spec(cell);
        let loaded_scene = last_loaded.get_or_make(cell.scene, || LoadedScene::new(bench.gpu, spec.scene))?;
        let go_on = bench.go_on;
        let measured = measure(bench.gpu, &spec, loaded_scene, bench.journal, &mut || go_on())?;
        self.loaded_scene = last_loaded;
        pictures::files(&self.name(cell), &measured).iter().try_for_each(|file| (bench.keep)(file))?;
        Ok(measured.records)
    }
}
