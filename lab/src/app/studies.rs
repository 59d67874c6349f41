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
