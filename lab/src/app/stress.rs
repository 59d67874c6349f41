//! `ssct stress`: numerical stability.

use super::cli::{DeviceOptions, RunOptions};
use super::measure::{self, StudyOptions};
use super::merger::Merger;
use crate::error::Result;
use crate::study::complaints::{self, ComplaintStudy};
use crate::study::exhibit::distinct;
use crate::study::stress::StressStudy;
use clap::Args;
use ssct::methods::{self, METHODS};

/// Options of `ssct stress`.
#[derive(Debug, Args)]
pub struct StressOptions {
    /// Methods, such as ssct,hzct; by default all of them
    ///
    /// With --complaints, the default is ssct,dda,stochastic,unified.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub method: Vec<String>,
    /// Only small images and one scene: a minute
    #[arg(long)]
    pub quick: bool,
    /// Try what engines' users complain of, with pictures
    ///
    /// A small scene for each complaint shows the truth beside each method, with one number that says how much of what is
    /// complained of there is. With --quick, pictures are half as wide. Methods that go on among the scene's triangles are tried
    /// on the screen alone as well.
    #[arg(long)]
    pub complaints: bool,
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
            names => distinct(names.iter()).into_iter().map(|n| methods::find(n)).collect::<ssct::Result<_>>()?,
        };
        StressStudy::new(methods, self.quick, self.case.as_deref())
    }

    fn run(&self, run_options: &RunOptions) -> anyhow::Result<()> {
        if self.complaints { measure::run(&Complaints(self), run_options) } else { measure::run(self, run_options) }
    }

    fn mergers() -> Vec<Merger> {
        vec![Merger::for_study::<StressStudy>(), Merger::for_study::<ComplaintStudy>()]
    }
}

/// The flags of `ssct stress --complaints`.
struct Complaints<'a>(&'a StressOptions);

impl StudyOptions for Complaints<'_> {
    type Study = ComplaintStudy;

    fn device(&self) -> &DeviceOptions {
        &self.0.device
    }

    fn study(&self) -> Result<ComplaintStudy> {
        let named = self.0.method.iter().map(String::as_str);
        let names: Vec<&str> = if self.0.method.is_empty() { complaints::METHODS.to_vec() } else { named.collect() };
        let methods = distinct(names.into_iter()).into_iter().map(methods::find).collect::<ssct::Result<Vec<_>>>()?;
        ComplaintStudy::new(&methods, self.0.quick, self.0.case.as_deref())
    }
}
