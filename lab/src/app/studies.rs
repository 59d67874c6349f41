//! The table of studies: a row for each, from which its command and its part of `ssct merge` follow.

use super::merger::Merger;
use super::{age, error, measure, motion, path, precision, shaders, stress, time, video};
use clap::Subcommand;

/// Makes commands and mergers from rows; a row has a name, its options and the first lines of its help.
macro_rules! studies {
    ($( $(#[$about:meta])* $Name:ident($Options:ty) ),* $(,)?) => {
        /// The commands that measure a study.
        #[derive(Debug, Subcommand)]
        pub enum StudyCommand {
            $( $(#[$about])* $Name(measure::Measured<$Options>), )*
        }

        impl StudyCommand {
            /// Runs the study.
            pub fn run(&self) -> anyhow::Result<()> {
                match self {
                    $( Self::$Name(flags) => measure::StudyOptions::run(&flags.options, &flags.run), )*
                }
            }
        }

        /// The mergers for the shards of each study.
        pub fn mergers() -> Vec<Merger> {
            [$( <$Options as measure::StudyOptions>::mergers() ),*].into_iter().flatten().collect()
        }

        /// The columns of the rows of all studies: the name of each, and its meaning in words.
        #[cfg(test)]
        fn meanings() -> Vec<(String, &'static str)> {
            [$( tests::meanings_of::<<$Options as measure::StudyOptions>::Study>() ),*].concat()
        }
    };
}

studies! {
    /// Time every pass on the GPU.
    Time(time::TimeOptions),
    /// Measure run time against error.
    Error(error::ErrorOptions),
    /// Measure error against the bytes of a G-buffer's pixel.
    ///
    /// Depth, normals and colour are stored in one format after another.
    Precision(precision::PrecisionOptions),
    /// Measure error over the age of captures, while meshes move.
    ///
    /// The meshes move a step in each frame, captures are renewed by so many faces a frame, and each frame is held against
    /// the world as it then is.
    Age(age::AgeOptions),
    /// Film methods beside the truth, along a way of the camera.
    ///
    /// Every variant is judged on every frame, beside what the world shows in that frame.
    Video(video::VideoOptions),
    /// Measure how much reflections change while the camera moves.
    Motion(motion::MotionOptions),
    /// Try methods on G-buffers and cameras that break renderers.
    Stress(stress::StressOptions),
    /// Measure frames per second along a path of the camera.
    Path(path::PathOptions),
    /// Show what the device's compiler made of each program.
    ///
    /// It compiles the programs that methods run and asks the driver for registers, instructions and occupancy. Nothing is
    /// drawn, so that a driver without its hardware is enough.
    Shaders(shaders::ShadersOptions),
}

#[cfg(test)]
mod tests {
    use super::meanings;
    use crate::study::columns::Columns;
    use crate::study::complaints::ComplaintStudy;
    use crate::study::engine::Study;

    /// Returns the names and meanings of the columns of a study's rows; a column without a name has its header.
    pub(super) fn meanings_of<S: Study>() -> Vec<(String, &'static str)> {
        let columns = <S::Row as Columns>::columns().columns.into_iter();
        columns.map(|c| (if c.name.is_empty() { c.title } else { c.name }, c.about)).collect()
    }

    #[test]
    fn the_meaning_of_a_column_is_in_words_and_names_nothing_of_the_source() {
        let columns = [meanings(), meanings_of::<ComplaintStudy>()].concat();
        assert!(columns.iter().filter(|(_, about)| !about.is_empty()).count() > 30, "{columns:?}");
        for (column, about) in columns {
            assert!(!about.contains("[`") && !about.contains("::"), "{column}: {about}");
        }
    }
}
