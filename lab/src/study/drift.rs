//! Change of the machine's speed between rows that were timed at different moments, measured by the scene passes, whose work is
//! the same (docs/definitions.md, "Verdicts").

use crate::study::record::TimeRecord;

/// How much longer the scene passes of each record took than those of the first moment at the same view and size, as a share.
/// Methods that were timed in turn share one value. A record without scene passes, or of the only moment, has `None`.
pub fn drift(records: &[TimeRecord]) -> Vec<Option<f64>> {
    let since_first = |record: &TimeRecord| {
        let same_work: Vec<&TimeRecord> = records.iter().filter(|r| work(r) == work(record)).collect();
        let first = *same_work.first()?;
        let is_one_moment = same_work.iter().all(|r| moment(r) == moment(first));
        let here = mean_of_scene_passes(same_work.iter().copied().filter(|r| moment(r) == moment(record)))?;
        let there = mean_of_scene_passes(same_work.iter().copied().filter(|r| moment(r) == moment(first)))?;
        (!is_one_moment).then_some(here / there - 1.0).filter(|drift| drift.is_finite())
    };
    records.iter().map(since_first).collect()
}

/// The properties that decide how much work the scene passes do: scene, view, width and height.
fn work(record: &TimeRecord) -> (&str, &str, u32, u32) {
    let head = &record.head;
    (&head.scene, &head.view, head.width, head.height)
}

/// The factors that distinguish moments of one view and size: all methods with the same factors were timed in turn.
fn moment(record: &TimeRecord) -> [String; 3] {
    ["roughness", "normal_deviation", "reflectivity"].map(|name| record.head.setting(name))
}

/// Milliseconds of the passes that do not count, as a mean over the records that have any; `None` if no record has.
fn mean_of_scene_passes<'r>(records: impl Iterator<Item = &'r TimeRecord>) -> Option<f64> {
    let scene = |r: &TimeRecord| r.passes.iter().filter(|p| !p.counted).map(|p| p.stats.median_ms).sum::<f64>();
    let all: Vec<f64> = records.map(scene).filter(|ms| *ms > 0.0).collect();
    (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
}
