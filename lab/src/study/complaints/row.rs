//! The rows of the study of complaints: a row has a case, a variant, and the number that measures the complaint.

use super::cases::COMPLAINTS;
use super::pictures::{self, TRUTH};
use crate::study::columns::{columns, figure};
use crate::study::engine::Row;
use crate::study::exhibit::{Clip, ClipGroup, Table, distinct, pivot};
use crate::study::record::{Provenance, RecordedSetup};
use serde_json::Value;

columns! {
    /// The result of a method on a case.
    pub struct ComplaintRow {
        /// Kind of the record, which is always `complaints`.
        pub kind: String,
        /// Program and device that measured.
        #[serde(flatten)]
        pub program: Provenance,
        /// Name of the case.
        pub case: String = figure(""),
        /// Complaint in one sentence.
        pub complaint: String = figure(""),
        /// Name of the method, followed by a comma and "screen alone" if the method is kept from seeing more.
        pub method: String = figure(""),
        /// Meaning of the value, in words.
        pub measured: String = figure(""),
        /// Number that measures the complaint, 0 for the truth; null if the method shows too little to be judged.
        pub value: Option<f64> = figure("").digits(2).signed(),
        /// Greatest value that is good.
        pub at_most: f64 = figure(""),
        /// Whether the value is good.
        pub is_good: bool = figure(""),
        /// Width of the first frame in pixels.
        pub width: u32 = figure(""),
        /// Height of the first frame in pixels.
        pub height: u32 = figure(""),
        /// Number of frames.
        pub frames: usize = figure(""),
        /// Everything that was set for the measurement, by name.
        pub setup: RecordedSetup,
    }
}

const ABOUT: &str = "A row for each complaint of engines' users, with one number for each method: how much of what is complained \
    of there is. 0 is the truth, which is the world reference, and numbers that are good are marked with a star. A dash stands \
    where a method shows less than half of the light that it should: nothing never flickers.";

const ABOUT_NUMBERS: &str = "Every number is a percentage, and 0 is the truth. A star marks a number that is good: one that is at most what the \
    column \"good\" says. Where wrong pixels are counted, 100 means that all of them are wrong, each by more than a tenth of white. \
    Where an error is measured, 100 means an error as large as the truth itself, as of a method that shows nothing, and numbers may \
    be greater. A dash means that the method shows less than half of the light, so that it cannot be judged.";

impl Row for ComplaintRow {
    const KIND: &'static str = "complaints";
    const TITLE: &'static str = "Complaints";
    const FOLDERS: &'static [&'static str] = &[pictures::FOLDER];

    fn program(&self) -> &Provenance {
        &self.program
    }

    /// Makes the table of numbers, and the table that says what the numbers mean.
    fn tables(rows: &[Self], _: &Value) -> Vec<Table> {
        vec![
            Table::new("complaints", "Complaints and methods", ABOUT, number_cells(rows)),
            Table::of_sentences(
                "meanings",
                "What is complained of, and what the numbers say",
                ABOUT_NUMBERS,
                meaning_cells(rows),
            ),
        ]
    }

    /// Returns the pictures of each case: the true reflection beside each method.
    fn clips(rows: &[Self]) -> Vec<ClipGroup> {
        let group = |case: &String| {
            let case_rows: Vec<&Self> = rows.iter().filter(|row| row.case == *case).collect();
            let complaint = COMPLAINTS.iter().find(|c| c.name == case)?;
            let clip = |name: &str, caption: String| {
                let file = pictures::file(complaint, name);
                Clip { file, name: name.to_owned(), caption }
            };
            let methods = case_rows.iter().map(|row| clip(&row.method, row.value_text()));
            let clips = std::iter::once(clip(TRUTH, String::new())).chain(methods).collect();
            Some(ClipGroup { title: format!("{case}: {}", complaint.complaint), clips })
        };
        distinct(rows.iter().map(|row| row.case.clone())).iter().filter_map(group).collect()
    }
}

impl ComplaintRow {
    /// Returns the value as tables show it.
    fn value_text(&self) -> String {
        let star = if self.is_good { "*" } else { "" };
        self.value.map_or_else(|| "-".to_owned(), |value| format!("{value:.1}{star}"))
    }
}

/// Makes the cells of the table of numbers: a line for each case and a column for each method. The second column has
/// the greatest number that is good.
fn number_cells(rows: &[ComplaintRow]) -> Vec<Vec<String>> {
    let (case_name, method_name) = (|r: &ComplaintRow| r.case.clone(), |r: &ComplaintRow| r.method.clone());
    let mut cells =
        pivot("complaint", rows, [&case_name, &method_name], |cell_rows| cell_rows.first().map(|row| row.value_text()));
    for (line_index, line) in cells.iter_mut().enumerate() {
        let first_of_case = rows.iter().find(|row| row.case == line[0]);
        let at_most = first_of_case.map_or_else(String::new, |row| row.at_most.to_string());
        line.insert(1, if line_index == 0 { "good".to_owned() } else { format!("≤ {at_most}") });
    }
    cells
}

/// Makes the cells of the table that describes the cases: a line for each, with its complaint and the meaning of its
/// number.
fn meaning_cells(rows: &[ComplaintRow]) -> Vec<Vec<String>> {
    let mut cells = vec![["complaint", "what users say", "number"].map(str::to_owned).to_vec()];
    let meaning = |row: &ComplaintRow| vec![row.case.clone(), row.complaint.clone(), row.measured.clone()];
    cells.extend(distinct(rows.iter().map(meaning)));
    cells
}
