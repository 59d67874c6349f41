//! Verdicts on settings that were timed in turn: each setting is compared with the first setting of its place
//! (docs/definitions.md, "Verdicts").

use crate::study::compare::{self, Run, Subject, THRESHOLD, TimeComparison, TimeSample};
use crate::study::exhibit::Table;
use crate::study::record::{Head, PassRecord, TimeRecord};
use ssct_truth::metrics::bootstrap::CONFIDENCE;
use std::sync::Arc;

/// Returns the samples of a record, rounded as in the file of its samples.
fn samples(record: &TimeRecord) -> Vec<TimeSample> {
    let subject = Arc::new(subject(&record.head));
    // The file has six digits. By the same rounding, samples that are read from the file get the same verdict.
    let rounded = |value: f64| format!("{value:.6}").parse().unwrap_or(value);
    let frame = |(n, times): (usize, &Vec<f64>)| {
        let sample = |(pass, ms): (&PassRecord, &f64)| TimeSample {
            subject: Arc::clone(&subject),
            sample: n as u64,
            pass: pass.name.clone(),
            counted: pass.counted,
            ms: rounded(*ms),
            floors: [pass.noise_floor, record.noise_floor].map(|floor| floor.map(rounded)),
        };
        record.passes.iter().zip(times).map(sample).collect::<Vec<_>>()
    };
    record.samples.iter().enumerate().flat_map(frame).collect()
}

/// Returns the subject of a record's frames.
fn subject(head: &Head) -> Subject {
    let names = [("scene", &head.scene), ("view", &head.view), ("method", &head.method)];
    let names = names.map(|(name, value)| (name.to_owned(), value.clone()));
    Subject(head.setup.keys().map(|name| (name.clone(), head.setting(name))).chain(names).collect())
}

/// Compares each record with the first record of its place. The records of a place must follow each other.
fn verdicts(records: &[TimeRecord]) -> Vec<TimeComparison> {
    let is_one_place = |a: &TimeRecord, b: &TimeRecord| subject(&a.head).place() == subject(&b.head).place();
    let verdicts_of_place = |records: &[TimeRecord]| {
        let device = records.first().map(|record| record.head.program.device.clone());
        let series: Vec<_> = records.iter().map(samples).collect();
        let run = Run { name: String::new(), device, samples: Vec::new() };
        compare::in_turns(&run, &series, THRESHOLD)
    };
    records.chunk_by(is_one_place).flat_map(verdicts_of_place).collect()
}

/// Makes the table of the verdicts; `None` if no place has two settings.
pub fn table(records: &[TimeRecord]) -> Option<Table> {
    let verdicts = verdicts(records);
    let bound = 100.0 * THRESHOLD;
    let title = format!(
        "B beside A, turn by turn; SAME is within ±{bound:.0} %, FASTER and SLOWER beyond it and beyond the noise floor"
    );
    let about =
        [about()].into_iter().chain(compare::note_on_own(&verdicts).map(str::to_owned)).collect::<Vec<_>>().join(" ");
    let cells = compare::cells(&verdicts, false);
    (!verdicts.is_empty()).then(|| Table::new("verdicts", &title, &about, cells))
}

/// Returns the description of the table.
fn about() -> String {
    format!(
        "Each setting is beside the first, with which it was timed in turn: the median over the turns of B over A, from low to high \
         with {} % confidence. Floor is how far a setting strays from itself, if it was timed against itself; n is the samples of A and \
         of B, and normals the normal deviation. Drift is how much longer the scene passes, the same work, took in B: what differs by \
         no more may be the machine's. It is a dash where the two sides draw different G-buffers. UNDECIDED is neither: about as many \
         samples as stand behind it may decide. ssct compare FOLDER compares any two, and shows the parts of passes.",
        100.0 * CONFIDENCE
    )
}
