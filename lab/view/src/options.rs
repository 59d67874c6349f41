//! The command line of the window.

use crate::presentation::PresentMode;
use crate::state::{InnerImage, Tab};
use clap::{Command, Parser, ValueEnum};
use ssct_lab::app::cli::{CommonOptions, parse_size};
use ssct_lab::app::headings::{METHOD, OUTPUT, WINDOW};
use ssct_lab::app::help;
use ssct_lab::app::parameters::choice_parser;
use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

/// Fly through a scene in a window, look into methods, and tune their parameters.
#[derive(Debug, Parser)]
#[command(
    name = "ssct-view",
    version,
    after_help = "\
Keys, by their place on a US keyboard:
  W A S D, Q E   fly forward, left, back, right, down, up; with Shift fast
  mouse          look around while a button is held; the wheel changes the speed;
                 a click picks a ray while the part `ray` of the panel is open;
                 the line between two methods can be drawn
  1 ... 9        the scene's named views
  M              the next method
  C              one method, two side by side, their difference
  R, Shift+R     rougher, smoother
  K, P           record a key frame of the camera, play the key frames
  N, B, Delete   put a new capture at the eye, move the selected one, remove it
  F1, F2         show or hide the panel, open its next part
  Esc            quit"
)]
pub struct ViewOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// Method to begin with
    #[arg(long, value_name = "NAME", default_value = "ssct")]
    pub method: String,
    /// Second method to compare with
    #[arg(long, help_heading = METHOD, value_name = "NAME")]
    pub against: Option<String>,
    /// How two methods are shown
    #[arg(long, help_heading = METHOD, value_name = "HOW", value_enum, default_value_t, requires = "against")]
    pub compare: TwoMethods,
    /// Width and height of the picture
    ///
    /// The panel stands beside the picture.
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "960x540")]
    pub size: [u32; 2],
    /// Part of the panel that is open.
    #[arg(long, help_heading = WINDOW, value_name = "PART", value_enum, default_value_t)]
    pub panel: Tab,
    /// Show an intermediate, a capture (`capture-1-color`, `-depth`, `-normal`), or the heat map `steps`, instead of the
    /// finished image.
    #[arg(long, help_heading = WINDOW, value_name = "NAME[/LEVEL]", value_parser = inside)]
    pub inside: Option<InnerImage>,
    /// Pixel whose ray is drawn, for `--panel ray`.
    #[arg(long, help_heading = WINDOW, value_name = "X,Y", value_parser = pixel)]
    pub pick: Option<[u32; 2]>,
    /// File with key frames of the camera
    ///
    /// `ssct path` measures along the same file. With --frames, the frames follow the key frames.
    #[arg(long, value_name = "FILE")]
    pub path: Option<PathBuf>,
    /// Folder of shaders to watch; by default ./shaders-glsl if it exists.
    #[arg(long, help_heading = WINDOW, value_name = "DIR")]
    pub shaders: Option<PathBuf>,
    /// How images replace one another on the screen.
    #[arg(
        long,
        help_heading = WINDOW,
        value_name = "MODE",
        value_parser = choice_parser::<PresentMode>(),
        default_value = "fifo"
    )]
    pub present_mode: PresentMode,
    /// Show so many frames, take no input, and quit
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: Option<u32>,
    /// File for what the last frame shows
    ///
    /// A .png shows the window, an .exr the picture alone, linear.
    #[arg(long, help_heading = OUTPUT, value_name = "FILE", requires = "frames")]
    pub screenshot: Option<PathBuf>,
    /// File for the frames, as an animated .gif.
    #[arg(long, help_heading = OUTPUT, value_name = "FILE", requires = "frames")]
    pub animation: Option<PathBuf>,
    /// Time to stay open after the frames and take input.
    #[arg(long, help_heading = WINDOW, value_name = "SECONDS", requires = "frames", value_parser = seconds)]
    pub stay: Option<Duration>,
    /// Print what was shown and submitted, as JSON
    #[arg(long, requires = "frames")]
    pub json: bool,
}

/// How two methods are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum TwoMethods {
    /// Side by side, with a line that can be moved.
    #[default]
    Split,
    /// The magnitude of their difference.
    Difference,
}

/// Returns the command line, arranged for the kind of help that the arguments ask for.
pub fn command(arguments: &[OsString]) -> Command {
    help::single_command::<ViewOptions>(arguments)
}

/// Parses `--inside`, as in `hi-z/3`.
fn inside(text: &str) -> std::result::Result<InnerImage, String> {
    let (name, level) = text.split_once('/').unwrap_or((text, "0"));
    let level = level.parse().map_err(|_| format!("{text:?}: the slash must be followed by a level, as in hi-z/3"))?;
    Ok(InnerImage { name: name.to_owned(), level })
}

/// Parses a pixel, as in `120,80`.
fn pixel(text: &str) -> std::result::Result<[u32; 2], String> {
    let wrong = || format!("{text:?} is not a pixel; write it as 120,80");
    let (x, y) = text.split_once(',').ok_or_else(wrong)?;
    Ok([x.trim().parse().map_err(|_| wrong())?, y.trim().parse().map_err(|_| wrong())?])
}

/// Parses a time in seconds, as in `2.5`.
fn seconds(text: &str) -> std::result::Result<Duration, String> {
    let value: f64 = text.parse().map_err(|_| format!("{text:?} is not a number"))?;
    Duration::try_from_secs_f64(value).map_err(|_| format!("{text} seconds cannot be waited for"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_help_has_every_option_and_fits_a_terminal() {
        let arguments = |flag: &str| ["ssct-view".into(), flag.into()];
        let mut summary = command(&arguments("-h")).term_width(80);
        let text = summary.render_help().to_string();
        assert!(text.lines().count() <= 45 && text.lines().all(|l| l.chars().count() <= 80), "{text}");
        assert!(text.contains("ssct-view --help") && text.contains("--scene") && !text.contains("--panel"), "{text}");
        let mut whole = command(&arguments("--help"));
        let text = whole.render_long_help().to_string();
        let (window, output) = (text.find("\nWindow:\n").unwrap(), text.find("\nOutput:\n").unwrap());
        let panel = text.find("--panel").unwrap();
        assert!(window < panel && panel < output && text.contains("a click picks a ray"), "{text}");
        for argument in whole.get_arguments() {
            assert!(argument.get_help_heading().is_some(), "{argument} has no heading");
        }
    }
}
