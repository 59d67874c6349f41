//! `ssct age`: error over the age of captures, while things move.

use super::cli::{CommonOptions, DeviceOptions, parse_point, parse_size};
use super::measure::StudyOptions;
use super::resolve;
use crate::error::{Error, Result};
use crate::study::age::AgeStudy;
use crate::study::stress::JUDGED;
use clap::Args;
use glam::Vec3;
use ssct::methods::setup::CaptureCount;
use ssct::methods::{self, EffectParams, Setup};
use ssct_scenes::capture::MAX_CAPTURES;

/// Options of `ssct age`.
#[derive(Debug, Args)]
pub struct AgeOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// Methods that follow rays in captures
    ///
    /// Without it, the method unified is measured. Unless --captures, --beyond or --fallback is given, it has as many captures
    /// as --captures auto.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub method: Vec<String>,
    /// Widths and heights in pixels; by default 480x270
    #[arg(long, value_name = "WxH", value_parser = parse_size, value_delimiter = ',')]
    pub size: Vec<[u32; 2]>,
    /// Frames of the measurement
    ///
    /// Each of them is held against the world as it then is.
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: u32,
    /// Meshes that move, by name
    #[arg(long, value_name = "MESH", value_delimiter = ',', required = true)]
    pub moving: Vec<String>,
    /// How far they move from frame to frame, in metres
    ///
    /// The three numbers are along the axes of the world.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    pub step: Vec3,
    /// Faces renewed in each frame
    ///
    /// Each of these numbers of faces of captures is measured.
    #[arg(
        long,
        value_name = "N",
        value_delimiter = ',',
        default_values_t = [0, 1, 2, 6, 24],
        value_parser = clap::value_parser!(u32).range(0..=6 * MAX_CAPTURES as i64)
    )]
    pub faces: Vec<u32>,
    /// Rays a pixel of the references
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=1_048_576))]
    pub rays: u32,
}

impl StudyOptions for AgeOptions {
    type Study = AgeStudy;

    fn device(&self) -> &DeviceOptions {
        &self.common.device
    }

    /// Makes the study. `--captures-per-frame` is refused, since `--faces` lists the numbers that are compared.
    fn study(&self) -> Result<AgeStudy> {
        let place = &self.common.place;
        let scene = resolve::scene(place, "museum")?;
        let view = resolve::view(&scene, place, None)?;
        let sizes = resolve::distinct_values_or(&self.size, [480, 270]);
        let setup = with_captures(self.common.method_options.setup(sizes[0]));
        let names = if self.method.is_empty() { vec![JUDGED.to_owned()] } else { self.method.clone() };
        let methods = resolve::leave_out_lacking(methods::choose(&names, &setup)?, |method| method, &[&scene])?;
        if setup.values.given_names().any(|name| name == "captures_per_frame") {
            let message = "age compares several numbers of faces a frame: give --faces instead of --captures-per-frame";
            return Err(Error::usage(message.into()));
        }
        resolve::check_meshes(&scene, "--moving", &self.moving)?;
        let study = AgeStudy {
            scene,
            view,
            methods,
            setup,
            sizes,
            globals: resolve::globals(place)?,
            moving: resolve::distinct_values(&self.moving),
            step_m: self.step,
            faces: resolve::distinct_values(&self.faces),
            frames: self.frames,
            rays: self.rays,
        };
        study.check()?;
        Ok(study)
    }
}

/// Returns the setup with as many captures as the scene needs, unless options say where rays go on that the screen
/// loses: without captures there is no age to measure.
fn with_captures(setup: Setup) -> Setup {
    let is_given = setup.values.given_names().any(|name| ["captures", "beyond", "fallback"].contains(&name));
    if is_given { setup } else { setup.with(|effect: &mut EffectParams| effect.captures = CaptureCount::Auto) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    /// The command line of one `ssct age`, without the options that every study has.
    #[derive(Parser)]
    struct Age {
        #[command(flatten)]
        options: AgeOptions,
    }

    #[test]
    fn without_a_number_of_captures_the_study_has_as_many_as_the_scene_needs() {
        let study = |more_flags: &[&str]| {
            let flags = ["age", "--scene", "rooms", "--moving", "ball", "--step", "0.1,0,0"];
            Age::try_parse_from(flags.into_iter().chain(more_flags.iter().copied())).expect("flags").options.study()
        };
        let captures = |more_flags: &[&str]| study(more_flags).expect("a study").setup.effect().captures;
        assert_eq!(captures(&[]), CaptureCount::Auto);
        assert_eq!(captures(&["--captures", "2"]), CaptureCount::Number(2));
        assert_eq!(captures(&["--fallback", "captures", "--method", "ssct"]), CaptureCount::None);
        assert!(study(&["--captures", "none"]).is_err());
    }
}
