//! The cells of the error study: scene, view, size and roughness. What `ssct error` and `ssct study`
//! share. A cell that the journal has is not measured again.

use super::error_options::ErrorOptions;
use super::run::{command_line, go_on};
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::methods::{MethodInfo, Setup};
use crate::report::error_report::{self, stem};
use crate::scene::{Scene, View};
use crate::study::cell_list::{CellList, CellListHead, PlannedCell};
use crate::study::cost::CellCost;
use crate::study::cost_model::{CellShape, CostModel, CostParts};
use crate::study::error::{ErrorRecord, ErrorSpec, Variant, definitions_of, measure, sample_worlds};
use crate::study::journal::{Journal, scene_digest};
use crate::study::shard::{RayShare, Shard, rays_of_shards};
use crate::study::{Globals, Stage};
use serde_json::{Value, json};
use std::ops::Range;
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
    /// Folders of samples of world references that other runs took.
    pub references: Vec<PathBuf>,
}

/// A cell with what it is predicted to cost.
pub struct PricedCell {
    /// The cell.
    pub cell: PlannedCell,
    /// The parts of its cost.
    pub parts: CostParts,
    /// Bytes that the process holds, if that is known.
    pub memory_bytes: Option<f64>,
    /// Rays a pixel of its references.
    pub rays: u32,
    /// Seconds to draw it for its references alone.
    pub drawn_s: f64,
}

impl Plan {
    /// The quick study of a scene: two views, a mirror and a glossy one, methods as published.
    pub fn quick(scene: Scene, methods: &[&'static MethodInfo], samples: usize, rays: u32) -> Self {
        let of = |r| Globals { roughness: Some(r), reflectivity: 1.0, normal_deviation: None };
        let variant = |method: &&'static MethodInfo| Variant { method, setup: Setup::new(QUICK_SIZE) };
        let views = scene.views.iter().take(QUICK_VIEWS).cloned().collect();
        Self {
            scenes: vec![(scene, views)],
            sizes: vec![QUICK_SIZE],
            globals: QUICK_ROUGHNESS.map(of).to_vec(),
            variants: methods.iter().map(variant).collect(),
            samples,
            rays,
            references: Vec::new(),
        }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.scenes.iter().map(|(_, views)| views.len()).sum::<usize>() * self.sizes.len() * self.globals.len()
    }

    /// The cells for a run on a device, of which a shard owns some; `command` is that of the whole study.
    ///
    /// # Errors
    /// [`Error::Usage`] if the variants are of several versions of the definitions.
    pub fn list(&self, gpu: &Gpu, shard: Option<Shard>, command: String) -> Result<CellList> {
        let scenes = self.scenes.iter().map(|(scene, _)| (scene.name.clone(), scene_digest(scene))).collect();
        let definitions = definitions_of(&self.variants)?;
        let head = CellListHead { kind: "error", definitions, command, shard, settings: Value::Null, scenes };
        Ok(CellList::new(head, gpu.info(), self.planned(Some(gpu))))
    }

    /// The cells with what they are predicted to cost by the costs that are part of the program; without a device nobody
    /// knows where a journal keeps them.
    fn planned(&self, gpu: Option<&Gpu>) -> Vec<PlannedCell> {
        let planned = |spec: ErrorSpec| {
            let setup = json!([spec.settings(), spec.samples, spec.rays]);
            let key = gpu.map(|gpu| key(gpu, &spec)).unwrap_or_default();
            let cost = CostModel::kept().predict(&CellShape::of(&spec)).total_s();
            PlannedCell::new(stem_of(&spec), setup, cost, key)
        };
        self.specs().map(planned).collect()
    }

    /// The cells with what they are predicted to cost by a model.
    pub fn priced(&self, model: &CostModel) -> Vec<PricedCell> {
        let price = |(cell, spec): (PlannedCell, ErrorSpec)| {
            let shape = CellShape::of(&spec);
            let (parts, memory_bytes) = (model.predict(&shape), model.memory_bytes(&shape));
            PricedCell { cell, parts, memory_bytes, rays: spec.rays, drawn_s: model.drawn_s(spec.extent) }
        };
        self.planned(None).into_iter().zip(self.specs()).map(price).collect()
    }

    /// How long the parts of every cell that the journal has took.
    pub fn costs(&self, gpu: &Gpu, journal: &Journal) -> Vec<CellCost> {
        self.specs().filter_map(|spec| journal.get(&cost_key(&key(gpu, &spec)))).collect()
    }

    /// Measures every cell that the journal lacks, of a list those that are its own; pictures go into a folder, where
    /// there is one. `progress` is called after each cell, `go_on` between the steps of one; the error of either ends the
    /// study.
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
        let mut stage: Option<(&str, Stage)> = None;
        for (n, spec) in self.specs().enumerate() {
            if list.is_some_and(|list| !list.owns(n)) {
                continue;
            }
            let key = key(gpu, &spec);
            // Of one scene at a time.
            stage = stage.filter(|(scene, _)| *scene == spec.scene.name);
            journal.get_or(&key, |journal| {
                let (_, stage) = match &mut stage {
                    Some(stage) => stage,
                    none => none.insert((&spec.scene.name, Stage::new(gpu, spec.scene)?)),
                };
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

    /// Takes the rays of the world references that a shard has, and keeps them in a folder. `progress` is called after
    /// each cell.
    pub fn sample_references(
        &self,
        gpu: &Gpu,
        rays: &[(usize, Range<u32>)],
        folder: &Path,
        progress: &mut dyn FnMut(),
    ) -> Result<()> {
        let specs: Vec<ErrorSpec> = self.specs().collect();
        let mut stage: Option<(&str, Stage)> = None;
        for (cell, samples) in rays {
            let spec = &specs[*cell];
            stage = stage.filter(|(scene, _)| *scene == spec.scene.name);
            let (_, stage) = match &mut stage {
                Some(stage) => stage,
                none => none.insert((&spec.scene.name, Stage::new(gpu, spec.scene)?)),
            };
            sample_worlds(spec, stage, samples, folder, &mut go_on)?;
            progress();
        }
        Ok(())
    }

    /// The rays of the world references of each of some shards.
    pub fn reference_rays(&self, of: u32) -> Vec<Vec<(usize, Range<u32>)>> {
        let priced = self.priced(CostModel::kept());
        let share = |of: &PricedCell| RayShare { setup: of.cell.share().setup, cost: of.parts.world_s, rays: of.rays };
        rays_of_shards(&priced.iter().map(share).collect::<Vec<_>>(), of)
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

/// What the list of cells of a study of one scene is of: `ssct error` in one of its other kinds.
pub fn list_head(kind: &'static str, options: &ErrorOptions, setup: &Setup, scene: &Scene) -> CellListHead {
    CellListHead {
        kind,
        definitions: setup.effect().definitions.into(),
        command: command_line(),
        shard: options.shard.shard,
        settings: Value::Null,
        scenes: vec![(scene.name.clone(), scene_digest(scene))],
    }
}

fn stem_of(spec: &ErrorSpec) -> String {
    stem(&spec.scene.name, &spec.view.name, spec.extent, spec.globals.roughness)
}

/// Where the journal keeps a cell.
fn key(gpu: &Gpu, spec: &ErrorSpec) -> String {
    format!("error {} {} {} samples {} rays", stem_of(spec), spec.digest(gpu), spec.samples, spec.rays)
}

/// Where the journal keeps how long the parts of a cell took, by where it keeps the cell.
pub fn cost_key(cell: &str) -> String {
    format!("cost of {cell}")
}
