//! The cells and rows of the time study, with its tables, chart and CSV files.

use super::{LastShots, TimeSpec, frames_of_a_group, is_whole, keys, record_from_samples, recorded_variants, verdicts};
use crate::error::Result;
use crate::stage::Globals;
use crate::study::captions::{self, ReferenceTime};
use crate::study::cell_list::{CellList, ListedResult};
use crate::study::columns::{Column, ColumnSet, Columns, part};
use crate::study::compare::{TOTAL, shown_drift};
use crate::study::drift::drift;
use crate::study::engine::{Bench, Planned, Row, Study, rows_in_journal};
use crate::study::error::Variant;
use crate::study::exhibit::{Chart, Drawing, Sheet, StageBar, Table, distinct};
use crate::study::interleave::{self, Sample};
use crate::study::journal::{Journal, scene_digest};
use crate::study::names::{cell_name, roughness_name};
use crate::study::record::{Head, Provenance, TimeRecord};
use crate::study::table as table_5_8;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use ssct::gpu::{FrameReport, Gpu};
use ssct_scenes::{Scene, View};
use std::collections::BTreeSet;
use std::rc::Rc;

/// A job of the time study: variants on a view, at several sizes and with several sets of factors.
pub struct TimeJob {
    /// Scene.
    pub scene: Rc<Scene>,
    /// View of the scene.
    pub view: View,
    /// Methods with their parameters, timed in turn.
    pub variants: Vec<Variant>,
    /// Sizes in pixels.
    pub sizes: Vec<[u32; 2]>,
    /// Global factors.
    pub globals: Vec<Globals>,
    /// Whether the world reference on the CPU is timed, too.
    pub has_reference: bool,
}

/// Which of the thesis's figures times are compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename = "Beside")]
pub enum ThesisFigures {
    /// No figures.
    Nothing,
    /// Table 5.8.
    Table,
    /// The captions of the thesis's figures.
    Captions,
}

/// Settings that the tables of a run depend on, in addition to its cells.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct TimeSettings {
    /// Figures that the times are compared with.
    pub beside: ThesisFigures,
    /// Number of timed frames.
    pub samples: usize,
    /// Whether methods are timed against themselves.
    pub a_a: bool,
    /// Whether each setting gets a verdict against the first setting of its place, with which it was timed in turn.
    #[serde(default)]
    pub judges: bool,
}

impl TimeSettings {
    /// Reads the settings that a list of cells keeps; if they cannot be read, returns settings without samples.
    fn from_list(list: &CellList) -> Self {
        let none = Self { beside: ThesisFigures::Nothing, samples: 0, a_a: false, judges: false };
        Self::deserialize(&list.settings).unwrap_or(none)
    }
}

/// The time study.
pub struct TimeStudy {
    jobs: Vec<TimeJob>,
    /// Digest of each job's scene.
    digests: Vec<String>,
    settings: TimeSettings,
    /// Number of frames that warm up.
    warmup: usize,
    /// Rays a pixel of the world reference.
    reference_rays: u32,
    timer: LastShots,
}

/// A cell: a job at one size with one set of factors, in which all variants are timed, or the world reference.
pub struct TimeCell {
    /// Index of the job.
    job: usize,
    extent: [u32; 2],
    globals: Globals,
    /// Whether the world reference is timed, instead of the variants.
    is_reference: bool,
}

impl TimeStudy {
    /// Makes the study. `warmup` is the number of frames that warm up, and `reference_rays` the rays a pixel of the
    /// world reference.
    pub fn new(jobs: Vec<TimeJob>, settings: TimeSettings, warmup: usize, reference_rays: u32) -> Self {
        let digests = jobs.iter().map(|job| scene_digest(&job.scene)).collect();
        Self { jobs, digests, settings, warmup, reference_rays, timer: LastShots::default() }
    }
}

impl TimeJob {
    /// Returns the inputs by which this job is timed.
    fn spec<'a>(&'a self, gpu: &'a Gpu, warmup: usize, settings: &TimeSettings) -> TimeSpec<'a> {
        TimeSpec {
            gpu,
            scene: &self.scene,
            view: &self.view,
            variants: self.variants.clone(),
            sizes: self.sizes.clone(),
            globals: self.globals.clone(),
            warmup,
            samples: settings.samples,
            a_a: settings.a_a,
        }
    }

    /// Returns the name of the cell of a size and a set of factors.
    fn place(&self, extent: [u32; 2], globals: &Globals) -> String {
        cell_name(&self.scene.name, &self.view.name, extent, globals.roughness)
    }
}

impl Study for TimeStudy {
    type Cell = TimeCell;
    type Row = TimeRow;

    /// Returns the scenes of the jobs, each once, sorted by name.
    fn scenes(&self) -> Vec<&Scene> {
        let mut scenes: Vec<&Scene> = self.jobs.iter().map(|job| &*job.scene).collect();
        scenes.sort_by(|a, b| a.name.cmp(&b.name));
        scenes.dedup_by(|a, b| a.name == b.name);
        scenes
    }

    fn settings(&self) -> Value {
        json!(self.settings)
    }

    /// Lists the cells of all jobs; the cells that time the world reference come last.
    fn cells(&self) -> Vec<Planned<TimeCell>> {
        let (mut cells, mut references) = (Vec::new(), Vec::new());
        for (job_index, job) in self.jobs.iter().enumerate() {
            let (digest, view) = (&self.digests[job_index], format!("{:?}", job.view));
            for &extent in &job.sizes {
                for &globals in &job.globals {
                    let variants = recorded_variants(&job.variants, extent);
                    let TimeSettings { samples, a_a, .. } = self.settings;
                    let setup = json!([digest, view, globals, variants, self.warmup, samples, a_a]);
                    let time_cell = |is_reference| TimeCell { job: job_index, extent, globals, is_reference };
                    cells.push(Planned { name: job.place(extent, &globals), setup, cell: time_cell(false) });
                    if job.has_reference {
                        let setup = json!([digest, view, globals, extent, self.reference_rays]);
                        let name = format!("{}-reference", job.place(extent, &globals));
                        references.push(Planned { name, setup, cell: time_cell(true) });
                    }
                }
            }
        }
        cells.extend(references);
        cells
    }

    /// Returns one key for a cell of the reference. For any other cell, returns for each variant the beginning of its
    /// samples' keys and the head of its record.
    fn results(&self, gpu: &Gpu, planned: &Planned<TimeCell>) -> Vec<(String, Value)> {
        let cell = &planned.cell;
        if cell.is_reference {
            return vec![(planned.key::<TimeRow>(gpu), Value::Null)];
        }
        let spec = self.jobs[cell.job].spec(gpu, self.warmup, &self.settings);
        let group = spec.group(cell.extent, cell.globals, &self.digests[cell.job]);
        (0..spec.variants.len()).map(|n| (group.key_prefix(n), json!(group.head(n)))).collect()
    }

    fn steps(&self, cell: &TimeCell) -> usize {
        let TimeSettings { samples, a_a, .. } = self.settings;
        let variants = self.jobs[cell.job].variants.len();
        if cell.is_reference { 1 } else { frames_of_a_group(variants, self.warmup, samples, a_a) }
    }

    /// Times the reference and returns its row, or measures every sample that the journal lacks. No rows of samples are
    /// returned, since [`TimeRow::read`] makes them of the journal.
    fn measure(&mut self, cell: &TimeCell, bench: &mut Bench) -> Result<Vec<TimeRow>> {
        let job = &self.jobs[cell.job];
        if cell.is_reference {
            let Self { reference_rays: rays, .. } = self;
            let time = captions::time_reference(bench.gpu, &job.scene, &job.view, cell.extent, &cell.globals, *rays);
            return Ok(vec![TimeRow::Reference(Box::new(time))]);
        }
        let spec = job.spec(bench.gpu, self.warmup, &self.settings);
        let group = spec.group(cell.extent, cell.globals, &self.digests[cell.job]);
        let Bench { journal, go_on, advance, .. } = bench;
        let progress = &mut || {
            advance(1);
            go_on()
        };
        self.timer.time(cell.job, &group, journal, progress)?;
        Ok(Vec::new())
    }
}

/// A row of the time study: times of a method on the device, or of the reference on the CPU.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum TimeRow {
    /// The world reference.
    Reference(Box<ReferenceTime>),
    /// A method.
    Method(Box<TimeRecord>),
}

impl TimeRow {
    /// Returns the head of the record.
    fn head(&self) -> &Head {
        match self {
            Self::Reference(time) => &time.head,
            Self::Method(record) => &record.head,
        }
    }
}

/// Returns the records of methods among some rows.
fn method_records(rows: &[TimeRow]) -> Vec<TimeRecord> {
    let record = |row: &TimeRow| if let TimeRow::Method(record) = row { Some((**record).clone()) } else { None };
    rows.iter().filter_map(record).collect()
}

/// The columns are those of the head, and the median total of a method or the time of the reference.
impl Columns for TimeRow {
    fn columns() -> ColumnSet<Self> {
        let method_columns = TimeRecord::columns();
        let mut all = ColumnSet { times: method_columns.times, ranges: method_columns.ranges, ..ColumnSet::default() };
        part().add(("head", ""), Self::head, &mut all);
        let total_ms = |row: &Self| match row {
            Self::Reference(time) => time.wall_ms,
            Self::Method(record) => record.total.median_ms,
        };
        all.columns.push(Column::named("total.median_ms", total_ms));
        all
    }
}

impl Row for TimeRow {
    const KIND: &'static str = "time";
    const TITLE: &'static str = "Times";
    const IS_SAMPLED: bool = true;

    fn program(&self) -> &Provenance {
        &self.head().program
    }

    /// Makes the table of the thesis's figures beside the times, if it is asked for; the table of all times; and the
    /// table of verdicts, if it is asked for.
    fn tables(rows: &[Self], settings: &Value) -> Vec<Table> {
        let records = method_records(rows);
        let settings = TimeSettings::deserialize(settings).ok();
        let thesis_table = match settings.map_or(ThesisFigures::Nothing, |settings| settings.beside) {
            ThesisFigures::Nothing => None,
            ThesisFigures::Table => {
                let cells = table_5_8::cells(&table_5_8::compare(&records));
                let about = table_5_8::about();
                Some(Table { id: "table-5.8", title: table_5_8::TITLE.to_owned(), about, cells, ..Table::default() })
            }
            ThesisFigures::Captions => {
                let reference_time =
                    |row: &Self| if let Self::Reference(time) = row { Some((**time).clone()) } else { None };
                Some(captions::table(&records, &rows.iter().filter_map(reference_time).collect::<Vec<_>>()))
            }
        };
        let every = Table { id: "table", cells: time_cells(&records), ..Table::default() };
        let verdicts = settings.filter(|settings| settings.judges).and_then(|_| verdicts::table(&records));
        thesis_table.into_iter().chain([every]).chain(verdicts).collect()
    }

    /// Makes the chart of the stages of all methods.
    fn charts(rows: &[Self]) -> Vec<Chart> {
        vec![chart(&method_records(rows))]
    }

    /// Makes the file of raw samples, and the file of medians.
    fn sheets(rows: &[Self]) -> Vec<Sheet> {
        let records = method_records(rows);
        let sheet = |file: &str, about: &str, cells| Sheet { file: file.to_owned(), about: about.to_owned(), cells };
        vec![
            sheet(SAMPLES, "a row for each pass of each timed frame", sample_cells(&records)),
            sheet(MEDIANS, "a row for each group of passes", median_cells(&records)),
        ]
    }

    fn is_whole(list: &CellList, result: &ListedResult, journal: &Journal) -> bool {
        let TimeSettings { samples, a_a, .. } = TimeSettings::from_list(list);
        // The journal keeps a reference under one key, and each sample of a method under a key of its own.
        if result.record_head.is_null() {
            rows_in_journal::<Self>(journal, &result.key).is_some()
        } else {
            is_whole(&result.key, samples, a_a, journal)
        }
    }

    /// Reads the row of the reference, or makes the record of a method from its samples in the journal.
    fn read(list: &CellList, result: &ListedResult, journal: &Journal) -> Vec<Self> {
        let Ok(head) = Head::deserialize(&result.record_head) else {
            return rows_in_journal(journal, &result.key).unwrap_or_default();
        };
        let record = record_from_samples(head, &result.key, TimeSettings::from_list(list).samples, journal);
        record.map(|record| Self::Method(Box::new(record))).into_iter().collect()
    }
}

/// Name of the file of raw samples.
pub const SAMPLES: &str = "time-samples.csv";
/// Name of the file of medians, in which passes are grouped as in the printed table.
pub const MEDIANS: &str = "pass-medians.csv";
/// Names of the columns of the file of medians.
pub const MEDIAN_COLUMNS: [&str; 9] =
    ["scene", "view", "width", "height", "roughness", "method", "pass", "counted", "median_ms"];
/// Names of the first columns of the file of samples, which say what was measured; the columns of settings follow.
pub const PLACE: [&str; 3] = ["scene", "view", "method"];
/// Names of the last columns of the file of samples, behind the columns of settings, which have the measured values.
pub const MEASURED: [&str; 6] = ["sample", "pass", "counted", "ms", FLOORS[0], FLOORS[1]];
/// Names of the columns of the noise floors of the pass and of the total, whose cells are empty if they were not
/// measured.
pub const FLOORS: [&str; 2] = ["noise_floor", "total_noise_floor"];

/// Makes the cells of the file of samples, header first: a row for each pass of each sample, with a column for each
/// setting of any of the methods. The cell of a setting that a method does not have is empty.
pub fn sample_cells(records: &[TimeRecord]) -> Vec<Vec<String>> {
    let settings: BTreeSet<&String> = records.iter().flat_map(|r| r.head.setup.keys()).collect();
    let columns = settings.iter().map(|name| name.as_str());
    let mut cells: Vec<Vec<String>> =
        vec![PLACE.into_iter().chain(columns).chain(MEASURED).map(str::to_owned).collect()];
    for r in records {
        let place = [&r.head.scene, &r.head.view, &r.head.method].map(Clone::clone);
        let set: Vec<String> = settings.iter().map(|name| r.head.setting(name)).collect();
        for (n, pass_times) in r.samples.iter().enumerate() {
            for (pass, ms) in r.passes.iter().zip(pass_times) {
                let floor_text = |floor: Option<f64>| floor.map(|f| format!("{f:.6}")).unwrap_or_default();
                let (counted, ms) = (pass.counted.to_string(), format!("{ms:.6}"));
                let floors = [floor_text(pass.noise_floor), floor_text(r.noise_floor)];
                let measured = [n.to_string(), pass.name.clone(), counted, ms].into_iter().chain(floors);
                cells.push(place.iter().chain(&set).cloned().chain(measured).collect());
            }
        }
    }
    cells
}

/// Makes the cells of the file of medians, header first: for each record a row for each group of passes, first those
/// that do not count, and a row for the total. The column `method` has the name of the variant, as in the printed
/// table.
fn median_cells(records: &[TimeRecord]) -> Vec<Vec<String>> {
    let mut rows = vec![MEDIAN_COLUMNS.map(str::to_owned).to_vec()];
    for r in records {
        let Head { scene, view, width, height, .. } = &r.head;
        let place = [scene.clone(), view.clone(), width.to_string(), height.to_string(), r.head.setting("roughness")];
        let subject: Vec<String> = place.into_iter().chain([r.head.variant()]).collect();
        let groups = [false, true]
            .map(|counted| r.group_medians(counted).into_iter().map(move |(name, ms)| (name, counted, ms)));
        let total = (TOTAL.to_owned(), true, r.total.median_ms);
        let row = |(name, counted, ms): (String, bool, f64)| {
            [subject.clone(), vec![name, counted.to_string(), format!("{ms:.6}")]].concat()
        };
        rows.extend(groups.into_iter().flatten().chain([total]).map(row));
    }
    rows
}

/// Makes the cells of the table of all times, header first: for each record the medians of its stages, the statistics
/// of the total, and the median of the frame, in milliseconds. Drift and noise floor have columns if a record has any.
fn time_cells(records: &[TimeRecord]) -> Vec<Vec<String>> {
    let stages = distinct(records.iter().flat_map(|r| r.stages()).map(|(name, _)| name));
    let mut header: Vec<String> = ["scene view", "size", "roughness", "method"].map(str::to_owned).to_vec();
    header.extend(stages.iter().cloned());
    header.extend(["total ms", "min", "p95", "n", "frame ms"].map(str::to_owned));
    let drifts = drift(records);
    let has_drift = drifts.iter().any(Option::is_some);
    header.extend(has_drift.then(|| "drift".to_owned()));
    let has_floor = records.iter().any(|r| r.noise_floor.is_some());
    header.extend(has_floor.then(|| "floor".to_owned()));
    let mut rows = vec![header];
    for (r, drift) in records.iter().zip(drifts) {
        let mut row = vec![
            format!("{} {}", r.head.scene, r.head.view),
            format!("{}x{}", r.head.width, r.head.height),
            roughness_name(r.head.roughness),
            r.head.variant(),
        ];
        let stages_of_record = r.stages();
        row.extend(stages.iter().map(|stage| match stages_of_record.iter().find(|(name, _)| name == stage) {
            Some((_, ms)) => format!("{ms:.3}"),
            None => "-".into(),
        }));
        row.extend([r.total.median_ms, r.total.min_ms, r.total.p95_ms].map(|ms| format!("{ms:.3}")));
        row.extend([r.total.samples.to_string(), format!("{:.3}", r.frame.median_ms)]);
        row.extend(has_drift.then(|| shown_drift(drift)));
        let floor = r.noise_floor.map_or_else(|| "-".into(), |floor| format!("{:.1} %", floor * 100.0));
        row.extend(has_floor.then_some(floor));
        rows.push(row);
    }
    rows
}

/// Makes a chart with a bar for each record, which is divided into the medians of the effect's stages.
pub fn chart(records: &[TimeRecord]) -> Chart {
    let bar = |r: &TimeRecord| {
        let Head { scene, view, width, height, .. } = &r.head;
        let (variant, roughness) = (r.head.variant(), roughness_name(r.head.roughness));
        let label = format!("{variant}: {scene} {view}, {width} × {height}, roughness {roughness}");
        StageBar { label, stages: r.stages() }
    };
    Chart::new("time", "Where the time goes", Drawing::Bars(records.iter().map(bar).collect()))
}

/// A timed frame, with its method and a label.
pub struct TimedFrame {
    /// Name of the method.
    pub method: String,
    /// Size, roughness and number of the frame, in words.
    pub label: String,
    /// Times of the passes and of the host.
    pub report: FrameReport,
}

/// Returns every timed frame that a run's journal has, including those of the second series of each method.
pub fn frames(list: &CellList, journal: &Journal) -> Vec<TimedFrame> {
    let TimeSettings { samples, a_a, .. } = TimeSettings::from_list(list);
    let mut frames = Vec::new();
    for result in list.cells.iter().flat_map(|cell| &cell.results) {
        let Ok(head) = Head::deserialize(&result.record_head) else { continue };
        let roughness = head.roughness.map_or_else(|| "own roughness".to_owned(), |r| format!("roughness {r}"));
        // The last key is that of the frame whose work is counted, which is not timed.
        let keys = keys(&result.key, samples, a_a);
        for (n, key) in keys[..keys.len() - 1].iter().enumerate() {
            if let Some(Sample { report, .. }) = interleave::sample_in_journal(journal, key) {
                let label = format!("{}x{}, {roughness}, sample {n}", head.width, head.height);
                frames.push(TimedFrame { method: head.method.clone(), label, report });
            }
        }
    }
    frames
}
