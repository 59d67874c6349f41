//! A library of results: many runs of the studies, of different dates, commits and devices, beside each other. Read
//! from records as plain JSON ([`read`]), since older ones lack what newer ones say; followed over runs ([`trends`]);
//! and compared with the run before ([`changes`]).

pub mod changes;
pub mod read;
pub mod trends;

use super::compare;
use crate::gpu::DeviceInfo;

/// A folder with the records of a run.
#[derive(Debug, Clone)]
pub struct LibraryRun {
    /// Its folder, relative to the library's, with slashes; "." for the library's own.
    pub name: String,
    /// When it was measured, as YYYY-MM-DD.
    pub date: String,
    /// What says so.
    pub dated_by: DatedBy,
    /// Record files, relative to the folder, with the kind and number of their records.
    pub files: Vec<RecordFile>,
    /// Whether it has a page of its own, index.html.
    pub has_page: bool,
    /// Versions and commits of the programs that measured.
    pub programs: Vec<String>,
    /// Versions of the definitions that its figures are of.
    pub definitions: Vec<u32>,
    /// The devices of its records.
    pub devices: Vec<DeviceInfo>,
    /// What its records say.
    pub measurements: Vec<Measurement>,
    /// Cases of the stress study that failed, and all of them.
    pub stress: Option<[usize; 2]>,
    /// The totals of its frames, if raw samples lie beside the records.
    pub samples: Option<compare::Run>,
    /// What is wrong with a part of it, as sentences.
    pub notes: Vec<String>,
}

impl LibraryRun {
    /// Order of the library: by date, and on one day by name.
    pub fn order(&self) -> (&str, &str) {
        (&self.date, &self.name)
    }
}

/// What says when a run was measured; a record does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DatedBy {
    /// A folder on its path is named by the date.
    Folder,
    /// The files' own times, which a copy or a checkout changes.
    Files,
}

/// A file of records.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordFile {
    /// Relative to the run's folder.
    pub file: String,
    /// The kind of its first record.
    pub kind: String,
    /// How many it has.
    pub records: usize,
}

/// What was measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Quantity {
    /// Median time of the effect, in milliseconds, of the time study.
    Time,
    /// The same of the error study, which has samples of its own.
    ErrorStudyTime,
    /// Share of the mirror rays that end elsewhere than the oracle's.
    WrongHits,
    /// RMSE against the screen reference.
    ScreenRmse,
    /// RMSE against the world reference.
    WorldRmse,
    /// Change under a moving camera: deviation from the screen reference's, over the reference's own change.
    MotionDeviation,
}

impl Quantity {
    /// All, in the order in which pages show them.
    pub const ALL: [Self; 6] =
        [Self::Time, Self::ErrorStudyTime, Self::WrongHits, Self::ScreenRmse, Self::WorldRmse, Self::MotionDeviation];

    /// Whether it is a time, which says nothing on another device or beside another run's.
    pub fn is_time(self) -> bool {
        matches!(self, Self::Time | Self::ErrorStudyTime)
    }

    /// What a page calls it; a time is given over that of a method of the same run.
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

/// Where a measurement was taken, apart from the view.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Setting {
    /// Scene name.
    pub scene: String,
    /// Pixels.
    pub size: [u32; 2],
    /// Global roughness as text; "own" where the materials keep theirs.
    pub roughness: String,
    /// Version of the definitions, and whatever of lens, reflectivity and normal deviation the record says, as
    /// "name value".
    pub rest: Vec<String>,
}

/// One figure of one method in one place.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// Index of the device among the run's.
    pub device: usize,
    /// Where.
    pub setting: Setting,
    /// View, and how the camera moves if it does.
    pub view: String,
    /// The method and the parameters that are not its preset's.
    pub method: String,
    /// What.
    pub quantity: Quantity,
    /// Finite, ≥ 0.
    pub value: f64,
}

#[cfg(test)]
mod tests;
