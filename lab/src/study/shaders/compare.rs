//! Compares two runs of the study of compiled programs: which programs' statistics changed, and by how much.

use super::{FRAME, Kind, ShaderRecord, statistic_text};
use crate::study::exhibit::{Table, distinct};
use serde::Serialize;

/// A statistic of a program in two runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ShaderComparison {
    /// "compare-shaders".
    pub kind: &'static str,
    /// Name of the first run.
    pub a: String,
    /// Name of the second run.
    pub b: String,
    /// Variant, roughness, when the program runs, program and stage. A sixth text numbers the records of a run that
    /// agree in all of these; it is empty for the first.
    pub program: Vec<String>,
    /// The driver's name of the statistic.
    pub statistic: String,
    /// Value in the first run; null if that run has no such program.
    pub value_a: Option<f64>,
    /// Value in the second run; null if that run has no such program.
    pub value_b: Option<f64>,
}

/// A run, as its name and its records.
pub type NamedRun<'a> = (&'a str, &'a [ShaderRecord]);

/// Makes the key of each record by which records of two runs are matched ([`ShaderComparison::program`]). The
/// specialization constants are left out, since a change of the program may change them. Records with otherwise equal
/// keys are numbered.
fn keys(records: &[ShaderRecord]) -> Vec<Vec<String>> {
    let mut keys: Vec<Vec<String>> = Vec::new();
    for record in records {
        let [variant, roughness, runs_in, program, _, stage] = record.identity();
        let mut key = vec![variant, roughness, runs_in, program, stage, String::new()];
        let same = keys.iter().filter(|known| known[..5] == key[..5]).count();
        if same > 0 {
            key[5] = (same + 1).to_string();
        }
        keys.push(key);
    }
    keys
}

/// Makes a comparison for each statistic of each program that one of two runs has; a value that a run lacks is `None`.
/// Digests are left out.
pub fn compare((name_a, a): NamedRun, (name_b, b): NamedRun) -> Vec<ShaderComparison> {
    let (keys_a, keys_b) = (keys(a), keys(b));
    let all_keys = distinct(keys_a.iter().chain(&keys_b).cloned());
    let record_of = |key: &[String], keys: &[Vec<String>], records: &[ShaderRecord]| {
        keys.iter().position(|known| known == key).map(|n| records[n].clone())
    };
    let compared = |key: Vec<String>| {
        let [in_a, in_b] = [record_of(&key, &keys_a, a), record_of(&key, &keys_b, b)];
        let names = in_a.iter().chain(&in_b).flat_map(|r| r.statistics.iter().map(|s| s.name.clone()));
        let names = distinct(names.filter(|name| Kind::named(name) != Kind::Digest));
        let value = |record: &Option<ShaderRecord>, name: &str| record.as_ref().and_then(|r| r.statistic(name));
        let comparison = |statistic: String| ShaderComparison {
            kind: "compare-shaders",
            a: name_a.to_owned(),
            b: name_b.to_owned(),
            program: key.clone(),
            value_a: value(&in_a, &statistic),
            value_b: value(&in_b, &statistic),
            statistic,
        };
        names.into_iter().map(comparison).collect::<Vec<_>>()
    };
    all_keys.into_iter().flat_map(compared).collect()
}

/// Makes two tables of two runs: for each variant and roughness the sums and extremes over a frame's programs, and the
/// programs of frames whose main statistics differ.
pub fn tables((name_a, a): NamedRun, (name_b, b): NamedRun) -> Vec<Table> {
    let comparisons = compare((name_a, a), (name_b, b));
    let mut frames = vec![["method", "roughness", "number", "A", "B", "B/A"].map(str::to_owned).to_vec()];
    for frame in distinct(a.iter().chain(b).filter(|r| r.runs_in == FRAME).map(ShaderRecord::variant_and_roughness)) {
        let of_frame = |records: &[ShaderRecord]| -> Vec<ShaderRecord> {
            records.iter().filter(|r| r.runs_in == FRAME && r.variant_and_roughness() == frame).cloned().collect()
        };
        let [in_a, in_b] = [of_frame(a), of_frame(b)];
        let names = distinct(in_a.iter().chain(&in_b).flat_map(|r| r.statistics.iter().map(|s| s.name.clone())));
        let (variant, roughness) = &frame;
        for name in names {
            let Some(fold) = Kind::named(&name).fold() else { continue };
            let folded = |records: &[ShaderRecord]| {
                records.iter().filter_map(|r| r.statistic(&name)).reduce(|x, y| fold.join(x, y))
            };
            let row = [variant.clone(), roughness.clone(), name.clone()].into_iter();
            frames.push(row.chain(comparison_cells(folded(&in_a), folded(&in_b))).collect());
        }
    }
    let header = ["method", "roughness", "program", "stage", "number", "A", "B", "B/A"].map(str::to_owned);
    let mut programs = vec![header.to_vec()];
    // The third text of `program` says when the program runs.
    for c in comparisons.iter().filter(|c| c.program[2] == FRAME && Kind::named(&c.statistic).is_main()) {
        if c.value_a != c.value_b {
            let labels = [0, 1, 3, 4].map(|n| c.program[n].clone()).into_iter().chain([c.statistic.clone()]);
            programs.push(labels.chain(comparison_cells(c.value_a, c.value_b)).collect());
        }
    }
    let about = format!("A is {name_a}, and B is {name_b}.");
    vec![
        Table::new("frames", "Frames", &about, frames),
        Table::new("programs", "Programs of frames whose numbers differ", "", programs),
    ]
}

/// Returns the cells of the value in A, the value in B, and their ratio B / A; a dash stands for what is missing.
fn comparison_cells(a: Option<f64>, b: Option<f64>) -> [String; 3] {
    let ratio = a.zip(b).filter(|(a, _)| *a != 0.0).map(|(a, b)| format!("{:.3}", b / a));
    [statistic_text(a), statistic_text(b), ratio.unwrap_or_else(|| "-".into())]
}
