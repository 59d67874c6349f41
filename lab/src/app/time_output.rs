//! Writes and prints the results of `ssct time`, for each of its kinds of measurement.

use super::cli::TimeOptions;
use super::run::Run;
use crate::error::Result;
use crate::gpu::{DeviceInfo, Gpu};
use crate::report::files;
use std::io::Write;
use std::path::Path;

/// The results of a measurement as files and text.
pub struct TimeOutput {
    /// The stem of the file names.
    pub stem: &'static str,
    /// The records.
    pub json: String,
    /// Every sample: the file name and the CSV text.
    pub samples: (&'static str, String),
    /// The plot, as SVG.
    pub plot: String,
    /// The text for a terminal.
    pub text: String,
}

impl TimeOutput {
    /// Ends a run, whether it was finished or interrupted: writes and prints what was measured, and only then returns
    /// the error that ended it.
    pub fn conclude(&self, options: &TimeOptions, run: Run, outcome: Result<()>, gpu: &Gpu) -> anyhow::Result<()> {
        let wrote = self.out(options);
        run.ended(outcome)?;
        wrote?;
        run.finish()?;
        Ok(gpu.check_validation()?)
    }

    /// Writes the files into a folder.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let named = |extension: &str| folder.join(format!("{}.{extension}", self.stem));
        files::write(&named("json"), self.json.as_bytes())?;
        files::write(&folder.join(self.samples.0), self.samples.1.as_bytes())?;
        files::write(&named("svg"), self.plot.as_bytes())?;
        files::write(&named("txt"), self.text.as_bytes())
    }

    /// Writes the files, if a folder is asked for, and prints the records or the text.
    fn out(&self, options: &TimeOptions) -> anyhow::Result<()> {
        if let Some(folder) = &options.output {
            self.write(folder)?;
        }
        let shown = if options.run.json { &self.json } else { &self.text };
        std::io::stdout().lock().write_all(shown.as_bytes())?;
        Ok(())
    }
}

/// A line that names the device of some records.
pub fn device_line(device: &DeviceInfo) -> String {
    format!("{} ({}, {})\n", device.name, device.kind, device.driver)
}
