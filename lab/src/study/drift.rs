//! The drift of the machine's speed between rows that were timed at different moments. It is measured by the scene
//! passes, which do the same work in all of these rows (docs/definitions.md, "Verdicts").

use crate::study::record::TimeRecord;

/// Returns for each record how much longer its scene passes took than in the first record of the same view and size, as
/// a share. Records that were timed in turn share one value. The value is `None` if a record has no scene passes, or if
/// all records of its view and size were timed in turn.
pub fn drift(records: &[TimeRecord]) -> Vec<Option<f64>> {
    let since_first = |record: &TimeRecord| {
        let same_work: Vec<&TimeRecord> = records.iter().filter(|r| work(r) == work(record)).collect();
        let first = *same_work.first()?;
        let is_one_moment = same_work.iter().all(|r| moment(r) == moment(first));
        let own_ms = mean_of_scene_passes(same_work.iter().copied().filter(|r| moment(r) == moment(record)))?;
        let first_ms = mean_of_scene_passes(same_work.iter().copied().filter(|r| moment(r) == moment(first)))?;
        (!is_one_moment).then_some(own_ms / first_ms - 1.0).filter(|drift| drift.is_finite())
    };
    records.iter().map(since_first).collect()
}

/// Returns the properties that decide how much work the scene passes do: scene, view, width and height.
fn work(record: &TimeRecord) -> (&str, &str, u32, u32) {
    let head = &record.head;
    (&head.scene, &head.view, head.width, head.height)
}

/// Returns the factors that tell moments of one view and size apart: records with the same factors were timed in turn.
fn moment(record: &TimeRecord) -> [String; 3] {
    ["roughness", "normal_deviation", "reflectivity"].map(|name| record.head.setting(name))
}

/// Returns the milliseconds of a frame's scene passes, as a mean over those records that have such passes; `None` if
/// none has.
fn mean_of_scene_passes<'r>(records: impl Iterator<Item = &'r TimeRecord>) -> Option<f64> {
    let scene_ms = |r: &TimeRecord| r.passes.iter().filter(|p| !p.counted).map(|p| p.stats.median_ms).sum::<f64>();
    let all: Vec<f64> = records.map(scene_ms).filter(|ms| *ms > 0.0).collect();
    (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
}
