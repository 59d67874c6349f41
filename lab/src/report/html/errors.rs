//! The page of the error study: run time against error for each device, and the parts of the error over all devices.

use super::sections::{error_plots, error_sources};
use super::{frame, heading, missing_cells, page_header};
use crate::report::devices::device_name;
use crate::report::error_report::{DevicePart, IMAGES};
use maud::html;

/// Everything that the page shows.
pub struct ErrorPage<'a> {
    /// The version of the definitions.
    pub definitions: u32,
    /// The command that made it.
    pub command: &'a str,
    /// What was measured, device by device.
    pub devices: &'a [DevicePart],
    /// What the error consists of, as rows.
    pub sources: &'a [Vec<String>],
    /// The cells that the study has and the page lacks.
    pub missing: &'a [String],
}

impl ErrorPage<'_> {
    /// The whole page.
    pub fn render(&self) -> String {
        let alone = (self.devices.len() == 1).then(|| &self.devices[0].device);
        let title = |part: &DevicePart| match alone {
            Some(_) => "Run time against error".to_owned(),
            None => format!("Run time against error on {}", device_name(&part.device)),
        };
        let titles: Vec<String> = self.devices.iter().map(title).collect();
        let mut parts: Vec<_> =
            titles.iter().enumerate().map(|(n, t)| (format!("device-{}", n + 1), t.as_str())).collect();
        parts.push(("sources".to_owned(), "Where the error comes from"));
        parts.push(("records".to_owned(), "Raw records"));
        let body = html! {
            (missing_cells(self.missing))
            @if alone.is_none() {
                p { "Times of different devices are not compared: each device has its own plots and tables, over \
                     the cells that it measured." }
            }
            @for ((id, title), part) in parts.iter().zip(self.devices) {
                (heading((id, title)))
                p { (cells(part.cells)) ". The error is the mean over the cells, the time the median. No other point is \
                     better in both than a point on the front (marked by *, and red in the plots)." }
                (error_plots(&part.plots))
            }
            (heading(("sources", "Where the error comes from")))
            (error_sources(self.sources))
            (heading(("records", "Raw records")))
            ul {
                li { a href="error.json" { "error.json" } ": every error, one record a method, cell and reference" }
                li { a href="error.txt" { "error.txt" } ": the tables of this page" }
                li { a href=(IMAGES) { (IMAGES) } ": reflections and FLIP maps as PNG, error maps as EXR" }
            }
        };
        let title = "Run time against error";
        frame(title, &page_header(title, alone, self.definitions, self.command, &parts), &body)
    }
}

/// A number of cells in words.
fn cells(count: usize) -> String {
    if count == 1 { "One cell".to_owned() } else { format!("{count} cells") }
}
