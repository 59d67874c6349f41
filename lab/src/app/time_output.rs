//! Writes and prints the results of `ssct time` and of `ssct path`.

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

/// The folder that files are written into, if any, and whether the records are printed as JSON instead of the text.
pub type Destination<'a> = (Option<&'a Path>, bool);

impl TimeOutput {
    /// Ends a run, whether it was finished or interrupted: writes and prints what was measured, and only then returns
    /// the error that ended it.
    pub fn conclude(&self, to: Destination, run: Run, outcome: Result<()>, gpu: &Gpu) -> anyhow::Result<()> {
        let wrote = self.out(to);
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
    fn out(&self, (folder, as_json): Destination) -> anyhow::Result<()> {
        if let Some(folder) = folder {
            self.write(folder)?;
        }
        let shown = if as_json { &self.json } else { &self.text };
        std::io::stdout().lock().write_all(shown.as_bytes())?;
        Ok(())
    }
}

/// A line that names the device of some records.
pub fn device_line(device: &DeviceInfo) -> String {
    format!("{} ({}, {})\n", device.name, device.kind, device.driver)
}
