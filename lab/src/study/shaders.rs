//! The study of compiled programs: for the programs that methods run, the registers, instructions, occupancy and other
//! statistics that the driver reports (VK_KHR_pipeline_executable_properties). A device that only compiles
//! ([`ssct::gpu::DeviceQuery::compiles_only`]) is enough, so that the hardware need not be in the machine.

pub mod compare;
pub mod kinds;

use super::columns::{columns, part, series, time};
use super::engine::{Bench, LastMade, Planned, Row, Study};
use super::error::Variant;
use super::exhibit::{Table, distinct};
use super::journal::scene_digest;
use super::names::{cell_name, roughness_name};
use super::record::{Head, Provenance, RecordSubject};
use crate::error::Result;
use crate::stage::{Globals, Shot, Stage};
use glam::{Mat4, Vec3};
use kinds::{Fold, Kind};
use serde_json::{Value, json};
use ssct::gpu::executables::{CompiledProgram, Executable};
use ssct::gpu::frame::Mode;
use ssct::methods::Wants;
use ssct_scenes::{Scene, View};

/// Number of frames of a camera at rest that are recorded: one program begins a history, and another continues it.
const FRAMES_AT_REST: usize = 2;
/// Motion of the camera, in metres, before the frame that follows the frames at rest. A history runs another program
/// where the camera moves.
const MOVED_M: f32 = 0.01;

/// The study of compiled programs: scene, view and variants whose frames run the programs.
pub struct ShadersStudy {
    /// Scene.
    pub scene: Scene,
    /// View.
    pub view: View,
    /// Methods with their parameters.
    pub variants: Vec<Variant>,
    /// Width and height in pixels. Few programs depend on the size.
    pub extent: [u32; 2],
    /// Global factors. A roughness decides which programs a method runs.
    pub globals: Vec<Globals>,
    /// The scene on the device, once it was uploaded.
    pub stage: LastMade<(), Stage>,
}

columns! {
    /// A number that the driver states.
    pub struct ShaderStatistic {
        /// The driver's name of the number.
        pub name: String = time(""),
        /// Meaning of the number, in the driver's words.
        pub about: String = time(""),
        /// The number.
        pub value: f64 = time(""),
    }
}

columns! {
    /// The result of compiling one stage of one program.
    pub struct ShaderRecord {
        /// Scene, view, method and setup of the frames that run the program.
        #[serde(flatten)]
        pub head: Head = part(),
        /// When the program runs: "frame"; "frame at rest" if frames of a camera that moves do not run the program; or
        /// "prepare" if the program runs once before the first frame.
        pub runs_in: String = time("runs in"),
        /// Labels of the passes that run the program, with commas between them.
        pub passes: String = time(""),
        /// The program: the path of its shader under shaders-glsl/, and the macros that are defined for the program.
        pub program: String = time("program"),
        /// The stage, such as "compute".
        pub stage: String = time("stage"),
        /// Ids of the specialization constants and their bits, such as "0=1 3=2".
        pub constants: String = time(""),
        /// Invocations of a subgroup.
        pub subgroup_size: u32 = time("subgroup"),
        /// Statistics of the driver, in the driver's order.
        pub statistics: Vec<ShaderStatistic> = series(),
    }
}

impl ShaderRecord {
    /// Returns the value of a statistic, by the driver's name.
    pub fn statistic(&self, name: &str) -> Option<f64> {
        self.statistics.iter().find(|s| s.name == name).map(|s| s.value)
    }

    /// Returns the names of the variant and of its roughness, which tell the frames of a run apart.
    fn variant_and_roughness(&self) -> (String, String) {
        (self.head.variant(), roughness_name(self.head.roughness))
    }

    /// Returns the values that tell the record from the others of a run: variant, roughness, when the program runs,
    /// program, constants and stage.
    pub fn identity(&self) -> [String; 6] {
        let Self { runs_in, program, constants, stage, .. } = self;
        let (variant, roughness) = self.variant_and_roughness();
        [variant, roughness, runs_in.clone(), program.clone(), constants.clone(), stage.clone()]
    }
}

/// Returns the names of some records' statistics, in the driver's order, without those that only identify code.
fn statistic_names(records: &[ShaderRecord]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for statistic in records.iter().flat_map(|r| &r.statistics) {
        if Kind::named(&statistic.name) != Kind::Digest && !names.contains(&statistic.name) {
            names.push(statistic.name.clone());
        }
    }
    names
}

/// Returns the text of a statistic in tables: without digits behind the point if it is whole, and a dash if it is
/// missing.
fn statistic_text(value: Option<f64>) -> String {
    match value {
        Some(value) if value.fract() == 0.0 => format!("{value:.0}"),
        Some(value) => format!("{value:.2}"),
        None => "-".into(),
    }
}

const ABOUT_FRAMES: &str = "What the programs of one frame come to while the camera moves: each program once, however many \
    passes run it. Counts of instructions and cycles are sums, registers and memory the greatest of a program, and subgroups \
    that fit the least.";

const ABOUT_PROGRAMS: &str = "Every program, by the driver's own names of what it counts (docs/devices.md says what they are \
    called elsewhere). Programs that run before the first frame are made once. With a history, frames of a camera at rest \
    run another program than those of one that moves.";

impl Row for ShaderRecord {
    const KIND: &'static str = "shaders";
    const TITLE: &'static str = "What the compiler made of each program";

    fn program(&self) -> &Provenance {
        &self.head.program
    }

    /// Makes the tables of whole frames, of the programs of frames, and of all programs.
    fn tables(rows: &[Self], _settings: &Value) -> Vec<Table> {
        let names = statistic_names(rows);
        let main: Vec<&String> = names.iter().filter(|name| Kind::named(name).is_main()).collect();
        let every =
            Table::new("programs", "Programs", ABOUT_PROGRAMS, program_cells(rows, &names.iter().collect::<Vec<_>>()));
        vec![
            Table::new("frames", "Frames", ABOUT_FRAMES, frame_cells(rows, &main)),
            Table::new("main", "Programs of frames", "", frame_program_cells(rows, &main)),
            Table { is_large: true, ..every },
        ]
    }
}

/// Makes the cells of a table with a line for each variant and roughness, which combines the statistics `names` over
/// the programs of a frame.
fn frame_cells(rows: &[ShaderRecord], names: &[&String]) -> Vec<Vec<String>> {
    let folded: Vec<(&String, Fold)> =
        names.iter().filter_map(|name| Some((*name, Kind::named(name).fold()?))).collect();
    let header = ["method", "roughness", "programs"].map(str::to_owned).into_iter();
    let mut cells = vec![header.chain(folded.iter().map(|(name, _)| (*name).clone())).collect()];
    for (variant, roughness) in distinct(rows.iter().map(ShaderRecord::variant_and_roughness)) {
        let is_here = |r: &&ShaderRecord| r.variant_and_roughness() == (variant.clone(), roughness.clone());
        let frame_programs: Vec<&ShaderRecord> = rows.iter().filter(|r| r.runs_in == FRAME && is_here(r)).collect();
        let value = |(name, fold): &(&String, Fold)| {
            statistic_text(frame_programs.iter().filter_map(|r| r.statistic(name)).reduce(|a, b| fold.join(a, b)))
        };
        let count = frame_programs.len().to_string();
        cells.push([variant, roughness, count].into_iter().chain(folded.iter().map(value)).collect());
    }
    cells
}

/// Makes the cells of a table with a line for each program that frames run, and columns for the statistics `names`.
/// Programs whose lines are equal share one line.
fn frame_program_cells(rows: &[ShaderRecord], names: &[&String]) -> Vec<Vec<String>> {
    let header = ["program", "constants", "stage", "subgroup"].map(str::to_owned).into_iter();
    let mut cells: Vec<Vec<String>> = vec![header.chain(names.iter().map(|name| (*name).clone())).collect()];
    for r in rows.iter().filter(|r| r.runs_in != PREPARE) {
        let labels = [r.program.clone(), r.constants.clone(), r.stage.clone(), r.subgroup_size.to_string()];
        let row: Vec<String> =
            labels.into_iter().chain(names.iter().map(|name| statistic_text(r.statistic(name)))).collect();
        if !cells.contains(&row) {
            cells.push(row);
        }
    }
    cells
}

/// Makes the cells of a table with a line for each record, and columns for the statistics `names`.
fn program_cells(rows: &[ShaderRecord], names: &[&String]) -> Vec<Vec<String>> {
    let labels = ["method", "roughness", "runs in", "program", "constants", "stage", "subgroup", "passes"];
    let header = labels.map(str::to_owned).into_iter();
    let mut cells = vec![header.chain(names.iter().map(|name| (*name).clone())).collect()];
    for r in rows {
        let labels = r.identity().into_iter().chain([r.subgroup_size.to_string(), r.passes.clone()]);
        cells.push(labels.chain(names.iter().map(|name| statistic_text(r.statistic(name)))).collect());
    }
    cells
}

/// The program runs in frames of a camera that moves.
const FRAME: &str = "frame";
/// The program runs in frames of a camera at rest alone.
const FRAME_AT_REST: &str = "frame at rest";
/// The program runs once, before the first frame.
const PREPARE: &str = "prepare";

impl Study for ShadersStudy {
    type Cell = (usize, Globals);
    type Row = ShaderRecord;

    fn scenes(&self) -> Vec<&Scene> {
        vec![&self.scene]
    }

    /// Lists a cell for each variant, by its index, and each set of factors.
    fn cells(&self) -> Vec<Planned<Self::Cell>> {
        let digest = scene_digest(&self.scene);
        let planned = |(index, globals): (usize, &Globals)| {
            let variant = &self.variants[index];
            let place = cell_name(&self.scene.name, &self.view.name, self.extent, globals.roughness);
            Planned {
                name: format!("{place} {} {index}", variant.method.name),
                setup: json!([digest, format!("{:?}", self.view), variant.settings(self.extent), globals]),
                cell: (index, *globals),
            }
        };
        let pairs = (0..self.variants.len()).flat_map(|n| self.globals.iter().map(move |globals| (n, globals)));
        pairs.map(planned).collect()
    }

    /// Compiles the programs of a variant, and makes a record of each stage of each program.
    fn measure(&mut self, &(variant, globals): &Self::Cell, bench: &mut Bench) -> Result<Vec<ShaderRecord>> {
        let stage = self.stage.get_or_make((), || Stage::new(bench.gpu, &self.scene))?;
        compiled(stage, (&self.scene, &self.view), &self.variants[variant], self.extent, &globals)
    }
}

/// Compiles the programs of a variant, and makes a record of each stage of each program. Some programs prepare the
/// variant, some run in a frame whose camera moved, and some run in frames at rest alone. `stage` has the scene, on a
/// device that only compiles.
///
/// # Errors
/// [`Usage`](ssct::Error::Usage) on a device that was opened for something else, and errors of the driver.
pub fn compiled(
    stage: &mut Stage,
    (scene, view): (&Scene, &View),
    Variant { method, setup }: &Variant,
    extent: [u32; 2],
    globals: &Globals,
) -> Result<Vec<ShaderRecord>> {
    let (gpu, setup) = (stage.context.gpu().clone(), setup.with_extent(extent));
    // Discards programs that were compiled before for something else.
    gpu.take_programs()?;
    let (camera, materials) = (view.camera(scene, extent), globals.materials(scene, view));
    let mut shot = Shot::new(stage, method, &setup, Wants::IMAGE, camera, materials)?;
    let prepared = gpu.take_programs()?;
    for _ in 0..FRAMES_AT_REST {
        stage.run(&shot, Mode::Plain)?;
    }
    let mut at_rest = gpu.take_programs()?;
    shot.camera.world_to_view = Mat4::from_translation(Vec3::X * MOVED_M) * camera.world_to_view;
    stage.run(&shot, Mode::Plain)?;
    let mut in_motion = gpu.take_programs()?;
    in_motion.retain(|p| p.counted);
    let runs_at_rest_alone =
        |p: &CompiledProgram| in_motion.iter().all(|m| (&m.program, &m.constants) != (&p.program, &p.constants));
    at_rest.retain(|p| p.counted && runs_at_rest_alone(p));
    let head = Head::new("shaders", &gpu, (scene, view), RecordSubject::Method(method), &setup, globals);
    let all = [(FRAME, &in_motion), (FRAME_AT_REST, &at_rest), (PREPARE, &prepared)];
    Ok(all.into_iter().flat_map(|(runs_in, programs)| records(&head, runs_in, programs)).collect())
}

impl ShaderRecord {
    /// Makes a table with the main statistics of the programs that frames run; programs whose lines are equal share one
    /// line.
    pub fn table(records: &[Self]) -> Table {
        let names = statistic_names(records);
        let main: Vec<&String> = names.iter().filter(|name| Kind::named(name).is_main()).collect();
        Table::new("shaders", "Programs", ABOUT_PROGRAMS, frame_program_cells(records, &main))
    }
}

/// Makes a record for each stage of each program, in the order in which the programs first ran. A program that several
/// passes run has one record, which lists these passes.
fn records(head: &Head, runs_in: &str, programs: &[CompiledProgram]) -> Vec<ShaderRecord> {
    let mut all: Vec<ShaderRecord> = Vec::new();
    for program in programs {
        for executable in program.executables.iter().filter(|e| is_listed(program, e)) {
            let new = record(head, runs_in, program, executable);
            match all.iter_mut().find(|known| known.identity() == new.identity()) {
                Some(known) if known.passes.split(", ").any(|pass| pass == program.pass) => {}
                Some(known) => known.passes += &format!(", {}", program.pass),
                None => all.push(new),
            }
        }
    }
    all
}

/// Whether a stage of a program gets a record. The vertex stage of a program with a fragment stage gets none: its only
/// work is a triangle that covers the targets.
fn is_listed(program: &CompiledProgram, executable: &Executable) -> bool {
    executable.stage != "vertex" || program.executables.iter().all(|e| e.stage == "vertex")
}

/// Makes the record of one stage of a program.
fn record(head: &Head, runs_in: &str, program: &CompiledProgram, executable: &Executable) -> ShaderRecord {
    let constants: Vec<String> = program.constants.iter().map(|(id, bits)| format!("{id}={bits}")).collect();
    let statistic = |s: &ssct::gpu::executables::Statistic| ShaderStatistic {
        name: s.name.clone(),
        about: s.about.clone(),
        value: s.value,
    };
    ShaderRecord {
        head: head.clone(),
        runs_in: runs_in.to_owned(),
        passes: program.pass.clone(),
        program: program.program.clone(),
        stage: executable.stage.clone(),
        constants: constants.join(" "),
        subgroup_size: executable.subgroup_size,
        statistics: executable.statistics.iter().map(statistic).collect(),
    }
}
