//! A library of results has many runs of the studies, of different dates, commits and devices. Runs of all versions of
//! the program are read ([`read`]), figures are followed over the runs ([`trends`]), and the times of each run are
//! compared with those of an earlier run ([`changes`]).

pub mod changes;
pub mod read;
pub mod trends;

use super::compare;
use ssct::gpu::DeviceInfo;

/// A folder with the records of a run.
#[derive(Debug, Clone)]
pub struct LibraryRun {
    /// The run's folder, relative to the library's folder, with slashes; "." for the library's folder itself.
    pub name: String,
    /// Day of the measurement, as YYYY-MM-DD.
    pub date: String,
    /// Origin of the date.
    pub dated_by: DatedBy,
    /// Files of records, with the kind and number of their records.
    pub files: Vec<RecordFile>,
    /// Whether the run has a page of its own, index.html.
    pub has_page: bool,
    /// Versions and commits of the programs that measured.
    pub programs: Vec<String>,
    /// Versions of docs/definitions.md that the figures follow.
    pub definitions: Vec<u32>,
    /// The devices that the records name.
    pub devices: Vec<DeviceInfo>,
    /// The figures of the records that can be followed over runs.
    pub measurements: Vec<Measurement>,
    /// Numbers of the stress study: cases that failed, and all cases.
    pub stress: Option<[usize; 2]>,
    /// The time of each frame, if raw samples lie beside the records.
    pub samples: Option<compare::Run>,
    /// Which parts of the run could not be read or do not fit, in sentences without a full stop.
    pub notes: Vec<String>,
}

/// The origin of a run's date; records hold no date.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DatedBy {
    /// The name of a folder on the run's path begins with the date.
    Folder,
    /// The date of the newest file, which a copy or a checkout changes.
    Files,
}

/// A file of records.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordFile {
    /// The file's name, relative to the run's folder.
    pub file: String,
    /// The kind of its first record.
    pub kind: String,
    /// Number of records.
    pub records: usize,
}

/// A figure that can be followed over runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Quantity {
    /// Median time of the effect, in milliseconds, of the time study.
    Time,
    /// Median time of the effect, in milliseconds, of the error study, which takes samples of its own.
    ErrorStudyTime,
    /// Share of the pixels whose mirror ray does not end where the oracle's does: 1 − hit agreement.
    WrongHits,
    /// RMSE against the screen reference.
    ScreenRmse,
    /// RMSE against the world reference.
    WorldRmse,
    /// Mean difference between the changes of the reflection and those of the screen reference under a moving camera,
    /// divided by the mean change of the reference.
    MotionDeviation,
}

impl Quantity {
    /// Every quantity, in the order in which pages show them.
    pub const ALL: [Self; 6] =
        [Self::Time, Self::ErrorStudyTime, Self::WrongHits, Self::ScreenRmse, Self::WorldRmse, Self::MotionDeviation];

    /// Whether the quantity is a time; times of different devices or runs are not compared.
    pub fn is_time(self) -> bool {
        matches!(self, Self::Time | Self::ErrorStudyTime)
    }

    /// Returns the quantity's title on a page.
    pub fn title(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::ErrorStudyTime => "time in the error study",
            Self::WrongHits => "share of wrong hits against the oracle",
            Self::ScreenRmse => "RMSE against the screen reference",
            Self::WorldRmse => "RMSE against the world reference",
            Self::MotionDeviation => "deviation of the change under a moving camera",
        }
    }
}

/// Scene, size and settings of a measurement, without the view.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Setting {
    /// Scene name.
    pub scene: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Global roughness as text; "own" if the materials keep their roughness.
    pub roughness: String,
    /// The version of the definitions, and the values of the lens, the reflectivity and the normal deviation, if the
    /// record has them: each as "name value".
    pub other_settings: Vec<String>,
}

/// One figure of one method, in one setting and view.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// Index of the device among the run's devices.
    pub device: usize,
    /// Scene, size and settings of the measurement.
    pub setting: Setting,
    /// The view, followed by the motion of the camera if it moves.
    pub view: String,
    /// The method, with the parameters that differ from its preset.
    pub method: String,
    /// Quantity that was measured.
    pub quantity: Quantity,
    /// Value of the figure, finite, ≥ 0.
    pub value: f64,
}

#[cfg(test)]
mod tests;
