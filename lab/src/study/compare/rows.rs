//! Makes rows of a table of comparisons of times, the most important first.

use super::subject::NOT_SET;
use super::{Subject, TOTAL, TimeComparison};
use crate::study::record::changed_value;
use ssct::methods::{self, MethodInfo};
use ssct_ground::parameter::{Choices, Preset};
use ssct_truth::metrics::bootstrap::{MIN_SAMPLES, MOST_FORETOLD, Ratio, Verdict};

/// The headers of the texts of [`subject_labels`], in the same order.
pub const SUBJECT_COLUMNS: [&str; 6] = ["scene view", "size", "roughness", "normals", "method", "preset"];

/// Describes the subject of a comparison by a text for each of [`SUBJECT_COLUMNS`].
pub fn subject_labels(s: &Subject) -> [String; 6] {
    let value_or_not_set = |name: &str| match s.get(name) {
        "" => NOT_SET.to_owned(),
        value => value.to_owned(),
    };
    let place = format!("{} {}", s.get("scene"), s.get("view"));
    let size = format!("{}x{}", s.get("width"), s.get("height"));
    let [roughness, normals] = ["roughness", "normal_deviation"].map(value_or_not_set);
    [place, size, roughness, normals, method_label(s), s.get("preset").to_owned()]
}

/// Names the method of a subject, and in brackets the parameters that differ from its preset.
fn method_label(s: &Subject) -> String {
    let name = s.get("method");
    let preset = Preset::of_name(s.get("preset")).unwrap_or_default();
    let parameters = methods::find(name).map_or_else(|_| Vec::new(), MethodInfo::read_parameters);
    let values: Vec<_> = parameters.iter().filter_map(|p| changed_value(p, preset, s.get(p.name))).collect();
    if values.is_empty() { name.to_owned() } else { format!("{name} ({})", values.join(", ")) }
}

/// The text between the values of A and of B in a column in which they differ.
const BETWEEN_SIDES: &str = " / ";

impl TimeComparison {
    /// Returns a text for each of [`SUBJECT_COLUMNS`]. Where the sides differ, it has the texts of both.
    fn subject_labels(&self) -> [String; 6] {
        let [mut labels, labels_of_b] = [0, 1].map(|side| {
            let mut subject = self.subject.clone();
            subject.0.extend(self.differing.iter().map(|(name, values)| (name.clone(), values[side].clone())));
            subject_labels(&subject)
        });
        for (label, label_of_b) in labels.iter_mut().zip(labels_of_b) {
            if *label != label_of_b {
                *label = format!("{label}{BETWEEN_SIDES}{label_of_b}");
            }
        }
        labels
    }

    /// Returns the labels of a row: one for each of [`SUBJECT_COLUMNS`], and the pass. In a comparison of two settings,
    /// the settings of A and of B stand in the columns of method and preset.
    pub fn labels(&self) -> [String; 7] {
        let [place, size, roughness, normals, method, preset] = self.subject_labels();
        let [method_or_a, preset_or_b] = match (&self.setting_a, &self.setting_b) {
            (Some(a), Some(b)) => [a.clone(), b.clone()],
            _ => [method, preset],
        };
        [place, size, roughness, normals, method_or_a, preset_or_b, self.pass.clone()]
    }

    /// Returns the verdict as tables show it. If it is undecided, the text gives the number of samples that would
    /// probably decide, and says whether the noise floor alone leaves it undecided.
    fn shown_verdict(&self) -> String {
        let undecided = if self.is_open_by_floor() { "UNDECIDED by the floor" } else { "UNDECIDED" };
        match (self.verdict, self.samples_to_decide) {
            (Some(Verdict::Undecided), Some(samples)) => format!("{undecided}, n about {samples}"),
            (Some(Verdict::Undecided), None) => format!("{undecided}, n above {MOST_FORETOLD}"),
            (verdict, _) => verdict.map_or("-", Verdict::name).to_owned(),
        }
    }

    /// Whether an undecided verdict would be decided if the noise floor were 0.
    fn is_open_by_floor(&self) -> bool {
        let (Some(ratio), Some(low), Some(high), Some(_)) = (self.ratio, self.low, self.high, self.noise_floor) else {
            return false;
        };
        let has_enough = self.samples_a.min(self.samples_b) >= MIN_SAMPLES;
        has_enough
            && Verdict::for_ratio(&Ratio { ratio, low, high }, self.judgement.threshold, 0.0) != Verdict::Undecided
    }

    /// Returns the sort key of a row in a table: the number of its class, and its place in the class. The total comes
    /// first, then counted passes that became faster or slower, the greatest difference first. Other counted passes and
    /// then passes that do not count follow, the longest first.
    fn rank(&self) -> (u8, f64) {
        let (a, b) = (self.median_a_ms.unwrap_or(0.0), self.median_b_ms.unwrap_or(0.0));
        let is_decided = matches!(self.verdict, Some(Verdict::Faster | Verdict::Slower));
        match (self.pass == TOTAL, self.counted, is_decided) {
            (true, ..) => (0, 0.0),
            (_, true, true) => (1, -(b - a).abs()),
            (_, true, false) => (2, -a.max(b)),
            (_, false, _) => (3, -a.max(b)),
        }
    }
}

/// Returns a note on the word "own", which stands for a value that no option set; `None` if no row of [`cells`] has the
/// word.
pub fn note_on_own(records: &[TimeComparison]) -> Option<&'static str> {
    let is_own = |label: &String| label.split(BETWEEN_SIDES).any(|value| value == NOT_SET);
    let has_own = |r: &TimeComparison| r.only_in.is_none() && r.subject_labels().iter().any(is_own);
    records.iter().any(has_own).then_some("own: each material has its own value, since no option set one.")
}

/// Returns a drift as tables show it, in percent with its sign; a dash if there is none.
pub fn shown_drift(drift: Option<f64>) -> String {
    drift.map_or_else(|| "-".to_owned(), |drift| format!("{:+.0} %", 100.0 * drift))
}

/// Returns the records of passes that both sides have, in the order of a table. Records of one subject and one pair of
/// settings stay together, the most important first. If `with_parts` is true, each group of passes is followed by its
/// parts; otherwise the parts are left out.
pub fn ordered(records: &[TimeComparison], with_parts: bool) -> Vec<&TimeComparison> {
    let is_same_subject = |a: &&TimeComparison, b: &&TimeComparison| {
        a.subject == b.subject && a.setting_a == b.setting_a && a.setting_b == b.setting_b
    };
    let in_both: Vec<&TimeComparison> = records.iter().filter(|r| r.only_in.is_none()).collect();
    let mut rows = Vec::new();
    for subject_records in in_both.chunk_by(is_same_subject) {
        let mut wholes: Vec<_> = subject_records.iter().filter(|r| r.part_of.is_none()).collect();
        wholes.sort_by(|x, y| {
            let ((class_x, place_x), (class_y, place_y)) = (x.rank(), y.rank());
            class_x.cmp(&class_y).then(place_x.total_cmp(&place_y))
        });
        for row in wholes {
            rows.push(*row);
            let is_part = |r: &&&TimeComparison| r.part_of.as_ref() == Some(&row.pass) && r.counted == row.counted;
            rows.extend(subject_records.iter().filter(|_| with_parts).filter(is_part));
        }
    }
    rows
}

/// Returns the cells of a table: a header, and a line for each record that [`ordered`] returns. If `with_parts`
/// is true, groups of passes are followed by their parts.
pub fn cells(records: &[TimeComparison], with_parts: bool) -> Vec<Vec<String>> {
    let has_drift = records.iter().any(|r| r.drift.is_some());
    let figures = ["pass", "A ms", "B ms", "B/A", "low", "high", "floor"];
    let figure_headers =
        figures.into_iter().chain(has_drift.then_some("drift")).chain(["n", "verdict"]).collect::<Vec<_>>();
    let mut subject_headers = SUBJECT_COLUMNS;
    if records.iter().any(|r| r.setting_a.is_some()) {
        // The settings of A and of B take the columns of method and preset.
        [subject_headers[4], subject_headers[5]] = ["A", "B"];
    }
    let mut rows =
        vec![[&subject_headers[..], &figure_headers].concat().into_iter().map(str::to_owned).collect::<Vec<_>>()];
    let number = |v: Option<f64>| v.map_or_else(|| "-".into(), |v| format!("{v:.3}"));
    for r in ordered(records, with_parts) {
        let mut row = r.labels().to_vec();
        row.extend([r.median_a_ms, r.median_b_ms, r.ratio, r.low, r.high].map(number));
        row.push(r.noise_floor.map_or_else(|| "-".into(), |floor| format!("{:.1} %", floor * 100.0)));
        row.extend(has_drift.then(|| shown_drift(r.drift)));
        row.push(format!("{}/{}", r.samples_a, r.samples_b));
        row.push(r.shown_verdict());
        rows.push(row);
    }
    rows
}
