//! The data from which the page's script compares two runs: the figures of each run, and the total time of each frame.
//! Each text is stored once, in a list; everywhere else its index in the list stands for it.

use super::LibraryPage;
use crate::study::compare::{Run, SEED, SUBJECT_COLUMNS, Subject, TimeSample, subject_labels};
use crate::study::library::Measurement;
use crate::study::library::trends::devices;
use serde_json::{Value as Json, json};
use ssct::gpu::DeviceInfo;
use ssct_truth::metrics::bootstrap::{CONFIDENCE, MIN_SAMPLES, RESAMPLES};
use std::collections::HashMap;
use std::sync::Arc;

/// The data as JSON that can stand in a script element.
pub fn embedded_json(page: &LibraryPage) -> String {
    let mut names = Names::default();
    let devices = devices(&page.library.runs);
    let device_index = |device: &DeviceInfo| devices.iter().position(|known| *known == device);
    let runs: Vec<Json> = page
        .library
        .runs
        .iter()
        .map(|run| {
            let figures = run.measurements.iter().filter(|m| !m.quantity.is_time());
            json!({
                "name": run.name,
                "date": run.date,
                "devices": run.devices.iter().map(device_index).collect::<Vec<_>>(),
                "figures": figures.map(|m| names.figure(m)).collect::<Vec<_>>(),
                "samples": run.samples.as_ref().map(|samples| names.samples(samples)),
                "samplesDevice": run.samples.as_ref().and_then(|samples| device_index(samples.device.as_ref()?)),
            })
        })
        .collect();
    // The page first shows the two runs of the latest change or, without a change, the last two runs of the last trend.
    let runs_of_change = page.changes.last().map(|c| [c.before, c.after]);
    let runs_of_trend = || page.trends.last().and_then(|t| t.runs.last_chunk::<2>().copied());
    let data = json!({
        "first": runs_of_change.or_else(runs_of_trend),
        "seed": SEED,
        "resamples": RESAMPLES,
        "confidence": CONFIDENCE,
        "minSamples": MIN_SAMPLES,
        "threshold": page.threshold,
        "columns": SUBJECT_COLUMNS,
        "devices": devices.iter().map(|d| format!("{} ({})", d.name, d.driver)).collect::<Vec<_>>(),
        "runs": runs,
        "names": names.list,
    });
    // A text may have a `<`, which could end the element or begin a comment.
    data.to_string().replace('<', "\\u003c")
}

/// A list of texts without duplicates.
#[derive(Default)]
struct Names {
    list: Vec<String>,
    /// The index of each text in the list.
    known: HashMap<String, usize>,
}

impl Names {
    /// Returns the index of a text in the list, to which it is added if it is new.
    fn index(&mut self, name: &str) -> usize {
        if let Some(index) = self.known.get(name) {
            return *index;
        }
        self.list.push(name.to_owned());
        self.known.insert(name.to_owned(), self.list.len() - 1);
        self.list.len() - 1
    }

    /// Returns a figure as an array: the indices of the texts of its place, the rest of its setting, its method and its
    /// title, and then its value.
    fn figure(&mut self, figure: &Measurement) -> Json {
        let Measurement { setting, view, method, quantity, value, .. } = figure;
        let [width, height] = setting.size;
        let place = format!("{} {view}, {width}x{height}, roughness {}", setting.scene, setting.roughness);
        let settings = setting.other_settings.join(", ");
        json!([self.index(&place), self.index(&settings), self.index(method), self.index(quantity.title()), value])
    }

    /// Returns the total times of a run's frames as an array with an element for each subject, in order of appearance.
    /// An element has pairs of the name and the value of each setting, the labels of the subject, its noise floor, and
    /// the times in milliseconds. Texts are given by their indices.
    fn samples(&mut self, run: &Run) -> Json {
        let mut groups: Vec<(&Arc<Subject>, Vec<&TimeSample>)> = Vec::new();
        for sample in &run.samples {
            match groups.iter_mut().rev().find(|(subject, _)| **subject == sample.subject) {
                Some((_, samples)) => samples.push(sample),
                None => groups.push((&sample.subject, vec![sample])),
            }
        }
        let group = |(subject, samples): &(&Arc<Subject>, Vec<&TimeSample>)| {
            let settings: Vec<[usize; 2]> =
                subject.0.iter().map(|(name, value)| [self.index(name), self.index(value)]).collect();
            let labels = subject_labels(subject).map(|label| self.index(&label));
            let floor = samples.first().and_then(|s| s.floors[0]);
            json!([settings, labels, floor, samples.iter().map(|s| s.ms).collect::<Vec<_>>()])
        };
        groups.iter().map(group).collect()
    }
}
