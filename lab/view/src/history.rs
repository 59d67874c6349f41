//! Keeps the pass times of a method's recent frames, which the panel shows as stacked bars.

use ssct::gpu::FrameReport;
use ssct::gpu::frame::Skipped;
use ssct_lab::study::Stats;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// The greatest age of a frame that is kept.
const MAX_AGE: Duration = Duration::from_secs(10);
/// The most frames that are kept.
const MAX_FRAMES: usize = 240;

/// The time of a pass, or of all levels of a chain together, in one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct StageTime {
    /// The label, without a level.
    pub name: String,
    /// Milliseconds.
    pub ms: f64,
    /// Whether the stage counts towards the method's time.
    pub counted: bool,
}

/// The times of a method's recent frames.
#[derive(Debug, Default)]
pub struct History {
    /// The frames, oldest first: when each was measured, and its times.
    frames: VecDeque<(Instant, Vec<StageTime>)>,
    /// Labels of the passes that the last frame recorded.
    pub recorded: Vec<String>,
    /// Passes that the last frame skipped, with the reasons.
    pub skipped: Vec<Skipped>,
}

impl History {
    /// Adds a frame that was measured at the time `now`, and removes frames that are too old.
    pub fn add(&mut self, report: &FrameReport, now: Instant) {
        let mut stages: Vec<StageTime> = Vec::new();
        for pass in &report.passes {
            let name = pass.name.split('/').next().unwrap_or(&pass.name);
            match stages.iter_mut().find(|s| s.name == name && s.counted == pass.counted) {
                Some(stage) => stage.ms += pass.ms,
                None => stages.push(StageTime { name: name.to_owned(), ms: pass.ms, counted: pass.counted }),
            }
        }
        // A different list of passes means another method or setting, whose times are not comparable.
        let stage_names = |s: &[StageTime]| s.iter().map(|s| s.name.clone()).collect::<Vec<_>>();
        if self.frames.back().is_some_and(|(_, last)| stage_names(last) != stage_names(&stages)) {
            self.frames.clear();
        }
        self.frames.push_back((now, stages));
        let is_old = |frame: Option<&(Instant, _)>| frame.is_some_and(|(time, _)| now.duration_since(*time) > MAX_AGE);
        while self.frames.len() > MAX_FRAMES || is_old(self.frames.front()) {
            self.frames.pop_front();
        }
        self.recorded.clone_from(&report.recorded);
        self.skipped.clone_from(&report.skipped);
    }

    /// Removes all frames.
    pub fn clear(&mut self) {
        self.frames.clear();
    }

    /// Returns the stages of every frame, oldest first.
    pub fn frames(&self) -> impl Iterator<Item = &[StageTime]> {
        self.frames.iter().map(|(_, stages)| &stages[..])
    }

    /// Returns, for each stage, its name, whether it counts towards the method's time, and statistics of its times.
    pub fn stages(&self) -> Vec<(String, bool, Stats)> {
        let Some((_, last)) = self.frames.back() else { return Vec::new() };
        let times = |i: usize| self.frames.iter().map(|(_, stages)| stages[i].ms).collect::<Vec<_>>();
        last.iter().enumerate().map(|(i, s)| (s.name.clone(), s.counted, Stats::from_samples(&times(i)))).collect()
    }

    /// Returns statistics of the method's time, which is the sum of the stages that count.
    pub fn total(&self) -> Stats {
        let sum = |stages: &[StageTime]| stages.iter().filter(|s| s.counted).map(|s| s.ms).sum();
        Stats::from_samples(&self.frames().map(sum).collect::<Vec<f64>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct::gpu::PassTime;

    /// Returns the report of a frame from the name, the milliseconds and `counted` of each pass.
    fn report(passes: &[(&str, f64, bool)]) -> FrameReport {
        let pass = |(name, ms, counted): &(&str, f64, bool)| PassTime {
            name: (*name).into(),
            ms: *ms,
            start_ms: 0.0,
            counted: *counted,
        };
        FrameReport { passes: passes.iter().map(pass).collect(), ..FrameReport::default() }
    }

    #[test]
    fn levels_add_up_scene_passes_do_not_count_and_new_passes_reset_the_history() {
        let (mut history, now) = (History::default(), Instant::now());
        for ms in [1.0, 3.0, 2.0] {
            history.add(&report(&[("g-buffer", 9.0, false), ("hi-z/1", ms, true), ("hi-z/2", 0.5, true)]), now);
        }
        assert_eq!((history.total().median_ms, history.total().samples), (2.5, 3));
        let stages = history.stages();
        assert_eq!(stages.iter().map(|s| (&s.0[..], s.1)).collect::<Vec<_>>(), [("g-buffer", false), ("hi-z", true)]);
        history.add(&report(&[("ray trace", 4.0, true)]), now);
        assert_eq!(history.total().samples, 1, "another method's times are no samples of this one");
        history.add(&report(&[("ray trace", 5.0, true)]), now + MAX_AGE * 2);
        assert_eq!(history.total().median_ms, 5.0, "what is old is forgotten");
    }
}
