//! `ssct precision`: error against the bytes of a G-buffer's pixel.

use super::cli::{CommonOptions, DeviceOptions, parse_size};
use super::error::{QUICK_SIZE, QUICK_VIEWS};
use super::measure::StudyOptions;
use super::resolve;
use crate::error::{Error, Result};
use crate::study::precision::PrecisionStudy;
use crate::study::stress;
use clap::Args;
use ssct::methods;

/// Roughness values where none are given.
const ROUGHNESS: [f32; 2] = [0.0, 0.1];

/// The method that is measured by default beside [`stress::JUDGED`].
const BESIDE: &str = "ssct";

/// The screen-space method that works with one format of the G-buffer alone, since it copies the G-buffer's bits.
const FORMAT_DEPENDENT_METHOD: &str = "poster";

/// Options of `ssct precision`.
#[derive(Debug, Args)]
pub struct PrecisionOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// Methods, such as ssct,hzct; by default unified,ssct
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub method: Vec<String>,
    /// Width and height in pixels; by default 480x270
    ///
    /// With --quick, the default is 320x180.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// Two views, small images
    #[arg(long)]
    pub quick: bool,
    /// Rays a pixel of the reference
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=1_048_576))]
    pub rays: u32,
}

impl StudyOptions for PrecisionOptions {
    type Study = PrecisionStudy;

    fn device(&self) -> &DeviceOptions {
        &self.common.device
    }

    /// Makes the study. A method that does not sample a G-buffer of any format is refused.
    fn study(&self) -> Result<PrecisionStudy> {
        let place = &self.common.place;
        let scene = resolve::scene(place, "rooms")?;
        let views = match (&place.view, place.eye) {
            (None, None) => {
                let count = if self.quick { QUICK_VIEWS } else { usize::MAX };
                let views = scene.views.iter().take(count);
                views.map(|view| resolve::with_lens(&scene, view.clone(), place)).collect::<Result<Vec<_>>>()?
            }
            _ => vec![resolve::view(&scene, place, None)?],
        };
        let globals = resolve::globals_or(place, &ROUGHNESS)?;
        let size = self.size.unwrap_or(if self.quick { QUICK_SIZE } else { [480, 270] });
        let methods = match &self.method[..] {
            [] => {
                let names = [stress::JUDGED, BESIDE];
                let defaults = names.iter().map(|name| methods::find(name)).collect::<ssct::Result<Vec<_>>>()?;
                resolve::methods_taking_lenses(defaults, &resolve::lenses(&scene, &views))
            }
            names => {
                resolve::distinct_values(names).iter().map(|n| methods::find(n)).collect::<ssct::Result<Vec<_>>>()?
            }
        };
        if let Some(method) = methods.iter().find(|m| !m.is_screen_space() || m.name == FORMAT_DEPENDENT_METHOD) {
            let message =
                format!("precision is for methods that sample a G-buffer of any format; {} does not", method.name);
            return Err(Error::usage(message));
        }
        let setup = self.common.method_options.setup(size);
        methods::check_read(&methods, &setup)?;
        Ok(PrecisionStudy { scene, views, globals, methods, setup, rays: self.rays })
    }
}
