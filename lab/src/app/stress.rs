//! `ssct stress`: numerical stability.

use super::cli::DeviceOptions;
use super::measure::StudyOptions;
use crate::error::Result;
use crate::methods::{self, METHODS};
use crate::study::stress::StressStudy;
use clap::Args;

/// Options of `ssct stress`.
#[derive(Debug, Args)]
pub struct StressOptions {
    /// Methods, such as ssct,hzct; by default all of them
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub method: Vec<String>,
    /// Only small images and one scene: a minute
    #[arg(long)]
    pub quick: bool,
    /// Only cases whose name contains these words
    #[arg(long, value_name = "WORDS")]
    pub case: Option<String>,
    /// Device.
    #[command(flatten)]
    pub device: DeviceOptions,
}

/// Runs every case, and fails if the judged method violates any.
impl StudyOptions for StressOptions {
    type Study = StressStudy;

    fn device(&self) -> &DeviceOptions {
        &self.device
    }

    fn study(&self) -> Result<StressStudy> {
        let methods = match &self.method[..] {
            [] => METHODS.iter().collect(),
            names => names.iter().map(|n| methods::find(n)).collect::<Result<_>>()?,
        };
        Ok(StressStudy::new(methods, self.quick, self.case.as_deref()))
    }
}
