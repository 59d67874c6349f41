//! `ssct motion`: how much reflections change while the camera moves, compared with how much they should change.

use super::cli::{CommonOptions, DeviceOptions, parse_size};
use super::measure::StudyOptions;
use super::resolve;
use crate::error::{Error, Result};
use crate::study::stress::motion::MotionStudy;
use clap::Args;

/// Roughness values where none are given.
const ROUGHNESS: [f32; 3] = [0.05, 0.1, 0.4];

/// Options of `ssct motion`.
#[derive(Debug, Args)]
pub struct MotionOptions {
    /// Scene, methods and device.
    #[command(flatten)]
    pub common: CommonOptions,
    /// Methods, such as ssct,hzct; by default all of them
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub method: Vec<String>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "320x180")]
    pub size: [u32; 2],
    /// Frames of each motion of the camera
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(2..=10_000))]
    pub frames: u32,
    /// Rays a pixel of the references
    ///
    /// The screen reference and the world reference trace as many.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=65536))]
    pub rays: u32,
}

impl StudyOptions for MotionOptions {
    type Study = MotionStudy;

    fn device(&self) -> &DeviceOptions {
        &self.common.device
    }

    /// Makes the study, on all views of the scene if the options name none.
    fn study(&self) -> Result<MotionStudy> {
        let place = &self.common.place;
        if place.reflectivity != 1.0 || place.normal_deviation.is_some() {
            let message = "motion is measured with the reflectivity and the normals of the materials";
            return Err(Error::usage(message.into()));
        }
        let scene = resolve::scene(place, "rooms")?;
        let views = match (&place.view, place.eye) {
            (None, None) => scene.views.iter().map(|view| resolve::with_lens(&scene, view.clone(), place)).collect(),
            _ => resolve::view(&scene, place, None).map(|view| vec![view]),
        }?;
        let globals = resolve::globals_or(place, &ROUGHNESS)?;
        let roughness = globals.iter().filter_map(|globals| globals.roughness).collect();
        let setup = self.common.method_options.setup(self.size);
        let methods = resolve::methods(&self.method, &setup, &[&scene], &resolve::lenses(&scene, &views))?;
        let (frames, rays) = (self.frames, self.rays);
        Ok(MotionStudy { scene, views, methods, setup, roughness, frames, rays, lineup: None })
    }
}
