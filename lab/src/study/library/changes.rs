//! Changes from run to run: the total times of each run are compared with those of an earlier run, as by `ssct
//! compare`. The earlier run is the latest of those on the same device that have a total in common with the run.

use super::LibraryRun;
use crate::study::compare::{self, Run, TOTAL, TimeComparison, TimeSample};
use std::sync::Arc;

/// A run compared with an earlier one.
#[derive(Debug, Clone, PartialEq)]
pub struct RunChange {
    /// Index of the earlier run in the library.
    pub before: usize,
    /// Index of the later run.
    pub after: usize,
    /// A record for each total that both runs have.
    pub totals: Vec<TimeComparison>,
}

/// Compares each run that has an earlier run to compare with, in the order of the library, which is that of the dates.
/// `threshold` is the change of a time that counts, as a share, at least 0 and below 1.
pub fn changes(library: &[LibraryRun], threshold: f64) -> Vec<RunChange> {
    let mut changes = Vec::new();
    for (after, run) in library.iter().enumerate() {
        let Some(later_run) = &run.samples else { continue };
        let latest_first = library[..after].iter().enumerate().rev();
        let with_samples = latest_first.filter_map(|(before, run)| Some((before, run.samples.as_ref()?)));
        let mut on_same_device =
            with_samples.filter(|(_, earlier)| earlier.device.is_some() && earlier.device == later_run.device);
        changes.extend(on_same_device.find_map(|(before, earlier_run)| {
            let mut totals = compare::times(earlier_run, later_run, threshold);
            totals.retain(|record| record.only_in.is_none());
            (!totals.is_empty()).then_some(RunChange { before, after, totals })
        }));
    }
    changes
}

/// Reduces each frame of a run to one sample: the sum of the counted passes, under the name of the total.
pub fn totals_only(run: Run) -> Run {
    let frame = |rows: &[TimeSample]| {
        let first = rows.iter().find(|row| row.counted)?;
        Some(TimeSample {
            subject: Arc::clone(&first.subject),
            sample: first.sample,
            pass: TOTAL.to_owned(),
            // From samples that count, the comparison would make another total.
            counted: false,
            ms: rows.iter().filter(|row| row.counted).map(|row| row.ms).sum(),
            floors: [first.floors[1]; 2],
        })
    };
    let frames = run.samples.chunk_by(|a, b| a.sample == b.sample && a.subject == b.subject);
    Run { samples: frames.filter_map(frame).collect(), ..run }
}
