//! Writes the study of a device as files and a page.

use super::{files, html};
use crate::study::TimeRecord;
use crate::study::agreement::{AgreementRecord, DrawnRecord};
use crate::study::bandwidth::{self, BandwidthRecord};
use crate::study::exhibit::Table;
use crate::study::names::roughness_name;
use crate::study::readme::{self, ReadmeRecord};
use crate::study::record::Head;
use crate::study::shaders::ShaderRecord;
use crate::study::steps::StepsRecord;
use crate::study::table;
use serde_json::{Value, json};
use ssct::gpu::DeviceInfo;
use ssct::methods::setup::Stage;
use ssct_ground::Result;
use ssct_ground::parameter::Choices;
use ssct_scenes::inside::PathInFolder;

/// The messages of the validation layers outside the allow-list.
pub enum LayerMessages {
    /// The layers could not be asked, for this reason.
    Unknown(String),
    /// ID and text of each message; there should be none.
    Said(Vec<(String, String)>),
}

/// What the device's compiler made of the programs.
pub enum CompiledPrograms {
    /// The device does not say, for this reason.
    Unknown(String),
    /// A record for each stage of each program.
    Said(Vec<ShaderRecord>),
}

/// The times of a device.
pub struct DeviceTimes {
    /// The cells of table 5.8.
    pub table: Vec<TimeRecord>,
    /// Every method on every view, in fragment and in compute shaders.
    pub methods: Vec<TimeRecord>,
    /// `unified` on each view and at each roughness: in turn with the screen traced first, and with the triangles traced first.
    pub orders: Vec<TimeRecord>,
    /// `traced` on each view and at each roughness, by the tree and then by ray queries; empty on a device without ray queries.
    pub tracers: Vec<TimeRecord>,
    /// The variants of the README's tables.
    pub readme: Vec<TimeRecord>,
    /// `unified` at each roughness, in fragment and then in compute shaders.
    pub stages: Vec<TimeRecord>,
}

impl DeviceTimes {
    /// All times.
    pub fn all(&self) -> Vec<TimeRecord> {
        [&self.table[..], &self.methods, &self.orders, &self.tracers, &self.readme, &self.stages].concat()
    }
}

/// The findings of the study other than times.
pub struct Findings {
    /// The rate of a plain copy.
    pub copy: BandwidthRecord,
    /// Steps of the mirror rays of each view.
    pub steps: Vec<StepsRecord>,
    /// The device's images against those of other devices, on one G-buffer.
    pub agreement: Vec<AgreementRecord>,
    /// The G-buffer that the device draws against those that other devices draw.
    pub drawn: Vec<DrawnRecord>,
    /// The messages of the validation layers.
    pub validation: LayerMessages,
    /// What the compiler made of the programs.
    pub programs: CompiledPrograms,
}

/// The page of the study.
pub const PAGE: &str = "index.html";
/// The page of the README's numbers.
pub const README: &str = "readme.html";

/// Writes the page of the README's numbers.
pub fn write_readme(folder: &PathInFolder, device: &DeviceInfo, command: &str, readme: &[ReadmeRecord]) -> Result<()> {
    let table = readme::table(readme);
    let page = html::tables_page(&table.title, Some(device), command, std::slice::from_ref(&table));
    folder.join(README).write(page.as_bytes())
}

/// Writes `gpu-study.json`, which has the findings and the README's numbers, and the [`PAGE`], which has the times and
/// the findings.
pub fn write(
    folder: &PathInFolder,
    device: &DeviceInfo,
    command: &str,
    (times, readme): (&DeviceTimes, &[ReadmeRecord]),
    findings: &Findings,
) -> Result<()> {
    let rates: Vec<_> = times.all().iter().flat_map(|r| bandwidth::pass_rates(r, &findings.copy)).collect();
    let finding_records = records(device, &rates, findings);
    let all_records: Vec<_> = finding_records.into_iter().chain(readme.iter().map(|r| json!(r))).collect();
    folder.join("gpu-study.json").write(files::json(&all_records).as_bytes())?;
    folder.join(PAGE).write(page(device, command, times, &rates, findings).as_bytes())
}

/// The records of the findings: everything of the study but its times.
fn records(device: &DeviceInfo, rates: &[BandwidthRecord], findings: &Findings) -> Vec<Value> {
    let validation = match &findings.validation {
        LayerMessages::Unknown(why) => json!({ "kind": "validation", "device": device, "messages": null, "why": why }),
        LayerMessages::Said(messages) => json!({ "kind": "validation", "device": device, "messages": messages }),
    };
    let rates = [&findings.copy].into_iter().chain(rates).map(|r| json!(r));
    let steps = findings.steps.iter().map(|r| json!(r));
    let agreement = findings.agreement.iter().map(|r| json!(r)).chain(findings.drawn.iter().map(|r| json!(r)));
    let programs = match &findings.programs {
        CompiledPrograms::Unknown(why) => vec![json!({ "kind": "shaders", "device": device, "why": why })],
        CompiledPrograms::Said(records) => records.iter().map(|r| json!(r)).collect(),
    };
    rates.chain(steps).chain(agreement).chain([validation]).chain(programs).collect()
}

/// The page of the study, with a table for each group of times and for each finding.
fn page(
    device: &DeviceInfo,
    command: &str,
    times: &DeviceTimes,
    rates: &[BandwidthRecord],
    findings: &Findings,
) -> String {
    let all_rates = [std::slice::from_ref(&findings.copy), rates].concat();
    html::tables_page(
        "A device",
        Some(device),
        command,
        &[
            Table::new(
                "table-5.8",
                "Table 5.8",
                &format!(
                    "The thesis's milliseconds (NVIDIA GeForce GTX 670, Sponza) beside those of this device on the atrium. {}",
                    table::about()
                ),
                table::cells(&table::compare(&times.table)),
            ),
            Table::new(
                "methods-compute",
                "Every method in compute shaders",
                &format!(
                    "{METHOD_TABLES_TEXT} Every pass over the whole image is a compute shader; the scene is drawn as ever."
                ),
                method_cells(&in_stage(&times.methods, Stage::Compute)),
            ),
            Table::new(
                "methods-fragment",
                "Every method in fragment shaders",
                &format!(
                    "{METHOD_TABLES_TEXT} Rays and lookups are fragment shaders, as the documents have them. Methods that follow \
                     rays in captures or among triangles do so in compute shaders, and are in the table above alone."
                ),
                method_cells(&in_stage(&times.methods, Stage::Fragment)),
            ),
            Table::new(
                "either-stage",
                "Every method in either stage",
                "Median times of the effect in milliseconds, of the two tables above. Both stages make the same image. Where the \
                 ratio is below 1, compute is faster.",
                stage_cells(&times.methods),
            ),
            Table::new(
                "stages",
                "Fragment and compute",
                "Each pass of unified as a fragment shader and as a compute shader, timed in turn. Both make the same image. \
                 Where the ratio is below 1, compute is faster.",
                pair_cells(&times.stages, ["fragment", "compute"]),
            ),
            Table::new(
                "first",
                "Screen and triangles",
                "unified with its rays asked of the screen first, and of the scene's triangles, timed in turn. Both end a ray \
                 where the scene does. Where the ratio is below 1, the triangles alone are faster.",
                pair_cells(&times.orders, ["screen", "triangles"]),
            ),
            Table::new(
                "tracers",
                "Tree and ray queries",
                "traced with its rays followed by a walk through the tree, and by the device's ray queries, timed in turn. Where the \
                 ratio is below 1, ray queries are faster. Empty on a device without them.",
                pair_cells(&times.tracers, ["tree", "query"]),
            ),
            BandwidthRecord::table(&all_rates),
            StepsRecord::table(&findings.steps),
            AgreementRecord::table(&findings.agreement),
            DrawnRecord::table(&findings.drawn),
            Table::new(
                "validation",
                "Validation",
                "The messages of the Khronos validation layers about any method that the allow-list does not excuse; there \
                 should be none.",
                validation_cells(&findings.validation),
            ),
            compiled_table(&findings.programs),
            Table::new(
                "passes",
                "Every pass",
                "Median time of each pass, and the shader invocations that the device counted in another frame.",
                pass_cells(&times.methods),
            ),
        ],
    )
}

/// The table of what the compiler made of the programs, or the reason why the device does not say.
fn compiled_table(programs: &CompiledPrograms) -> Table {
    match programs {
        CompiledPrograms::Unknown(why) => Table::new("shaders", "Programs", why, Vec::new()),
        CompiledPrograms::Said(records) => ShaderRecord::table(records),
    }
}

/// Returns a table that has one row so far: the names of its columns.
fn header(names: &[&str]) -> Vec<Vec<String>> {
    vec![names.iter().map(|name| (*name).to_owned()).collect()]
}

/// Returns the cells of a row that say where a time was measured: view, size and roughness.
fn place_cells(head: &Head) -> Vec<String> {
    vec![
        format!("{} {}", head.scene, head.view),
        format!("{} x {}", head.width, head.height),
        roughness_name(head.roughness),
    ]
}

/// The text about times with the tables of every method.
const METHOD_TABLES_TEXT: &str = "Median times of the effect at roughness 0.1; the methods were timed in turn, frame by frame. Each was \
                           also timed against itself: the floor is how far its time strays from itself, and a smaller \
                           difference means nothing.";

/// Returns the records that were timed in a shader stage.
fn in_stage(records: &[TimeRecord], stage: Stage) -> Vec<TimeRecord> {
    let has_stage = |r: &&TimeRecord| r.head.setting(STAGE) == stage.name();
    records.iter().filter(has_stage).cloned().collect()
}

/// The name of the parameter that chooses the shader stage.
const STAGE: &str = "stage";

/// Returns a table of the methods that were timed in both stages, with their total times side by side.
fn stage_cells(records: &[TimeRecord]) -> Vec<Vec<String>> {
    let [fragment, compute] = [Stage::Fragment, Stage::Compute].map(|stage| in_stage(records, stage));
    let mut rows = header(&["view", "size", "roughness", "method", "fragment ms", "compute ms", "compute / fragment"]);
    for fragment_record in &fragment {
        // Everything but the stage, by which the two records of a variant are found.
        let key = |r: &TimeRecord| {
            let mut setup = r.head.setup.clone();
            setup.remove(STAGE);
            (r.head.scene.clone(), r.head.view.clone(), r.head.method.clone(), setup)
        };
        let Some(compute_record) = compute.iter().find(|r| key(r) == key(fragment_record)) else { continue };
        let [fragment_ms, compute_ms] = [fragment_record, compute_record].map(|r| r.total.median_ms);
        let mut row = place_cells(&fragment_record.head);
        row.push(fragment_record.head.method.clone());
        row.extend([fragment_ms, compute_ms].map(|ms| format!("{ms:.3}")));
        row.push(if fragment_ms > 0.0 { format!("{:.2}", compute_ms / fragment_ms) } else { "-".to_owned() });
        rows.push(row);
    }
    rows
}

/// Returns a table with the median time of each method, its spread and its noise floor.
fn method_cells(records: &[TimeRecord]) -> Vec<Vec<String>> {
    let mut rows = header(&["view", "size", "roughness", "method", "median ms", "min", "p95", "n", "floor"]);
    rows.extend(records.iter().map(|r| {
        let mut row = place_cells(&r.head);
        row.push(r.head.variant());
        row.extend([r.total.median_ms, r.total.min_ms, r.total.p95_ms].map(|ms| format!("{ms:.3}")));
        row.push(r.total.samples.to_string());
        row.push(r.noise_floor.map_or_else(|| "-".into(), |floor| format!("{:.1} %", 100.0 * floor)));
        row
    }));
    rows
}

/// Returns a table with the median time of each pass that counts, and the shader invocations of the pass.
fn pass_cells(records: &[TimeRecord]) -> Vec<Vec<String>> {
    let mut rows = header(&["view", "size", "roughness", "method", "pass", "median ms", "fragments", "compute"]);
    for r in records {
        rows.extend(r.passes.iter().filter(|p| p.counted).map(|p| {
            let mut row = place_cells(&r.head);
            row.extend([r.head.variant(), p.name.clone(), format!("{:.4}", p.stats.median_ms)]);
            let work = p.work.map(|w| [w.fragment_invocations, w.compute_invocations]);
            row.extend(work.map_or(["-".to_owned(), "-".to_owned()], |w| w.map(|n| n.to_string())));
            row
        }));
    }
    rows
}

/// Returns a table of the passes that two variants of a method have in common, and of their totals. In `records`, each
/// record of the first variant is followed by one of the second; `a` and `b` name the variants.
fn pair_cells(records: &[TimeRecord], [a, b]: [&str; 2]) -> Vec<Vec<String>> {
    let [title_a, title_b] = [format!("{a} ms"), format!("{b} ms")];
    let mut rows = header(&["view", "size", "roughness", "pass", &title_a, &title_b, &format!("{b} / {a}")]);
    let medians = |r: &TimeRecord| -> Vec<(String, f64)> {
        let passes = r.passes.iter().filter(|p| p.counted).map(|p| (p.name.clone(), p.stats.median_ms));
        passes.chain([("total".to_owned(), r.total.median_ms)]).collect()
    };
    for (record_a, record_b) in records.chunks_exact(2).map(|pair| (&pair[0], &pair[1])) {
        let medians_b = medians(record_b);
        for (name, ms_a) in medians(record_a) {
            let Some((_, ms_b)) = medians_b.iter().find(|(n, _)| *n == name) else { continue };
            let ratio = if ms_a > 0.0 { format!("{:.2}", ms_b / ms_a) } else { "-".to_owned() };
            let mut row = place_cells(&record_a.head);
            row.extend([name, format!("{ms_a:.4}"), format!("{ms_b:.4}"), ratio]);
            rows.push(row);
        }
    }
    rows
}

/// Returns a table of the messages of the validation layers, or the reason why the layers could not be asked.
fn validation_cells(messages: &LayerMessages) -> Vec<Vec<String>> {
    let mut rows = header(&["message", "text"]);
    match messages {
        LayerMessages::Unknown(why) => rows.push(vec!["not asked".to_owned(), why.clone()]),
        LayerMessages::Said(all) if all.is_empty() => rows.push(vec!["none".to_owned(), "-".to_owned()]),
        LayerMessages::Said(all) => rows.extend(all.iter().map(|(id, text)| vec![id.clone(), text.clone()])),
    }
    rows
}
