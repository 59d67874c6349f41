//! `ssct error`: run time against error.

use super::cli::{CommonOptions, DeviceOptions, count_parser, parse_size};
use super::measure::StudyOptions;
use super::resolve;
use super::variants::VariantOptions;
use crate::error::{Error, Result};
use crate::study::error::ErrorStudy;
use crate::study::sweep;
use clap::Args;
use ssct_scenes::{Scene, View, library};

/// Width and height in pixels of a quick study.
pub const QUICK_SIZE: [u32; 2] = [320, 180];
/// Number of views of a quick study.
pub const QUICK_VIEWS: usize = 2;
/// Roughness values of a quick study.
pub const QUICK_ROUGHNESS: [f32; 2] = [0.0, 0.1];

/// Options of `ssct error`.
#[derive(Debug, Args)]
pub struct ErrorOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    #[command(flatten)]
    pub variants: VariantOptions,
    /// Widths and heights in pixels; by default 480x270
    ///
    /// With --quick, the default is 320x180.
    #[arg(long, value_name = "WxH", value_parser = parse_size, value_delimiter = ',')]
    pub size: Vec<[u32; 2]>,
    /// Two views, two roughness values, no sweep
    #[arg(long, conflicts_with_all = ["captures_sweep", "fallback_sweep", "bounces_sweep"])]
    pub quick: bool,
    /// Compare methods only as the options set them up
    ///
    /// Without it, both presets and the values of their parameters are compared.
    #[arg(long, conflicts_with_all = ["variant", "captures_sweep", "fallback_sweep", "bounces_sweep"])]
    pub no_sweep: bool,
    /// Frames that are timed for each variant
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = count_parser(0))]
    pub samples: usize,
    /// Rays a pixel of the references
    ///
    /// The screen reference and the world reference trace as many.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(0..=1_048_576))]
    pub rays: u32,
}

impl StudyOptions for ErrorOptions {
    type Study = ErrorStudy;

    fn device(&self) -> &DeviceOptions {
        &self.common.device
    }

    /// Makes the study. Without `--scene`, it has all built-in scenes, or the rooms alone with `--quick`.
    fn study(&self) -> Result<ErrorStudy> {
        if self.samples == 0 || self.rays < 2 {
            return Err(Error::usage("--samples must be at least 1, and --rays at least 2".into()));
        }
        let place = &self.common.place;
        let scenes = match (&place.scene[..], self.quick) {
            ([], false) => {
                library::names().iter().map(|name| resolve::scene(place, name)).collect::<Result<Vec<_>>>()?
            }
            _ => vec![resolve::scene(place, "rooms")?],
        };
        let roughness: &[f32] = if self.quick { &QUICK_ROUGHNESS } else { &sweep::ROUGHNESS };
        let globals = resolve::globals_or(place, roughness)?;
        let sizes = resolve::distinct_values_or(&self.size, if self.quick { QUICK_SIZE } else { [480, 270] });
        let base = self.common.method_options.setup(sizes[0]);
        let views = |scene: &Scene| -> Result<Vec<View>> {
            if place.view.is_some() || place.eye.is_some() {
                return Ok(vec![resolve::view(scene, place, None)?]);
            }
            let count = if self.quick { QUICK_VIEWS } else { usize::MAX };
            scene.views.iter().take(count).map(|view| resolve::with_lens(scene, view.clone(), place)).collect()
        };
        let with_views = |scene| views(&scene).map(|views| (scene, views));
        let scenes = scenes.into_iter().map(with_views).collect::<Result<Vec<_>>>()?;
        let lenses: Vec<_> = scenes.iter().flat_map(|(scene, views)| resolve::lenses(scene, views)).collect();
        let studied: Vec<&Scene> = scenes.iter().map(|(scene, _)| scene).collect();
        let variants = resolve::variants(&self.variants, &base, (&studied, &lenses), !self.quick && !self.no_sweep)?;
        Ok(ErrorStudy::new(scenes, sizes, globals, variants, (self.samples, self.rays)))
    }
}
