//! The timing loop of all studies. Each round draws one frame of every shot, so that a change of the machine's speed
//! affects all shots alike, and draws the scene once for all of them. Each frame that counts goes into the journal as
//! soon as it is measured.

use super::journal::Journal;
use super::sound;
use super::zones::Zones;
use crate::error::Result;
use crate::stage::{SharedImages, Shot, Stage};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use ssct::gpu::FrameReport;
use ssct::gpu::frame::Mode;
use ssct::passes::gbuffer::DrawnCounts;
use ssct_scenes::Camera;

/// A timed frame, as the journal keeps it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Sample {
    /// Passes of the frame and their times.
    pub report: FrameReport,
    /// Counts of what the scene passes drew.
    pub drawn: DrawnCounts,
}

impl Sample {
    /// Returns the milliseconds of the passes that count, which are those of the method.
    pub fn effect_ms(&self) -> f64 {
        self.report.passes.iter().filter(|p| p.counted).map(|p| p.ms).sum()
    }
}

/// Returns the sample that a journal keeps under a key; `None` if the journal has no entry with the key, or an
/// unreadable one.
pub fn sample_in_journal(journal: &Journal, key: &str) -> Option<Sample> {
    journal.value(key).and_then(|value| parse_sample(value).ok())
}

/// Reads a sample from a value of a journal.
///
/// # Errors
/// Why the value is no sample, as the end of a sentence that begins with the value.
pub fn parse_sample(value: &Value) -> std::result::Result<Sample, String> {
    let sample = Sample::deserialize(value).map_err(|e| format!("is no sample of times: {e}"))?;
    sound::fault_of_sample(value).map_or(Ok(sample), Err)
}

/// A round, which draws one frame of every shot.
pub struct Round {
    /// Label of the round's frames in the journal; `None` for frames that warm up and do not count.
    pub label: Option<String>,
    /// Mode of measurement.
    pub mode: Mode,
    /// Camera of the shots; `None` leaves their cameras as they are.
    pub camera: Option<Camera>,
}

impl Round {
    /// Makes `warmup` rounds that warm up, and then `samples` timed rounds, labelled by their numbers from 0.
    pub fn timed(warmup: usize, samples: usize) -> Vec<Self> {
        let round = |label| Self { label, mode: Mode::Timed, camera: None };
        let warmups = (0..warmup).map(|_| round(None));
        warmups.chain((0..samples).map(|number| round(Some(number.to_string())))).collect()
    }
}

/// Draws the frames of the shots that the journal lacks, and puts them into the journal. `key` makes the key of a frame
/// from the index of its shot and the label of its round. A shot whose frames are all in the journal is not warmed up
/// either. `shared` has the images that the shots share. `progress` is called after each turn; its error ends the loop.
///
/// # Errors
/// Errors of the device, of the journal and of `progress`.
pub fn interleave(
    stage: &mut Stage,
    (shared, shots): (&mut SharedImages, &mut [Shot]),
    rounds: &[Round],
    key: &dyn Fn(usize, &str) -> String,
    journal: &mut Journal,
    progress: &mut dyn FnMut() -> Result<()>,
) -> Result<()> {
    let zones = Zones::begin();
    let lacks = |journal: &Journal, shot: usize| {
        rounds
            .iter()
            .filter_map(|r| r.label.as_deref())
            .any(|label| sample_in_journal(journal, &key(shot, label)).is_none())
    };
    let lacking: Vec<bool> = (0..shots.len()).map(|shot| lacks(journal, shot)).collect();
    for (round_index, round) in rounds.iter().enumerate() {
        shared.draw_anew();
        for turn in 0..shots.len() {
            // Each round begins with another shot, since the first shot of a round may find colder caches.
            let shot = (round_index + turn) % shots.len();
            let key = round.label.as_deref().map(|label| key(shot, label));
            if lacking[shot] && key.as_ref().is_none_or(|key| sample_in_journal(journal, key).is_none()) {
                if let Some(camera) = round.camera {
                    shots[shot].camera = camera;
                }
                let name = key.clone().unwrap_or_else(|| format!("shot {shot}, warm-up"));
                let draw = || shared.output(stage, round.mode, &shots[shot]);
                let (report, drawn, _) =
                    zones.frame(&name, draw, |result| result.as_ref().ok().map(|(report, ..)| report))?;
                if let Some(key) = key {
                    journal.put(key, &Sample { report, drawn })?;
                }
            }
            progress()?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct::gpu::{DeviceQuery, Gpu};
    use ssct::methods::{METHODS, Setup, Wants};
    use ssct_scenes::library;

    #[test]
    fn each_round_draws_the_scene_once_for_all_shots() {
        let gpu = Gpu::open(&DeviceQuery::default()).expect("a device");
        let scene = library::scene("corridor").expect("built in");
        let (view, setup) = (&scene.views[0], Setup::new([32, 18]));
        let (camera, materials) = (view.camera(&scene, setup.extent), scene.materials_in(view));
        let mut stage = Stage::new(&gpu, &scene).expect("a stage");
        let mut shared = SharedImages::default();
        let methods = METHODS[..2].iter().map(|method| (method, setup.clone()));
        let mut shots = shared.shots(&mut stage, methods, Wants::IMAGE, camera, &materials).expect("shots");
        let mut journal = Journal::resume([].into_iter(), None);
        let key = |shot: usize, label: &str| format!("{shot} {label}");
        let shared_and_shots = (&mut shared, &mut shots[..]);
        interleave(&mut stage, shared_and_shots, &Round::timed(0, 2), &key, &mut journal, &mut || Ok(()))
            .expect("samples");
        let scene_ms = |shot, round| {
            let sample = sample_in_journal(&journal, &key(shot, round)).expect("a sample");
            sample.report.passes.iter().filter(|p| !p.counted).map(|p| p.ms).collect::<Vec<_>>()
        };
        assert!(!scene_ms(0, "0").is_empty());
        assert_eq!(scene_ms(0, "0"), scene_ms(1, "0"), "one drawing");
        assert_eq!(scene_ms(0, "1"), scene_ms(1, "1"), "one drawing");
        assert_ne!(scene_ms(0, "0"), scene_ms(0, "1"), "each round draws anew");
    }
}
