//! `ssct age`: error over the age of captures, while things move.

use super::cli::{CommonOptions, DeviceOptions, parse_point, parse_size};
use super::measure::StudyOptions;
use super::resolve;
use crate::error::{Error, Result};
use crate::study::age::AgeStudy;
use crate::study::stress::JUDGED;
use clap::Args;
use glam::Vec3;
use ssct::methods;
use ssct_scenes::capture::MAX_CAPTURES;

/// Options of `ssct age`.
#[derive(Debug, Args)]
pub struct AgeOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// Methods that follow rays in captures
    ///
    /// Without it, the method unified is measured.
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

    fn study(&self) -> Result<AgeStudy> {
        let place = &self.common.place;
        let scene = resolve::scene(place, "museum")?;
        let view = resolve::view(&scene, place, None)?;
        let sizes = resolve::distinct_values_or(&self.size, [480, 270]);
        let setup = self.common.method_options.setup(sizes[0]);
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
