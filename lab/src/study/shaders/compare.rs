//! Comparison of two runs of the study of compiled programs: which program's numbers changed, and by how much.

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
    /// Five texts: variant, roughness, the kind of frame in which the program runs, program and stage. A sixth text numbers programs of a run that agree in all
    /// of these; it is empty for the first.
    pub program: Vec<String>,
    /// The driver's name of the statistic.
    pub statistic: String,
    /// Value in the first run; null if that run has no such program.
    pub value_a: Option<f64>,
    /// Value in the second run; null if that run has no such program.
    pub value_b: Option<f64>,
}

/// A run's name and records.
pub type NamedRun<'a> = (&'a str, &'a [ShaderRecord]);

/// The keys by which records of two runs are matched. Constants are left out, since a change of the program may change them;
/// records with otherwise equal keys are numbered in the order of the run.
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

/// Pairs the two runs' values of each statistic of each program; what a run lacks is `None`. Digests are left out.
pub fn compare((name_a, a): NamedRun, (name_b, b): NamedRun) -> Vec<ShaderComparison> {
    let (keys_a, keys_b) = (keys(a), keys(b));
    let all = distinct(keys_a.iter().chain(&keys_b).cloned());
    let found = |keys: &[Vec<String>], records: &[ShaderRecord], key: &[String]| {
        keys.iter().position(|known| known == key).map(|n| records[n].clone())
    };
    let compared = |key: Vec<String>| {
        let [in_a, in_b] = [found(&keys_a, a, &key), found(&keys_b, b, &key)];
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
    all.into_iter().flat_map(compared).collect()
}

/// The frames' sums and extremes in both runs, and the programs of frames whose main numbers differ.
pub fn tables((name_a, a): NamedRun, (name_b, b): NamedRun) -> Vec<Table> {
    let comparisons = compare((name_a, a), (name_b, b));
    let mut frames = vec![["method", "roughness", "number", "A", "B", "B/A"].map(str::to_owned).to_vec()];
    let frame = |r: &ShaderRecord| (r.head.variant(), crate::study::names::roughness(r.head.roughness));
    for key in distinct(a.iter().chain(b).filter(|r| r.runs_in == FRAME).map(frame)) {
        let here = |records: &[ShaderRecord]| -> Vec<ShaderRecord> {
            records.iter().filter(|r| r.runs_in == FRAME && frame(r) == key).cloned().collect()
        };
        let [in_a, in_b] = [here(a), here(b)];
        let names = distinct(in_a.iter().chain(&in_b).flat_map(|r| r.statistics.iter().map(|s| s.name.clone())));
        for name in names {
            let Some(fold) = Kind::named(&name).fold() else { continue };
            let total = |records: &[ShaderRecord]| {
                records.iter().filter_map(|r| r.statistic(&name)).reduce(|x, y| fold.join(x, y))
            };
            let row = [key.0.clone(), key.1.clone(), name.clone()].into_iter();
            frames.push(row.chain(comparison_cells(total(&in_a), total(&in_b))).collect());
        }
    }
    let header = ["method", "roughness", "program", "stage", "number", "A", "B", "B/A"].map(str::to_owned);
    let mut programs = vec![header.to_vec()];
    for c in comparisons.iter().filter(|c| c.program[2] == FRAME && Kind::named(&c.statistic).is_main()) {
        if c.value_a != c.value_b {
            let own = [0, 1, 3, 4].map(|n| c.program[n].clone()).into_iter().chain([c.statistic.clone()]);
            programs.push(own.chain(comparison_cells(c.value_a, c.value_b)).collect());
        }
    }
    let about = format!("A is {name_a}, and B is {name_b}.");
    vec![
        Table::new("frames", "Frames", &about, frames),
        Table::new("programs", "Programs of frames whose numbers differ", "", programs),
    ]
}

/// The cells of the value in A, the value in B and the ratio B / A; a dash stands for a missing one.
fn comparison_cells(a: Option<f64>, b: Option<f64>) -> [String; 3] {
    let ratio = a.zip(b).filter(|(a, _)| *a != 0.0).map(|(a, b)| format!("{:.3}", b / a));
    [statistic_text(a), statistic_text(b), ratio.unwrap_or_else(|| "-".into())]
}
