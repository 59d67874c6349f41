//! The page of a library: its runs, the changes that each run brought, figures over runs, and two runs side by side,
//! which the reader chooses. The page needs no server.

mod data;

use super::sections::{grid, inline_svg};
use super::{assemble, device_text, heading, page_header};
use crate::report::library::Library;
use crate::report::plot;
use crate::study::compare::{SUBJECT_COLUMNS, TimeComparison, subject_labels};
use crate::study::library::changes::RunChange;
use crate::study::library::trends::{Trend, TrendLine, devices};
use crate::study::library::{DatedBy, LibraryRun, Quantity, Setting};
use crate::study::names::{count_text, name_among};
use crate::study::record::DEFINITIONS;
use maud::{Markup, PreEscaped, html};
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use ssct::gpu::DeviceInfo;
use ssct_truth::metrics::bootstrap::{CONFIDENCE, Verdict};

/// The page's title, by which a page of a library is known from others.
pub const TITLE: &str = "Library of results";

/// Everything that the page shows.
pub struct LibraryPage<'a> {
    /// The command that made the page.
    pub command: &'a str,
    /// The runs, and the folders without runs.
    pub library: &'a Library,
    /// Figures over runs.
    pub trends: &'a [Trend],
    /// Comparisons of each run with an earlier one.
    pub changes: &'a [RunChange],
    /// The method by whose times the times of the others are divided.
    pub base: &'a str,
    /// Change of a time that counts, as a share.
    pub threshold: f64,
    /// The path from the page's folder to the library's: empty, or with a slash at its end. `None` if the library is
    /// not below the page's folder; then the page has no links to the runs.
    pub path_to_runs: Option<&'a str>,
}

/// Parts of the page: id and title.
const PARTS: [(&str, &str); 5] = [
    ("runs", "Runs"),
    ("changes", "What each run changed"),
    ("trends", "Figures over runs"),
    ("compare", "Two runs beside each other"),
    ("left-out", "What is left out"),
];

/// The characters of a path that a link needs percent-encoded.
const PATH_ENCODE_SET: &AsciiSet = &NON_ALPHANUMERIC.remove(b'/').remove(b'.').remove(b'-').remove(b'_');

/// The greatest number of places for which the page shows all trends at once. With more places, the reader opens the
/// trends of each.
const FEW_PLACES: usize = 6;

impl LibraryPage<'_> {
    /// Returns the whole page as HTML.
    ///
    /// # Errors
    /// The reason why a plot cannot be drawn.
    pub fn render(&self) -> Result<String, String> {
        let [runs, changes, trends, compare, left_out] = PARTS.map(heading);
        let parts = PARTS.map(|(id, title)| (id.to_owned(), title));
        let body = html! {
            (runs) (self.runs())
            (changes) (self.changes())
            (trends) (self.trends()?)
            (compare) (self.compare())
            (left_out) (self.left_out())
            script type="application/json" id="library-data" { (PreEscaped(data::embedded_json(self))) }
            script { (PreEscaped(include_str!("library/library.js"))) }
        };
        Ok(assemble(TITLE, &page_header(TITLE, None, DEFINITIONS, self.command, &parts), &body))
    }

    /// The list of devices, and the table of runs.
    fn runs(&self) -> Markup {
        let devices = devices(&self.library.runs);
        html! {
            p {
                (count_text(self.library.runs.len(), "run")) " on " (count_text(devices.len(), "device"))
                ", by date, and on one day by name."
            }
            dl {
                @for d in &devices { dt { (device_label(&devices, d)) } dd { (device_text(d)) } }
            }
            div.scroll {
                table {
                    thead {
                        tr {
                            @for name in ["run", "date", "program", "definitions", "device", "records"] {
                                th scope="col" { (name) }
                            }
                        }
                    }
                    tbody {
                        @for (n, run) in self.library.runs.iter().enumerate() { (self.run(n, run, &devices)) }
                    }
                }
            }
            @if self.library.runs.iter().any(|run| run.dated_by == DatedBy::Files) {
                p { "A date in brackets is that of the files, since no folder on the run's path has one in its name." }
            }
        }
    }

    /// Returns the row of the run with the index `n`, whose number on the page is `n + 1`.
    fn run(&self, n: usize, run: &LibraryRun, devices: &[&DeviceInfo]) -> Markup {
        let labels: Vec<_> = run.devices.iter().map(|d| device_label(devices, d)).collect();
        let definitions: Vec<_> = run.definitions.iter().map(u32::to_string).collect();
        html! {
            tr id={ "run-" (n + 1) } {
                th scope="row" { (n + 1) ". " (run.name) }
                td.whole { @if run.dated_by == DatedBy::Files { "(" (run.date) ")" } @else { (run.date) } }
                td { @for program in &run.programs { span.whole { (program) } " " } }
                td { (definitions.join(", ")) }
                td { (labels.join(", ")) }
                td {
                    @for (n, file) in run.files.iter().enumerate() {
                        @if n > 0 { ", " }
                        (self.link(run, &file.file)) ": " (file.records)
                    }
                    @if run.has_page { ", " (self.link(run, "index.html")) }
                    @if let Some([failed, all]) = run.stress { "; " (failed) " of " (all) " cases failed" }
                    @for note in &run.notes { br; em { (note) } }
                }
            }
        }
    }

    /// A link to a file of a run; the name of the file alone if the page has no links.
    fn link(&self, run: &LibraryRun, file: &str) -> Markup {
        let Some(path_to_runs) = self.path_to_runs else { return html! { (file) } };
        let folder = if run.name == "." { String::new() } else { format!("{}/", run.name) };
        let path = format!("{path_to_runs}{folder}{file}");
        html! { a href=(utf8_percent_encode(&path, PATH_ENCODE_SET)) { (file) } }
    }

    /// The part on changes, with the text about all of them.
    fn changes(&self) -> Markup {
        html! {
            p {
                "Each run with raw samples of its times beside the latest one before it on the same device that timed "
                "something in common: the medians of the effect's time, later over earlier, judged as "
                code { "ssct compare" } " does, with a " (format!("{:.0} %", CONFIDENCE * 100.0))
                " interval and a threshold of " (format!("{:.0} %", self.threshold * 100.0)) ". The interval covers "
                "the spread within each run, but not what changed on the machine between them."
            }
            @if self.changes.is_empty() { p { "No two runs on one device have raw samples of the same." } }
            @for change in self.changes { (self.change(change)) }
        }
    }

    /// The counts of verdicts of one change, and a table of the times that became faster or slower.
    fn change(&self, change: &RunChange) -> Markup {
        let count = |verdict| change.totals.iter().filter(|t| t.verdict == Some(verdict)).count();
        let counts: Vec<_> = Verdict::ALL.iter().map(|v| format!("{} {}", count(*v), v.name())).collect();
        let changed: Vec<_> = change.totals.iter().filter(|t| is_changed(t)).collect();
        let warning = change.totals.iter().find_map(|t| t.warning.as_ref());
        html! {
            h3 { (self.run_name(change.after)) " after " (self.run_name(change.before)) }
            p { (counts.join(", ")) "." }
            @if let Some(warning) = warning { p { "Warning: " (warning) "." } }
            @if !changed.is_empty() {
                details {
                    summary { "The " (changed.len()) " that are faster or slower" }
                    (grid(&change_cells(&changed)))
                }
            }
        }
    }

    /// The number of a run, counted from 1, and its name.
    fn run_name(&self, run: usize) -> String {
        format!("{}. {}", run + 1, self.library.runs[run].name)
    }

    /// The part on trends: for each device, its places with their trends.
    fn trends(&self) -> Result<Markup, String> {
        let mut places: Vec<(&Trend, Vec<&Trend>)> = Vec::new();
        for trend in self.trends {
            match places.last_mut() {
                Some((first, trends)) if is_one_place(first, trend) => trends.push(trend),
                _ => places.push((trend, vec![trend])),
            }
        }
        let open = places.len() <= FEW_PLACES;
        let all_devices = devices(&self.library.runs);
        let mut shown = Vec::new();
        let mut last_device: Option<&DeviceInfo> = None;
        for (first, trends) in &places {
            // The trends of each device stand under a heading with its name.
            if last_device.replace(&first.device) != Some(&first.device) {
                let (label, name) =
                    (device_label(&all_devices, &first.device), name_among(&first.device, &all_devices));
                shown.push(html! { h3 { (label) ": " (name) } });
            }
            shown.push(self.place(first, trends, open)?);
        }
        Ok(html! {
            p {
                "Each value is the median over the views that are named. A time is the method's over that of "
                code { (self.base) } " in the same run on the same device; milliseconds of different runs or devices "
                "are not compared. A line joins only runs that measured the same views in the same setting; figures "
                "that one run alone measured are in its own files. An error also depends on its reference, whose rays "
                "and bounces the records do not say: a run with another reference may lie off its line."
            }
            @if shown.is_empty() { p { "No two runs on one device measured the same views in the same setting." } }
            @for part in shown { (part) }
        })
    }

    /// Returns the trends of one place, of which `first` is one. If `open` is true, the reader sees them without
    /// opening them.
    fn place(&self, first: &Trend, trends: &[&Trend], open: bool) -> Result<Markup, String> {
        let plots = trends.iter().map(|trend| self.trend(trend)).collect::<Result<Vec<_>, _>>()?;
        let runs = trends.iter().map(|t| t.runs.len()).max().unwrap_or(0);
        Ok(html! {
            details open[open] {
                summary { (place_title(&first.setting, &first.views)) ", up to " (count_text(runs, "run")) }
                p { "Views: " (first.views.join(", ")) ". Setting: " (first.setting.other_settings.join(", ")) "." }
                @for plot in plots { (plot) }
            }
        })
    }

    /// Returns a trend as a plot and as a table.
    fn trend(&self, trend: &Trend) -> Result<Markup, String> {
        let title = self.title(trend.quantity);
        let numbers: Vec<usize> = trend.runs.iter().map(|run| run + 1).collect();
        let svg = plot::draw_trend(&numbers, &trend.lines, &title)?;
        let label = format!("{title} over runs; the table below has the same values");
        Ok(html! {
            h4 { (title) }
            (inline_svg(&svg, &label))
            details { summary { "As a table" } (grid(&self.trend_cells(trend))) }
        })
    }

    /// The title of a quantity; a time is given as a ratio to the time of the base method.
    fn title(&self, quantity: Quantity) -> String {
        if quantity.is_time() {
            format!("{} over {}", quantity.title(), self.base)
        } else {
            quantity.title().to_owned()
        }
    }

    /// Returns the table of a trend: a header, a row for each method, and a column for each run.
    fn trend_cells(&self, trend: &Trend) -> Vec<Vec<String>> {
        let run = |index: &usize| format!("{}. {}", index + 1, self.library.runs[*index].date);
        let mut cells =
            vec![std::iter::once("method".to_owned()).chain(trend.runs.iter().map(run)).collect::<Vec<_>>()];
        let value = |v: &Option<f64>| v.map_or_else(|| "-".to_owned(), figure_text);
        let row =
            |line: &TrendLine| std::iter::once(line.method.clone()).chain(line.values.iter().map(value)).collect();
        cells.extend(trend.lines.iter().map(row));
        cells
    }

    /// The elements that the script fills with the comparison of two runs.
    fn compare(&self) -> Markup {
        html! {
            noscript {
                p { "Choosing two runs takes a script. " code { "ssct compare A B" } " says the same of two folders." }
            }
            div #choose-runs hidden {
                p {
                    label { "Run A " select #run-a {} } " "
                    label { "Run B " select #run-b {} }
                }
                p #about-runs role="status" {}
                h3 { "Times" }
                div #compared-times {}
                h3 { "Errors" }
                div #compared-errors {}
            }
        }
    }

    /// The folders that cannot be read, and the folders without records.
    fn left_out(&self) -> Markup {
        let library = self.library;
        html! {
            @if library.unreadable.is_empty() { p { "Every folder with records was read." } }
            @else {
                p { "These folders should hold a run and cannot be read:" }
                ul { @for (folder, why) in &library.unreadable { li { (folder) ": " (why) } } }
            }
            @if !library.without_records.is_empty() {
                details {
                    summary { "Folders with files, but no records of the studies: " (library.without_records.len()) }
                    ul { @for folder in &library.without_records { li { (folder) } } }
                }
            }
        }
    }
}

/// A device's label on the page: D and its number among the library's devices.
fn device_label(devices: &[&DeviceInfo], device: &DeviceInfo) -> String {
    format!("D{}", devices.iter().position(|known| *known == device).map_or(0, |index| index + 1))
}

/// True if two trends are of one device, one setting and the same views; the page puts these under one heading.
fn is_one_place(a: &Trend, b: &Trend) -> bool {
    a.device == b.device && a.setting == b.setting && a.views == b.views
}

/// A line that names a place: scene, views, size and roughness.
fn place_title(setting: &Setting, views: &[String]) -> String {
    let [width, height] = setting.size;
    let views = match views {
        [view] => view.clone(),
        several => format!("{} views", several.len()),
    };
    format!("{}, {views}, {width} × {height}, roughness {}", setting.scene, setting.roughness)
}

/// True if a time became faster or slower.
fn is_changed(total: &TimeComparison) -> bool {
    matches!(total.verdict, Some(Verdict::Faster | Verdict::Slower))
}

/// Returns a table of times that changed, with the ratio of the later time to the earlier and its interval.
fn change_cells(totals: &[&TimeComparison]) -> Vec<Vec<String>> {
    let figures = ["later over earlier", "low", "high", "verdict"];
    let mut cells = vec![[&SUBJECT_COLUMNS[..], &figures].concat().into_iter().map(str::to_owned).collect::<Vec<_>>()];
    for t in totals {
        let number = |v: Option<f64>| v.map_or_else(|| "-".to_owned(), |v| format!("{v:.3}"));
        let mut row = subject_labels(&t.subject).to_vec();
        row.extend([t.ratio, t.low, t.high].map(number));
        row.push(t.verdict.map_or("-", Verdict::name).to_owned());
        cells.push(row);
    }
    cells
}

/// Returns a figure as text with four significant digits, but at most six digits behind the point. A figure below 0.001
/// or of at least 10,000 is written with an exponent.
fn figure_text(value: f64) -> String {
    if value == 0.0 || (1e-3..1e4).contains(&value) {
        // Four digits, less those before the point.
        let digits = (3 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}
