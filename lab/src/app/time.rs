//! `ssct time`.

use super::cli::{Table, TimeOptions};
use super::run::{Run, list_head};
use super::time_output::{TimeOutput, device_line};
use super::{progress, resolve};
use crate::error::{Error, Result};
use crate::methods;
use crate::report::{files, plot, tables, trace};
use crate::study::cell_list::{CellList, CellListHead};
use crate::study::error::Variant;
use crate::study::table as table_5_8;
use crate::study::timing::{self, TimeSpec};
use crate::study::{Globals, TimeRecord};
use serde::{Deserialize, Serialize};
use serde_json::json;

/// Measures, prints and writes.
pub fn run(options: &TimeOptions) -> anyhow::Result<()> {
    let common = &options.common;
    if options.table == Some(Table::Captions) {
        if options.shard.shard.is_some() {
            return Err(Error::Usage("--shard is not for --table captions, whose rows are few".into()).into());
        }
        if options.trace.is_some() {
            return Err(
                Error::Usage("--trace is not for --table captions, whose rows are of several scenes".into()).into()
            );
        }
        return super::time_captions::run(options);
    }
    let table = options.table == Some(Table::T5_8);
    let scene = resolve::scene(&common.place, if table { "atrium" } else { "rooms" })?;
    let view = resolve::view(&scene, &common.place, table.then_some("hall"))?;
    let methods = match &options.method[..] {
        [] if table => table_5_8::methods(),
        names => methods::choose(names, &common.method_options.setup([1, 1]))?,
    };
    let globals = if table { table_globals(options)? } else { resolve::globals(&common.place)? };
    let sizes = sizes(options, table)?;
    if options.samples == 0 {
        return Err(Error::Usage("--samples 0: at least one is needed".into()).into());
    }
    let gpu = resolve::gpu(&common.device)?;
    let setup = common.method_options.setup(sizes[0]);
    let (warmup, samples) = (options.warmup, options.samples);
    let a_a = options.a_a;
    let variants = Variant::of(&methods, &setup);
    let (gpu, scene, view, only) = (&gpu, &scene, &view, None);
    let mut spec = TimeSpec { gpu, scene, view, variants, sizes, globals, warmup, samples, a_a, only };
    let settings = json!(TimeSettings { table, samples, a_a });
    let head = CellListHead { settings, ..list_head("time", options.shard.shard, &setup, scene) };
    let list = CellList::new(head, gpu.info(), spec.planned());
    spec.only = Some(list.cells.iter().map(|c| c.own).collect());
    let mut run = Run::begin(options.output.as_deref(), options.run.resume)?;
    run.list(&list)?;
    let bar = progress::bar("timing", spec.frames());
    let outcome = timing::measure(&spec, &mut run.journal, &mut || progress::step(&bar));
    bar.finish_and_clear();
    let records = timing::records(&spec, &run.journal);
    if let Some(path) = &options.trace {
        files::write(path, trace::json(&timing::frames(&spec, &run.journal)).as_bytes())?;
    }

    let written = output(&records, table).map_err(anyhow::Error::msg)?;
    written.conclude((options.output.as_deref(), options.run.json), run, outcome, gpu)
}

/// Settings that the files of a run depend on, beside its cells.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct TimeSettings {
    /// Whether the times are compared with the thesis's table.
    pub table: bool,
    /// Frames that count.
    pub samples: usize,
    /// Whether methods are timed against themselves.
    pub a_a: bool,
}

/// The files and the text of records of one device.
pub fn output(records: &[TimeRecord], table: bool) -> std::result::Result<TimeOutput, String> {
    Ok(TimeOutput {
        stem: "time",
        json: files::json(records),
        samples: ("time-samples.csv", files::samples_csv(records)),
        plot: plot::stage_bars(records)?,
        text: text(records, table),
    })
}

/// The text of records of one device.
pub fn text(records: &[TimeRecord], table: bool) -> String {
    let mut text = String::new();
    if let Some(first) = records.first() {
        text += &device_line(&first.head.program.device);
    }
    if table {
        text += &tables::table_5_8(&table_5_8::compare(records));
        text += "\n";
    }
    text + &tables::times(records)
}

/// Sizes of the flags, else of the table, else 960×540.
fn sizes(options: &TimeOptions, table: bool) -> Result<Vec<[u32; 2]>> {
    let all = table_5_8::sizes();
    if !options.size.is_empty() {
        if let Some([w, h]) = options.size.iter().find(|s| table && !all.contains(s)) {
            return Err(Error::Usage(format!("--table 5.8 has no row for {w}x{h}")));
        }
        return Ok(options.size.clone());
    }
    Ok(if table { all } else { vec![[960, 540]] })
}

/// The table's roughness values, each also the normal deviation.
fn table_globals(options: &TimeOptions) -> Result<Vec<Globals>> {
    if options.common.place.normal_deviation.is_some() {
        return Err(Error::Usage("--table 5.8 sets the normal deviation to the roughness".into()));
    }
    let known = table_5_8::ROUGHNESS;
    let wanted =
        if options.common.place.roughness.is_empty() { known.to_vec() } else { options.common.place.roughness.clone() };
    if let Some(r) = wanted.iter().find(|r| !known.contains(r)) {
        return Err(Error::Usage(format!("--table 5.8 has no row for roughness {r}; it has 0 and 0.1")));
    }
    let reflectivity = options.common.place.reflectivity;
    Ok(wanted.iter().map(|roughness| table_5_8::factors(*roughness, reflectivity)).collect())
}
