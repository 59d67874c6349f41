//! The cells of the error study: scene, view, size and roughness. What `ssct error` and `ssct study`
//! share. A cell that the journal has is not measured again.

use super::run::{Last, go_on};
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::methods::{MethodInfo, Setup};
use crate::report::error_report::{self, stem};
use crate::scene::{Scene, View};
use crate::study::cell_list::{CellList, CellListHead, PlannedCell};
use crate::study::error::{ErrorRecord, ErrorSpec, Variant, definitions_of, measure};
use crate::study::journal::{Journal, scene_digest};
use crate::study::shard::Shard;
use crate::study::{Globals, Stage};
use serde_json::{Value, json};
use std::path::Path;

/// Pixels of a quick study.
pub const QUICK_SIZE: [u32; 2] = [320, 180];
/// Views of a quick study.
pub const QUICK_VIEWS: usize = 2;
/// Roughness values of a quick study.
pub const QUICK_ROUGHNESS: [f32; 2] = [0.0, 0.1];

/// What is measured: each view at each size with each of the global factors.
pub struct Plan {
    /// Scenes, each with its views.
    pub scenes: Vec<(Scene, Vec<View>)>,
    /// Pixels.
    pub sizes: Vec<[u32; 2]>,
    /// Global factors.
    pub globals: Vec<Globals>,
    /// What is compared in every cell.
    pub variants: Vec<Variant>,
    /// Frames that count, for each variant.
    pub samples: usize,
    /// Rays a pixel of the references.
    pub rays: u32,
}

impl Plan {
    /// The quick study of a scene: two views, a mirror and a glossy one, methods as published.
    pub fn quick(scene: Scene, methods: &[&'static MethodInfo], samples: usize, rays: u32) -> Self {
        let of = |r| Globals { roughness: Some(r), reflectivity: 1.0, normal_deviation: None };
        let views = scene.views.iter().take(QUICK_VIEWS).cloned().collect();
        Self {
            scenes: vec![(scene, views)],
            sizes: vec![QUICK_SIZE],
            globals: QUICK_ROUGHNESS.map(of).to_vec(),
            variants: Variant::of(methods, &Setup::new(QUICK_SIZE)),
            samples,
            rays,
        }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.scenes.iter().map(|(_, views)| views.len()).sum::<usize>() * self.sizes.len() * self.globals.len()
    }

    /// The list of cells for a run on a device, of which a shard owns some; `command` is that of the whole study.
    ///
    /// # Errors
    /// [`Error::Usage`] if the variants follow several versions of the definitions.
    pub fn list(&self, gpu: &Gpu, shard: Option<Shard>, command: String) -> Result<CellList> {
        let scenes = self.scenes.iter().map(|(scene, _)| (scene.name.clone(), scene_digest(scene))).collect();
        let definitions = definitions_of(&self.variants)?;
        let head = CellListHead { kind: "error", definitions, command, shard, settings: Value::Null, scenes };
        let planned = |spec: ErrorSpec| PlannedCell::new(stem_of(&spec), setup_of(&spec), key(gpu, &spec));
        Ok(CellList::new(head, gpu.info(), self.specs().map(planned).collect()))
    }

    /// Measures every cell that the journal lacks; with a list, only those that this run owns. Pictures go into a
    /// folder, if there is one. `progress` is called after each cell.
    ///
    /// # Errors
    /// [`Error::Usage`] for too few samples or rays, [`Error::Stopped`] once a signal asked for it, and those of the
    /// device, of the journal and of files.
    pub fn measure(
        &self,
        gpu: &Gpu,
        journal: &mut Journal,
        list: Option<&CellList>,
        pictures: Option<&Path>,
        progress: &mut dyn FnMut(),
    ) -> Result<()> {
        if self.samples == 0 || self.rays < 2 {
            return Err(Error::Usage("--samples must be at least 1, and --rays at least 2".into()));
        }
        let mut last = Last::default();
        for (n, spec) in self.specs().enumerate() {
            if list.is_some_and(|list| !list.owns(n)) {
                continue;
            }
            let key = key(gpu, &spec);
            journal.get_or(&key, |journal| {
                let stage = last.of(&spec.scene.name, || Stage::new(gpu, spec.scene))?;
                let cell = measure(gpu, &spec, stage, journal, &mut go_on)?;
                if let Some(folder) = pictures {
                    error_report::write_strips(folder, &stem_of(&spec), &cell)?;
                }
                Ok(cell.records)
            })?;
            progress();
            go_on()?;
        }
        Ok(())
    }

    /// The records of every cell that the journal has.
    pub fn records(&self, gpu: &Gpu, journal: &Journal) -> Vec<ErrorRecord> {
        self.specs().filter_map(|spec| journal.get::<Vec<ErrorRecord>>(&key(gpu, &spec))).flatten().collect()
    }

    fn specs(&self) -> impl Iterator<Item = ErrorSpec<'_>> {
        let (warmup, samples, rays) = (1, self.samples, self.rays);
        let variants = &self.variants[..];
        self.scenes.iter().flat_map(move |(scene, views)| {
            let digest = scene_digest(scene);
            let sizes = |view| self.sizes.iter().map(move |&extent| (view, extent));
            let cells = views.iter().flat_map(sizes);
            let cells = cells.flat_map(|(view, extent)| self.globals.iter().map(move |&g| (view, extent, g)));
            cells.map(move |(view, extent, globals)| {
                let scene_digest = digest.clone();
                ErrorSpec { scene, view, extent, globals, variants, warmup, samples, rays, scene_digest }
            })
        })
    }
}

/// Everything that a cell depends on but the device and the program.
fn setup_of(spec: &ErrorSpec) -> Value {
    json!([spec.settings(), spec.samples, spec.rays])
}

fn stem_of(spec: &ErrorSpec) -> String {
    stem(&spec.scene.name, &spec.view.name, spec.extent, spec.globals.roughness)
}

/// Where the journal keeps a cell.
fn key(gpu: &Gpu, spec: &ErrorSpec) -> String {
    format!("error {} {} {} samples {} rays", stem_of(spec), spec.digest(gpu), spec.samples, spec.rays)
}
