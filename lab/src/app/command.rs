//! The command line as a whole: the list of commands. Only [`super::run`] reads it, so that no command depends on the
//! others.

use super::captures::CapturesOptions;
use super::cli::{
    DevicesOptions, FiguresOptions, GBufferCommand, MergeOptions, MotionOptions, RenderOptions, StressOptions,
    StudyOptions, TimeOptions,
};
use super::compare::CompareOptions;
use super::drivers::DriversOptions;
use super::error_options::ErrorOptions;
use super::gpu_study::GpuStudyOptions;
use super::index::IndexOptions;
use super::truth::TruthOptions;
use super::view::ViewOptions;
use clap::{Parser, Subcommand};

/// Glossy reflections in screen space on Vulkan: published methods, timed per pass.
#[derive(Debug, Parser)]
#[command(name = "ssct", version, about, propagate_version = true)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// List what Vulkan offers here.
    Devices(DevicesOptions),
    /// Hold what every device here makes of one G-buffer against what one of them makes of it.
    Drivers(DriversOptions),
    /// Render one image.
    Render(RenderOptions),
    /// Time every pass on the GPU.
    Time(TimeOptions),
    /// Measure run time against error.
    Error(ErrorOptions),
    /// Try every method on G-buffers and cameras that break renderers.
    Stress(StressOptions),
    /// Measure how much reflections change while the camera moves.
    Motion(MotionOptions),
    /// Write a G-buffer to a file, or run a method on one from any renderer.
    #[command(subcommand, name = "gbuffer")]
    GBuffer(GBufferCommand),
    /// Render and time the built-in scenes, and write a page that shows it all.
    Study(StudyOptions),
    /// Measure all that a device does in minutes: times and their noise, work, rates, and images against other devices'.
    GpuStudy(GpuStudyOptions),
    /// Make the figures of the theses, say what those lack that cannot be made, and show them on a page.
    Figures(FiguresOptions),
    /// Say where captures of a scene stand, or place them.
    Captures(CapturesOptions),
    /// Fly through a scene in a window.
    View(ViewOptions),
    /// Write the ground truth for another renderer to check.
    Truth(TruthOptions),
    /// Compare the times of two runs, or two images.
    Compare(CompareOptions),
    /// Make one page over many runs: devices, commits and dates, with figures over runs.
    Index(IndexOptions),
    /// Put the shards of a study together.
    Merge(MergeOptions),
}
