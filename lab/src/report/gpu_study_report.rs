//! The study of a device as files and a page.

use super::{agreement_report, files, html, tables};
use crate::error::Result;
use crate::gpu::DeviceInfo;
use crate::study::TimeRecord;
use crate::study::agreement::{AgreementRecord, DrawnRecord};
use crate::study::bandwidth::BandwidthRecord;
use crate::study::record::Head;
use crate::study::stages::StageRecord;
use crate::study::steps::StepsRecord;
use crate::study::table::compare;
use serde_json::{Value, json};
use std::path::Path;

/// What the validation layers say.
pub enum Silence {
    /// They could not be asked, and why.
    Unknown(String),
    /// The IDs and texts of their messages outside the allow-list; none is what is wanted.
    Heard(Vec<(String, String)>),
}

/// All that is no table of times.
pub struct Findings {
    /// The passes of `unified` by the kind of shader that makes them.
    pub stages: Vec<StageRecord>,
    /// The rate of a copy.
    pub copy: BandwidthRecord,
    /// The rates of passes beside it.
    pub rates: Vec<BandwidthRecord>,
    /// Steps of rays.
    pub steps: Vec<StepsRecord>,
    /// The device's images against those of others.
    pub same: Vec<AgreementRecord>,
    /// Its G-buffers against theirs.
    pub drawn: Vec<DrawnRecord>,
    /// What the validation layers say.
    pub validation: Silence,
}

/// Writes `gpu-study.json` and `index.html`.
///
/// # Errors
/// Those of writing a file.
pub fn write(
    folder: &Path,
    device: &DeviceInfo,
    command: &str,
    table: &[TimeRecord],
    views: &[TimeRecord],
    findings: &Findings,
) -> Result<()> {
    files::write(&folder.join("gpu-study.json"), files::json(&records(device, findings)).as_bytes())?;
    files::write(&folder.join("index.html"), page(device, command, table, views, findings).as_bytes())
}

fn records(device: &DeviceInfo, found: &Findings) -> Vec<Value> {
    let validation = match &found.validation {
        Silence::Unknown(why) => json!({ "kind": "validation", "device": device, "messages": null, "why": why }),
        Silence::Heard(all) => json!({ "kind": "validation", "device": device, "messages": all }),
    };
    let stages = found.stages.iter().map(|r| json!(r));
    let rates = [&found.copy].into_iter().chain(&found.rates).map(|r| json!(r));
    let steps = found.steps.iter().map(|r| json!(r));
    let same = found.same.iter().map(|r| json!(r)).chain(found.drawn.iter().map(|r| json!(r)));
    stages.chain(rates).chain(steps).chain(same).chain([validation]).collect()
}

fn page(device: &DeviceInfo, command: &str, table: &[TimeRecord], views: &[TimeRecord], found: &Findings) -> String {
    html::tables_page(
        "A device",
        Some(device),
        command,
        &[
            (
                "Table 5.8",
                "The thesis's milliseconds (NVIDIA GeForce GTX 670, Sponza) beside this device's on the atrium, for the \
                 effect without the scene passes.",
                &tables::table_5_8_cells(&compare(table)),
            ),
            (
                "Every method",
                "Medians of the effect at roughness 0.1, methods in turn frame by frame. Each was timed against itself, \
                 too: the floor is how far it strays from itself, and no smaller difference means anything.",
                &method_cells(views),
            ),
            (
                "Fragment and compute",
                "The passes of unified, each as a fragment shader and as a compute shader that makes the same image to the \
                 bit, frames in turn. Below 1, compute is the faster one.",
                &stage_cells(&found.stages),
            ),
            (
                "Rates",
                "The passes that build a pyramid of depth: bytes that they read and write at least, over their time, \
                 beside a plain copy of an image. A level of the Hi-Z buffer is a pass of its own, and small ones are \
                 all overhead.",
                &rate_cells(found),
            ),
            (
                "Steps",
                "Cells that the mirror rays of unified look at, by its twin on the CPU, which takes the same steps.",
                &step_cells(&found.steps),
            ),
            ("The same on other devices", agreement_report::ABOUT_METHODS, &some(agreement_report::cells(&found.same))),
            ("G-buffers", agreement_report::ABOUT_DRAWN, &some(agreement_report::drawn_cells(&found.drawn))),
            (
                "Validation",
                "What the Khronos validation layers say of every method, beyond the allow-list: nothing is right.",
                &validation_cells(&found.validation),
            ),
            (
                "Every pass",
                "Medians of each pass, with the invocations that the device counted in a frame of its own.",
                &pass_cells(views),
            ),
        ],
    )
}

/// Nothing rather than a header alone.
fn some(cells: Vec<Vec<String>>) -> Vec<Vec<String>> {
    if cells.len() > 1 { cells } else { Vec::new() }
}

fn header(names: &[&str]) -> Vec<Vec<String>> {
    vec![names.iter().map(|n| (*n).to_owned()).collect()]
}

fn place(head: &Head) -> Vec<String> {
    vec![
        format!("{} {}", head.scene, head.view),
        format!("{} x {}", head.width, head.height),
        tables::roughness(head.roughness),
    ]
}

fn method_cells(records: &[TimeRecord]) -> Vec<Vec<String>> {
    let mut rows = header(&["view", "size", "roughness", "method", "median ms", "min", "p95", "n", "floor"]);
    rows.extend(records.iter().map(|r| {
        let mut row = place(&r.head);
        row.push(r.head.variant());
        row.extend([r.total.median_ms, r.total.min_ms, r.total.p95_ms].map(|ms| format!("{ms:.3}")));
        row.push(r.total.samples.to_string());
        row.push(r.noise_floor.map_or_else(|| "-".into(), |floor| format!("{:.1} %", 100.0 * floor)));
        row
    }));
    rows
}

fn pass_cells(records: &[TimeRecord]) -> Vec<Vec<String>> {
    let mut rows = header(&["view", "size", "roughness", "method", "pass", "median ms", "fragments", "compute"]);
    for r in records {
        rows.extend(r.passes.iter().filter(|p| p.counted).map(|p| {
            let mut row = place(&r.head);
            row.extend([r.head.variant(), p.name.clone(), format!("{:.4}", p.stats.median_ms)]);
            let work = p.work.map(|w| [w.fragment_invocations, w.compute_invocations]);
            row.extend(work.map_or(["-".to_owned(), "-".to_owned()], |w| w.map(|n| n.to_string())));
            row
        }));
    }
    rows
}

/// Each pass of the first setting beside the same pass of the others.
fn stage_cells(records: &[StageRecord]) -> Vec<Vec<String>> {
    let mut rows = header(&["view", "size", "roughness", "pass", "fragment ms", "compute ms", "compute / fragment"]);
    for pair in records.chunks_exact(2) {
        let [fragment, compute] = pair else { continue };
        let total = [("total".to_owned(), fragment.total)];
        for (name, stats) in fragment.passes.iter().chain(&total) {
            let other = compute.passes.iter().find(|(n, _)| n == name).map(|(_, stats)| *stats);
            let Some(other) = other.or((name == "total").then_some(compute.total)) else { continue };
            let mut row = place(&fragment.head);
            row.extend([name.clone(), format!("{:.4}", stats.median_ms), format!("{:.4}", other.median_ms)]);
            row.push(if stats.median_ms > 0.0 {
                format!("{:.2}", other.median_ms / stats.median_ms)
            } else {
                "-".to_owned()
            });
            rows.push(row);
        }
    }
    rows
}

fn rate_cells(found: &Findings) -> Vec<Vec<String>> {
    let mut rows = header(&["view", "method", "pass", "size", "bytes", "median ms", "GB/s", "of a copy"]);
    rows.extend([&found.copy].into_iter().chain(&found.rates).map(|r| {
        vec![
            r.view.clone().unwrap_or_else(|| "-".into()),
            r.method.clone().unwrap_or_else(|| "-".into()),
            r.pass.clone(),
            format!("{} x {}", r.width, r.height),
            r.bytes.to_string(),
            format!("{:.4}", r.median_ms),
            format!("{:.2}", r.gb_per_s),
            format!("{:.2}", r.of_copy),
        ]
    }));
    rows
}

fn step_cells(records: &[StepsRecord]) -> Vec<Vec<String>> {
    let mut rows = header(&["view", "size", "rays", "mean", "median", "p99", "most"]);
    rows.extend(records.iter().map(|r| {
        vec![
            format!("{} {}", r.scene, r.view),
            format!("{} x {}", r.width, r.height),
            r.rays.to_string(),
            format!("{:.1}", r.mean),
            r.median.to_string(),
            r.p99.to_string(),
            r.most.to_string(),
        ]
    }));
    rows
}

fn validation_cells(silence: &Silence) -> Vec<Vec<String>> {
    let mut rows = header(&["message", "text"]);
    match silence {
        Silence::Unknown(why) => rows.push(vec!["not asked".to_owned(), why.clone()]),
        Silence::Heard(all) if all.is_empty() => rows.push(vec!["none".to_owned(), "-".to_owned()]),
        Silence::Heard(all) => rows.extend(all.iter().map(|(id, text)| vec![id.clone(), text.clone()])),
    }
    rows
}
