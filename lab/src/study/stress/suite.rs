//! The cells of the stress study: hard G-buffers, hard places of the camera and of captures, hard triangles, and
//! motions of the camera.

use super::captures::{self, CaptureCase};
use super::cases::{Case, cases};
use super::lineup::{SceneMethods, ScreenMethods};
use super::motion::{self, MOTIONS, MotionCell, MotionSpec};
use super::row::StressRow;
use super::trees::{self, TreeCase};
use super::{Place, StressRecord, moved, places, run, run_place};
use crate::error::{Error, Result};
use crate::study::engine::{Bench, LastMade, Planned, Study};
use crate::study::journal::scene_digest;
use serde_json::{Value, json};
use ssct::methods::{MethodInfo, Setup};
use ssct_scenes::{Scene, library};

/// Sizes in pixels of the images of cases with a scene: in a quick study, and in a whole study.
const SCENE_SIZES: [[u32; 2]; 2] = [[161, 91], [321, 181]];

/// Size in pixels of the images of cases with captures, and of cases with triangles.
const SMALL_SIZE: [u32; 2] = [161, 91];

/// Number of triangles of the largest case: in a quick study, and in a whole study.
const MOST_TRIANGLES: [usize; 2] = [20_000, 1_000_000];

/// Roughness values of the surfaces in the motions of the camera.
const MOTION_ROUGHNESS: [f32; 2] = [0.0, 0.1];

/// The stress study.
pub struct StressStudy {
    is_quick: bool,
    methods: Vec<&'static MethodInfo>,
    scenes: Vec<Scene>,
    cases: Vec<Case>,
    /// Places of the camera, with the index of their scene.
    places: Vec<(usize, Place)>,
    /// Cases of captures, with the index of their scene.
    captures: Vec<(usize, CaptureCase)>,
    /// Scenes of triangles.
    trees: Vec<TreeCase>,
    /// Motions in the first scene.
    motions: Vec<MotionCell>,
    /// The methods for G-buffers that were made last, with the size; later cells use them again.
    screen_methods: LastMade<[u32; 2], ScreenMethods>,
    /// The methods for a scene that were made last, with the name of the line-up; later cells use them again.
    scene_methods: LastMade<String, SceneMethods>,
}

/// A cell of the study, by its index among the cells of its kind.
#[derive(Debug, Clone, Copy)]
pub enum StressCell {
    /// A G-buffer.
    Case(usize),
    /// A place of the camera.
    Place(usize),
    /// Places of captures.
    Captures(usize),
    /// A scene of triangles.
    Tree(usize),
    /// A motion of the camera.
    Motion(usize),
}

impl StressStudy {
    /// Makes the study of some methods. The images are small and of one scene if `is_quick`. If `words` are given, only
    /// cases whose name contains them are run, and no motions.
    ///
    /// # Errors
    /// [`Usage`](ssct::Error::Usage) if no case has `words` in its name.
    pub fn new(methods: Vec<&'static MethodInfo>, is_quick: bool, words: Option<&str>) -> Result<Self> {
        let names = if is_quick { &library::names()[..1] } else { library::names() };
        let scenes: Vec<_> = names.iter().filter_map(|name| library::scene(name)).collect();
        let is_chosen = |name: &str| words.is_none_or(|words| name.contains(words));
        let indexed = || scenes.iter().enumerate();
        let places = indexed().flat_map(|(n, scene)| places(scene).into_iter().map(move |place| (n, place)));
        let captures = indexed().flat_map(|(n, scene)| captures::cases(scene).into_iter().map(move |case| (n, case)));
        // Motions play in the views of the first scene: in one view if quick, and in none if words are given.
        let views = match scenes.first() {
            Some(_) if words.is_none() && is_quick => 1,
            Some(scene) if words.is_none() => scene.views.len(),
            _ => 0,
        };
        let most_triangles = MOST_TRIANGLES[usize::from(!is_quick)];
        let view_and_roughness = (0..views).flat_map(|view| MOTION_ROUGHNESS.map(|roughness| (view, roughness)));
        let motions = view_and_roughness
            .flat_map(|(view, roughness)| MOTIONS.map(|motion| MotionCell { view, roughness, motion }));
        let study = Self {
            is_quick,
            methods,
            cases: cases(is_quick).into_iter().filter(|case| is_chosen(&case.name)).collect(),
            places: places.filter(|(_, place)| is_chosen(&place.name)).collect(),
            captures: captures.filter(|(_, case)| is_chosen(&case.name)).collect(),
            trees: trees::cases(most_triangles).into_iter().filter(|case| is_chosen(&case.name)).collect(),
            motions: motions.collect(),
            screen_methods: LastMade::default(),
            scene_methods: LastMade::default(),
            scenes,
        };
        match words {
            Some(words) if study.cells().is_empty() => {
                Err(Error::usage(format!("no case has {words:?} in its name; the page of a whole run lists all names")))
            }
            _ => Ok(study),
        }
    }

    /// Returns the size in pixels of the images of cases with a scene.
    fn scene_size(&self) -> [u32; 2] {
        SCENE_SIZES[usize::from(!self.is_quick)]
    }

    /// Returns the view and the settings of the motion with the index `n` among `motions`, which all play in the first
    /// scene.
    fn motion_spec(&self, n: usize) -> MotionSpec<'_> {
        let MotionCell { view, roughness, motion } = self.motions[n];
        let (extent, frames, rays) = if self.is_quick { ([160, 90], 3, 16) } else { ([320, 180], 6, 64) };
        MotionSpec { view: &self.scenes[0].views[view], motion, extent, roughness, frames, rays, against_world: false }
    }

    /// Returns the name of a cell.
    fn name(&self, cell: StressCell) -> String {
        match cell {
            StressCell::Case(n) => self.cases[n].name.clone(),
            StressCell::Place(n) => self.places[n].1.name.clone(),
            StressCell::Captures(n) => self.captures[n].1.name.clone(),
            StressCell::Tree(n) => self.trees[n].name.clone(),
            StressCell::Motion(n) => self.motion_spec(n).name(&self.scenes[0]),
        }
    }
}

/// Makes rows of the records of cases.
fn case_rows(records: Vec<StressRecord>) -> Vec<StressRow> {
    records.into_iter().map(|record| StressRow::Case(Box::new(record))).collect()
}

impl Study for StressStudy {
    type Cell = StressCell;
    type Row = StressRow;

    fn scenes(&self) -> Vec<&Scene> {
        self.scenes.iter().collect()
    }

    fn settings(&self) -> Value {
        json!({ "quick": self.is_quick })
    }

    /// Lists every case as a cell. The setup of a cell has its name, the methods and the digests of the scenes; the
    /// program's version, which the engine knows, stands for all other properties.
    fn cells(&self) -> Vec<Planned<StressCell>> {
        let setup = Setup::on_screen(self.scene_size());
        let set: Vec<_> = self.methods.iter().map(|m| (m.name, setup.recorded(Some(m)))).collect();
        let digests: Vec<String> = self.scenes.iter().map(scene_digest).collect();
        let cases = (0..self.cases.len()).map(StressCell::Case);
        let cells = cases
            .chain((0..self.places.len()).map(StressCell::Place))
            .chain((0..self.captures.len()).map(StressCell::Captures))
            .chain((0..self.trees.len()).map(StressCell::Tree))
            .chain((0..self.motions.len()).map(StressCell::Motion));
        let planned = |cell| {
            let name = self.name(cell);
            Planned { setup: json!([name, set, digests]), name, cell }
        };
        cells.map(planned).collect()
    }

    /// Runs a cell. The methods of the last cell are used again if they were made for the same size or scene.
    fn measure(&mut self, cell: &StressCell, bench: &mut Bench) -> Result<Vec<StressRow>> {
        let gpu = bench.gpu;
        // Only one of the two kinds of methods is kept, since both need much memory.
        match cell {
            StressCell::Case(_) => self.scene_methods.forget(),
            _ => self.screen_methods.forget(),
        }
        let mut scene_lineup = std::mem::take(&mut self.scene_methods);
        let rows = match *cell {
            StressCell::Case(n) => {
                let Self { cases, methods, screen_methods, .. } = self;
                let extent = cases[n].extent();
                let lineup = screen_methods.get_or_make(extent, || ScreenMethods::new(gpu, extent, methods))?;
                case_rows(run(gpu, &cases[n], lineup)?)
            }
            StressCell::Place(n) => {
                let (scene_index, place) = &self.places[n];
                let scene = &self.scenes[*scene_index];
                let setup = Setup::on_screen(self.scene_size());
                let make = || SceneMethods::with_hits(gpu, moved(scene, place), &setup, &self.methods);
                let lineup = scene_lineup.get_or_make(format!("place {scene_index} {}", place.offset), make)?;
                case_rows(run_place(gpu, place, lineup)?)
            }
            StressCell::Captures(n) => {
                let (scene_index, case) = &self.captures[n];
                let methods: Vec<_> = self.methods.iter().copied().filter(|m| m.takes_captures).collect();
                let make = || case.lineup(gpu, &self.scenes[*scene_index], SMALL_SIZE, &methods);
                let lineup = scene_lineup.get_or_make(format!("captures {scene_index} {:?}", case.key()), make)?;
                case_rows(captures::run(gpu, case, lineup)?)
            }
            StressCell::Tree(n) => {
                let methods: Vec<_> = self.methods.iter().copied().filter(|m| m.takes_triangles).collect();
                case_rows(trees::run(gpu, &self.trees[n], SMALL_SIZE, &methods)?)
            }
            StressCell::Motion(n) => {
                let (spec, scene) = (self.motion_spec(n), &self.scenes[0]);
                let make = || SceneMethods::new(gpu, scene.clone(), &Setup::on_screen(spec.extent), &self.methods);
                let lineup = scene_lineup.get_or_make(format!("motion {:?}", spec.extent), make)?;
                let records = motion::run(gpu, &spec, lineup, &mut bench.go_on)?;
                records.into_iter().map(|record| StressRow::Motion(Box::new(record))).collect()
            }
        };
        self.scene_methods = scene_lineup;
        Ok(rows)
    }
}
