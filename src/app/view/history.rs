//! Pass times of the last frames of a method, for the stacked bars.

use crate::gpu::FrameReport;
use crate::gpu::frame::Skipped;
use crate::study::Stats;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// How far back the bars reach.
const KEPT: Duration = Duration::from_secs(10);
/// The most frames kept.
const FRAMES: usize = 240;

/// A stage of a frame: a pass, or the levels of a chain added up.
#[derive(Debug, Clone, PartialEq)]
pub struct StageTime {
    /// Label, without a level.
    pub name: String,
    /// Milliseconds.
    pub ms: f64,
    /// Whether it counts towards the method's time.
    pub counted: bool,
}

/// The times of a method's last frames.
#[derive(Debug, Default)]
pub struct History {
    frames: VecDeque<(Instant, Vec<StageTime>)>,
    /// Labels of the passes of the last frame.
    pub recorded: Vec<String>,
    /// Passes that the last frame did not need, and why.
    pub skipped: Vec<Skipped>,
}

impl History {
    /// Adds a frame that was timed at a time.
    pub fn add(&mut self, report: &FrameReport, now: Instant) {
        let mut stages: Vec<StageTime> = Vec::new();
        for pass in &report.passes {
            let name = pass.name.split('/').next().unwrap_or(&pass.name);
            match stages.iter_mut().find(|s| s.name == name && s.counted == pass.counted) {
                Some(stage) => stage.ms += pass.ms,
                None => stages.push(StageTime { name: name.to_owned(), ms: pass.ms, counted: pass.counted }),
            }
        }
        // Another chain of passes is another method or setting: its times are not comparable.
        let names = |s: &[StageTime]| s.iter().map(|s| s.name.clone()).collect::<Vec<_>>();
        if self.frames.back().is_some_and(|(_, last)| names(last) != names(&stages)) {
            self.frames.clear();
        }
        self.frames.push_back((now, stages));
        let is_old = |f: Option<&(Instant, _)>| f.is_some_and(|(at, _)| now.duration_since(*at) > KEPT);
        while self.frames.len() > FRAMES || is_old(self.frames.front()) {
            self.frames.pop_front();
        }
        self.recorded.clone_from(&report.recorded);
        self.skipped.clone_from(&report.skipped);
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.frames.clear();
    }

    /// Every frame's stages, oldest first.
    pub fn frames(&self) -> impl Iterator<Item = &[StageTime]> {
        self.frames.iter().map(|(_, stages)| &stages[..])
    }

    /// Each stage's name, whether it counts, and its times over the frames.
    pub fn stages(&self) -> Vec<(String, bool, Stats)> {
        let Some((_, last)) = self.frames.back() else { return Vec::new() };
        let of = |i: usize| self.frames.iter().map(|(_, stages)| stages[i].ms).collect::<Vec<_>>();
        last.iter().enumerate().map(|(i, s)| (s.name.clone(), s.counted, Stats::of(&of(i)))).collect()
    }

    /// The method's time: the sum of the stages that count, over the frames.
    pub fn total(&self) -> Stats {
        let sum = |stages: &[StageTime]| stages.iter().filter(|s| s.counted).map(|s| s.ms).sum();
        Stats::of(&self.frames().map(sum).collect::<Vec<f64>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::PassTime;

    fn report(passes: &[(&str, f64, bool)]) -> FrameReport {
        let pass =
            |(name, ms, counted): &(&str, f64, bool)| PassTime { name: (*name).into(), ms: *ms, counted: *counted };
        FrameReport { passes: passes.iter().map(pass).collect(), ..FrameReport::default() }
    }

    #[test]
    fn levels_add_up_scene_passes_do_not_count_and_other_passes_begin_anew() {
        let (mut history, now) = (History::default(), Instant::now());
        for ms in [1.0, 3.0, 2.0] {
            history.add(&report(&[("g-buffer", 9.0, false), ("hi-z/1", ms, true), ("hi-z/2", 0.5, true)]), now);
        }
        assert_eq!((history.total().median_ms, history.total().samples), (2.5, 3));
        let stages = history.stages();
        assert_eq!(stages.iter().map(|s| (&s.0[..], s.1)).collect::<Vec<_>>(), [("g-buffer", false), ("hi-z", true)]);
        history.add(&report(&[("ray trace", 4.0, true)]), now);
        assert_eq!(history.total().samples, 1, "another method's times are no samples of this one");
        history.add(&report(&[("ray trace", 5.0, true)]), now + KEPT * 2);
        assert_eq!(history.total().median_ms, 5.0, "what is old is forgotten");
    }
}
