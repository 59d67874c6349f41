//! Draws figures of the thesis from intermediate images: 4.4 (visibility chain), 4.5 (Hi-Z and linear rays), 4.9 and
//! 4.10 (the chains of SSLR). Also draws the poster's figure 2, which is the image under three setups.

use super::images::{Rgb, display, paths, picture};
use super::sheet::{blank, paste};
use crate::error::{Error, Result};
use crate::stage::Intermediates;
use ssct::gpu::Pixels;
use ssct::methods::poster::PosterParams;
use ssct::methods::{EffectParams, Setup};
use ssct::passes::{Content, PosterFilter};
use ssct_ground::parameter::choices;
use ssct_scenes::Lens;
use std::ops::Range;

choices! {
    /// A figure of the thesis that the program makes from one render.
    pub enum Figure {
        /// The mip chain of the visibility buffer, level 0 omitted.
        VisibilityChain = "4.4",
        /// Which rays Hi-Z traces (green) and which the linear march (red), over the lit scene.
        RaySplit = "4.5",
        /// The first five mip levels of SSLR's ray trace colour.
        RayTraceColorChain = "4.9",
        /// The first five mip levels of SSLR's mask.
        MaskChain = "4.10",
        /// The poster's figure 2a: mip-mapping, which may cause artifacts; without fading.
        PosterMip = "poster-2a",
        /// The poster's figure 2b: the same with the Gaussian filter.
        PosterGaussian = "poster-2b",
        /// The poster's figure 2c: with fading too.
        PosterFade = "poster-2c",
    }
}

impl Figure {
    /// The method that the figure shows.
    pub fn method(self) -> &'static str {
        match self {
            Self::VisibilityChain | Self::RaySplit => "ssct",
            Self::RayTraceColorChain | Self::MaskChain => "sslr",
            Self::PosterMip | Self::PosterGaussian | Self::PosterFade => "poster",
        }
    }

    /// Returns `setup` with the parameters that the figure fixes.
    pub fn setup(self, setup: &Setup) -> Setup {
        let poster_setup = |filter, fade| {
            let setup = setup.with(|p: &mut PosterParams| p.poster_filter = filter);
            setup.with(|p: &mut EffectParams| p.fade = fade)
        };
        match self {
            Self::PosterMip => poster_setup(PosterFilter::Mip, false),
            Self::PosterGaussian => poster_setup(PosterFilter::Volume, false),
            Self::PosterFade => poster_setup(PosterFilter::Volume, true),
            _ => setup.clone(),
        }
    }
}

/// Number of levels in the figures 4.9 and 4.10.
const SSLR_LEVELS: usize = 5;

/// Draws a figure from the intermediate images of a frame that was rendered for it; `lens` is that of the camera. It is
/// an error if the frame lacks an image that the figure shows.
pub fn draw(figure: Figure, images: &Intermediates, lens: &Lens) -> Result<Rgb> {
    match figure {
        Figure::VisibilityChain => chain(images, "visibility", 1..usize::MAX, lens),
        Figure::RaySplit => ray_split(images),
        Figure::RayTraceColorChain => chain(images, "ray-trace-color", 0..SSLR_LEVELS, lens),
        Figure::MaskChain => chain(images, "mask", 0..SSLR_LEVELS, lens),
        Figure::PosterMip | Figure::PosterGaussian | Figure::PosterFade => {
            Ok(display(find_image(images, Content::Color, "composite")?))
        }
    }
}

/// Returns the pixels of the intermediate image with a stem and a content.
fn find_image<'a>(images: &'a Intermediates, wanted: Content, stem: &str) -> Result<&'a Pixels> {
    images
        .iter()
        .find(|(name, content, _)| name == stem && *content == wanted)
        .map(|(.., pixels)| pixels)
        .ok_or_else(|| Error::usage(format!("this method has no {stem} to make the figure of")))
}

/// Draws the levels `wanted` of the chain `name`, arranged as in the thesis: the first at the left, the smaller ones
/// stacked at its right. The levels' images have the stems `name-0`, `name-1` and so on.
fn chain(images: &Intermediates, name: &str, wanted: Range<usize>, lens: &Lens) -> Result<Rgb> {
    let level_of = |stem: &str| stem.strip_prefix(name)?.strip_prefix('-')?.parse().ok();
    let levels: Vec<Rgb> = images
        .iter()
        .filter(|(stem, ..)| level_of(stem).is_some_and(|level: usize| wanted.contains(&level)))
        .map(|(_, content, pixels)| picture(*content, pixels, lens))
        .collect();
    let Some(first) = levels.first() else {
        let least = wanted.start + 1;
        return Err(Error::usage(format!("the figure needs a method with a chain {name} of more than {least} levels")));
    };
    let gap = 4;
    let column_width = levels.get(1).map_or(0, |level| level.width + gap);
    let column_height: u32 = levels[1..].iter().map(|level| level.height + gap).sum();
    let mut sheet = blank(first.width + column_width, first.height.max(column_height), 255);
    paste(&mut sheet, first, 0, 0);
    let mut y = 0;
    for level in &levels[1..] {
        paste(&mut sheet, level, first.width + gap, y);
        y += level.height + gap;
    }
    Ok(sheet)
}

/// Draws the lit scene, in which each pixel whose path code is not black in [`paths`] is mixed half and half with the
/// colour of the code.
fn ray_split(images: &Intermediates) -> Result<Rgb> {
    let lit = display(
        find_image(images, Content::Color, "color-0").or_else(|_| find_image(images, Content::Color, "color"))?,
    );
    let split = paths(find_image(images, Content::Hits, "hits")?);
    // For each byte of the picture, whether the path code of its pixel has a colour.
    let has_color = split.bytes.chunks_exact(3).flat_map(|pixel| [pixel.iter().any(|byte| *byte > 0); 3]);
    let mix = |lit: u8, code: u8| (u16::from(lit) / 2 + u16::from(code) / 2) as u8;
    let bytes = lit
        .bytes
        .iter()
        .zip(&split.bytes)
        .zip(has_color)
        .map(|((lit, code), has_color)| if has_color { mix(*lit, *code) } else { *lit })
        .collect();
    Ok(Rgb { bytes, ..lit })
}
