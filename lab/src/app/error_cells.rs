//! The cells of the error study: scene, view, size and roughness. What `ssct error` and `ssct study`
//! share. A cell that the journal has is not measured again.

use super::run::{Last, go_on};
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::methods::{MethodInfo, Setup};
use crate::report::error_report::{self, stem};
use crate::scene::{Scene, View};
use crate::study::cell_list::{CellList, CellListHead, PlannedCell};
use crate::study::cost::CellCost;
use crate::study::cost_model::{CellShape, CostModel, CostParts};
use crate::study::error::{ErrorRecord, ErrorSpec, Variant, definitions_of, measure, sample_worlds};
use crate::study::journal::{Journal, scene_digest, setup_digest};
use crate::study::shard::{RayShare, RaysOfShard, Shard, Share, rays_of_shards};
use crate::study::{Globals, Stage};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

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
    /// Folders in which other runs left samples of the world references.
    pub references: Vec<PathBuf>,
}

/// A cell with its predicted cost.
pub struct PricedCell {
    /// The name of the cell, for people.
    pub name: String,
    /// The digest of the cell's setup, with its whole cost.
    pub share: Share,
    /// The parts of the cost.
    pub parts: CostParts,
    /// Bytes that the process holds, if they can be predicted.
    pub memory_bytes: Option<f64>,
    /// Rays a pixel of the references.
    pub rays: u32,
    /// Seconds to draw the cell for its references alone.
    pub drawn_s: f64,
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
            references: Vec::new(),
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
        // Every machine divides the study by the costs that are part of the program.
        let planned = |spec: ErrorSpec| {
            let cost = CostModel::kept().predict(&CellShape::of(&spec)).total_s();
            PlannedCell::new(stem_of(&spec), setup_of(&spec), cost, key(gpu, &spec))
        };
        Ok(CellList::new(head, gpu.info(), self.specs().map(planned).collect()))
    }

    /// The cells with the costs that a model predicts.
    pub fn priced(&self, model: &CostModel) -> Vec<PricedCell> {
        let price = |spec: ErrorSpec| {
            let shape = CellShape::of(&spec);
            let parts = model.predict(&shape);
            PricedCell {
                name: stem_of(&spec),
                share: Share { setup: setup_digest(&setup_of(&spec)), cost: parts.total_s() },
                parts,
                memory_bytes: model.memory_bytes(&shape),
                rays: spec.rays,
                drawn_s: model.drawn_s(spec.extent),
            }
        };
        self.specs().map(price).collect()
    }

    /// The costs of every cell that the journal has.
    pub fn costs(&self, gpu: &Gpu, journal: &Journal) -> Vec<CellCost> {
        self.specs().filter_map(|spec| journal.get(&cost_key(&key(gpu, &spec)))).collect()
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
                journal.put(cost_key(&key), &cell.cost)?;
                Ok(cell.records)
            })?;
            progress();
            go_on()?;
        }
        Ok(())
    }

    /// Takes a shard's rays of the world references, and keeps them in a folder. `progress` is called after each cell.
    ///
    /// # Errors
    /// [`Error::Stopped`] once a signal asked for it, and those of the device and of files.
    pub fn sample_references(
        &self,
        gpu: &Gpu,
        rays: &RaysOfShard,
        folder: &Path,
        progress: &mut dyn FnMut(),
    ) -> Result<()> {
        let specs: Vec<ErrorSpec> = self.specs().collect();
        let mut last = Last::default();
        for (cell, samples) in rays {
            let spec = &specs[*cell];
            let stage = last.of(&spec.scene.name, || Stage::new(gpu, spec.scene))?;
            sample_worlds(spec, stage, samples, folder, &mut go_on)?;
            progress();
        }
        Ok(())
    }

    /// The records of every cell that the journal has.
    pub fn records(&self, gpu: &Gpu, journal: &Journal) -> Vec<ErrorRecord> {
        self.specs().filter_map(|spec| journal.get::<Vec<ErrorRecord>>(&key(gpu, &spec))).flatten().collect()
    }

    fn specs(&self) -> impl Iterator<Item = ErrorSpec<'_>> {
        let (warmup, samples, rays) = (1, self.samples, self.rays);
        let (variants, references) = (&self.variants[..], &self.references[..]);
        self.scenes.iter().flat_map(move |(scene, views)| {
            let digest = scene_digest(scene);
            let sizes = |view| self.sizes.iter().map(move |&extent| (view, extent));
            let cells = views.iter().flat_map(sizes);
            let cells = cells.flat_map(|(view, extent)| self.globals.iter().map(move |&g| (view, extent, g)));
            cells.map(move |(view, extent, globals)| {
                let scene_digest = digest.clone();
                ErrorSpec { scene, view, extent, globals, variants, warmup, samples, rays, scene_digest, references }
            })
        })
    }
}

/// The rays of the world references that each of some shards takes, of cells with the costs that are part of the
/// program.
pub fn reference_rays(cells: &[PricedCell], of: u32) -> Vec<RaysOfShard> {
    let share = |of: &PricedCell| RayShare { setup: of.share.setup.clone(), cost: of.parts.world_s, rays: of.rays };
    rays_of_shards(&cells.iter().map(share).collect::<Vec<_>>(), of)
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

/// The key of a cell's cost in the journal, by the key of the cell.
pub fn cost_key(cell: &str) -> String {
    format!("cost of {cell}")
}
