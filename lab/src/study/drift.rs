//! The drift of the machine's speed between rows that were timed at different moments. It is measured by the scene
//! passes, which do the same work in all of these rows (docs/definitions.md, "Verdicts").

use crate::study::record::TimeRecord;
use ssct::methods::{self, EffectParams};
use ssct_ground::parameter::{Parameters, Values};

/// Returns for each record how much longer its scene passes took than in the first record of the same view, size and
/// G-buffer, as a share. Records that were timed in turn share one value. The value is `None` if a record has no scene
/// passes, if it does not say which G-buffer they drew, or if all records of their work were timed in turn.
pub fn drift(records: &[TimeRecord]) -> Vec<Option<f64>> {
    let works: Vec<_> = records.iter().map(work).collect();
    let since_first = |(record, own_work): (&TimeRecord, &Option<Work<'_>>)| {
        let own_work = own_work.as_ref()?;
        let has_same_work = works.iter().map(|work| work.as_ref() == Some(own_work));
        let same_work: Vec<&TimeRecord> =
            records.iter().zip(has_same_work).filter(|(_, is_same)| *is_same).map(|(r, _)| r).collect();
        let first = *same_work.first()?;
        let is_one_moment = same_work.iter().all(|r| moment(r) == moment(first));
        let own_ms = mean_of_scene_passes(same_work.iter().copied().filter(|r| moment(r) == moment(record)))?;
        let first_ms = mean_of_scene_passes(same_work.iter().copied().filter(|r| moment(r) == moment(first)))?;
        (!is_one_moment).then_some(own_ms / first_ms - 1.0).filter(|drift| drift.is_finite())
    };
    records.iter().zip(&works).map(since_first).collect()
}

/// The properties that decide how much work the scene passes do: scene, view, width, height, and whether the G-buffer
/// says which triangle each pixel shows.
type Work<'r> = (&'r str, &'r str, u32, u32, bool);

/// Returns the work of a record's scene passes; `None` if the record does not say which G-buffer they drew.
fn work(record: &TimeRecord) -> Option<Work<'_>> {
    let head = &record.head;
    let has_triangles = has_triangle_gbuffer(&head.method, |name| head.setting(name))?;
    Some((head.scene.as_str(), head.view.as_str(), head.width, head.height, has_triangles))
}

/// Whether the G-buffer of a method's frames says which triangle each pixel shows, which takes the scene passes longer.
/// `setting` returns a setting of the frames as text. `None` if the settings do not say so, since they are older than
/// the parameter `beyond`.
pub fn has_triangle_gbuffer(method: &str, setting: impl Fn(&str) -> String) -> Option<bool> {
    // A method that is not known here comes from a folder, and no such method is given triangles.
    let Some(info) = methods::find(method).ok().filter(|info| info.takes_triangles) else { return Some(false) };
    if info.is_screen_space() && setting("beyond").is_empty() {
        return None;
    }
    let mut values = Values::default();
    for parameter in EffectParams::table() {
        // A parameter without a readable value is newer than the settings, and had no effect on them.
        if let Ok(value) = parameter.parse(&setting(parameter.name)) {
            values.set(&parameter, value);
        }
    }
    Some(EffectParams::from_values(&values).is_among_triangles(info, true))
}

/// Returns the factors that tell moments of one view and size apart: records with the same factors were timed in turn.
fn moment(record: &TimeRecord) -> [String; 3] {
    ["roughness", "normal_deviation", "reflectivity"].map(|name| record.head.setting(name))
}

/// Returns the milliseconds of a frame's scene passes, as a mean over those records that have such passes; `None` if
/// none has.
fn mean_of_scene_passes<'r>(records: impl Iterator<Item = &'r TimeRecord>) -> Option<f64> {
    let scene_ms = |r: &TimeRecord| r.passes.iter().filter(|p| !p.counted).map(|p| p.stats.median_ms).sum::<f64>();
    let measured_ms: Vec<f64> = records.map(scene_ms).filter(|ms| *ms > 0.0).collect();
    (!measured_ms.is_empty()).then(|| measured_ms.iter().sum::<f64>() / measured_ms.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::record::{DEFINITIONS, Head, PassRecord, Provenance, Stats};
    use serde_json::json;
    use ssct::gpu::DeviceInfo;
    use ssct::passes::gbuffer::DrawnCounts;
    use ssct_ground::parameter::Preset;

    /// Makes a record of a method whose scene passes took `scene_ms`. The setup has the parameter `beyond`, if given.
    fn record(method: &str, beyond: Option<&str>, roughness: f32, scene_ms: f64) -> TimeRecord {
        let empty = String::new;
        let device = DeviceInfo { name: empty(), driver: empty(), api: empty(), kind: empty() };
        let program = Provenance { definitions: DEFINITIONS, version: empty(), commit: empty(), device };
        let settings = [("roughness", Some(json!(roughness))), ("beyond", beyond.map(|beyond| json!(beyond)))];
        let head = Head {
            kind: "time".into(),
            program,
            scene: "rooms".into(),
            view: "hall".into(),
            method: method.into(),
            preset: Preset::default(),
            width: 32,
            height: 18,
            roughness: Some(roughness),
            setup: settings.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))).collect(),
        };
        let stats = Stats::from_samples(&[scene_ms]);
        let g_buffer = PassRecord { name: "g-buffer".into(), counted: false, stats, noise_floor: None, work: None };
        TimeRecord {
            head,
            passes: vec![g_buffer],
            total: Stats::from_samples(&[1.0]),
            noise_floor: None,
            frame: stats,
            drawn: DrawnCounts::default(),
            recorded: Vec::new(),
            skipped: Vec::new(),
            samples: Vec::new(),
        }
    }

    #[test]
    fn each_kind_of_g_buffer_has_a_drift_of_its_own() {
        // The G-buffer with triangles takes twice the time. Both take a tenth longer in the rows of roughness 0.1.
        let records = [
            record("ssct", Some("auto"), 0.0, 10.0),
            record("unified", Some("none"), 0.0, 10.0),
            record("unified", Some("auto"), 0.0, 20.0),
            record("traced", Some("none"), 0.0, 20.0),
            record("ssct", Some("auto"), 0.1, 11.0),
            record("unified", Some("auto"), 0.1, 22.0),
        ];
        let found: Vec<f64> = drift(&records).into_iter().map(|drift| drift.expect("a drift")).collect();
        for (drift, expected) in found.iter().zip([0.0, 0.0, 0.0, 0.0, 0.1, 0.1]) {
            assert!((drift - expected).abs() < 1e-9, "{found:?}");
        }
    }

    #[test]
    fn a_record_that_does_not_say_which_g_buffer_it_drew_has_no_drift() {
        let records = [record("unified", None, 0.0, 10.0), record("unified", None, 0.1, 20.0)];
        assert_eq!(drift(&records), [None, None]);
        let screen_alone = [record("ssct", None, 0.0, 10.0), record("ssct", None, 0.1, 20.0)];
        assert_eq!(drift(&screen_alone), [Some(0.0), Some(1.0)]);
    }
}
