//! The command line as a whole: the list of commands. Only [`super::run`] reads this list, so that no command depends on another.

use super::captures::CapturesOptions;
use super::cli::{DevicesOptions, FiguresOptions, GBufferCommand, MergeOptions, RenderOptions, StudyOptions};
use super::compare::CompareOptions;
use super::drivers::DriversOptions;
use super::gpu_study::GpuStudyOptions;
use super::index::IndexOptions;
use super::studies::StudyCommand;
use super::truth::TruthOptions;
use super::view::ViewArguments;
use clap::{Parser, Subcommand};

/// Glossy reflections in screen space on Vulkan: published methods, timed per pass.
#[derive(Debug, Parser)]
#[command(name = "ssct", version, propagate_version = true)]
pub struct Cli {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands, in the order of the groups that `ssct --help` shows (`help`).
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render one image.
    Render(RenderOptions),
    /// Show, time and judge the built-in scenes, and write a page.
    Study(StudyOptions),
    /// Fly through a scene in a window.
    View(ViewArguments),
    /// A study.
    #[command(flatten)]
    Measure(StudyCommand),
    /// Measure all that a device does, in minutes.
    ///
    /// It measures times and their noise, work and rates, and compares the images with those of other devices.
    GpuStudy(GpuStudyOptions),
    /// Compare the times or shaders of two runs, or two images.
    Compare(CompareOptions),
    /// Put the shards of a study together.
    Merge(MergeOptions),
    /// Make one page over many runs.
    ///
    /// The page shows devices, commits and dates, with figures over runs.
    Index(IndexOptions),
    /// Make the figures of the theses, on a page.
    ///
    /// The page also says which figures cannot be made, and why.
    Figures(FiguresOptions),
    /// Say where captures of a scene stand, or place them.
    Captures(CapturesOptions),
    /// List what Vulkan offers here.
    Devices(DevicesOptions),
    /// Compare the images of every device here, on one G-buffer.
    Drivers(DriversOptions),
    /// Write a G-buffer to a file, or run a method on one.
    ///
    /// The G-buffer may come from any renderer.
    #[command(subcommand, name = "gbuffer")]
    GBuffer(GBufferCommand),
    /// Write the ground truth for another renderer to check.
    Truth(TruthOptions),
}
