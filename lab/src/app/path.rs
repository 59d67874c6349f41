//! `ssct path`: frames per second while the camera moves.

use super::cli::{CommonOptions, DeviceOptions, count_parser, parse_size};
use super::measure::StudyOptions;
use super::resolve;
use crate::error::{Error, Result};
use crate::study::path::PathStudy;
use clap::Args;
use std::path::PathBuf;

/// Options of `ssct path`.
#[derive(Debug, Args)]
pub struct PathOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// Methods, such as ssct,hzct; by default all of them
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub method: Vec<String>,
    /// Widths and heights in pixels; by default 960x540
    #[arg(long, value_name = "WxH", value_parser = parse_size, value_delimiter = ',')]
    pub size: Vec<[u32; 2]>,
    /// Path of the camera, by name or file
    ///
    /// `views` leads through the views of the scene; a name is that of a path of the scene file; a path file ends in .toml
    /// (docs/window.md).
    #[arg(long, value_name = "NAME|FILE", default_value = "views")]
    pub path: PathBuf,
    /// Frames from one end to the other
    #[arg(long, value_name = "N", default_value_t = 120, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub frames: u32,
    /// Frames that are drawn before the first that is timed.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = count_parser(0))]
    pub warmup: usize,
}

impl StudyOptions for PathOptions {
    type Study = PathStudy;

    fn device(&self) -> &DeviceOptions {
        &self.common.device
    }

    fn study(&self) -> Result<PathStudy> {
        let place = &self.common.place;
        if place.view.is_some() || place.eye.is_some() {
            return Err(Error::usage("a path says where the camera is; leave out --view and --eye".into()));
        }
        let mut scene = resolve::scene(place, "rooms")?;
        let path = resolve::path(&scene, &self.path, "--path")?;
        let sizes = resolve::distinct_values_or(&self.size, [960, 540]);
        let setup = self.common.method_options.setup(sizes[0]);
        scene.lens = resolve::lens(place, scene.lens)?;
        let methods = resolve::methods(&self.method, &setup, &[&scene], &[scene.lens])?;
        Ok(PathStudy {
            scene,
            path,
            methods,
            globals: resolve::one_globals(place, "a path is walked with one roughness")?,
            setup,
            sizes,
            warmup: self.warmup,
            frames: self.frames as usize,
        })
    }
}
