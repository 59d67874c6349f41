//! The thesis's figures 4.4 (visibility chain) and 4.5 (Hi-Z and linear rays) from intermediates.

use super::images::{Rgb, display, paths, picture};
use super::sheet::{blank, paste};
use crate::error::{Error, Result};
use crate::gpu::Pixels;
use crate::passes::Content;
use crate::scene::Lens;
use crate::study::Intermediates;

/// A figure of the thesis that `ssct render --figure` makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Figure {
    /// The mip chain of the visibility buffer, level 0 omitted.
    #[value(name = "4.4")]
    VisibilityChain,
    /// Which rays Hi-Z traces (green) and which the linear march (red), over the lit scene.
    #[value(name = "4.5")]
    RaySplit,
}

/// Draws a figure.
///
/// # Errors
/// [`Error::Usage`] if the method has not what the figure shows.
pub fn draw(figure: Figure, all: &Intermediates, lens: &Lens) -> Result<Rgb> {
    match figure {
        Figure::VisibilityChain => visibility_chain(all, lens),
        Figure::RaySplit => ray_split(all),
    }
}

fn find<'a>(all: &'a Intermediates, kind: Content, stem: &str) -> Result<&'a Pixels> {
    all.iter()
        .find(|(s, k, _)| s == stem && *k == kind)
        .map(|(_, _, p)| p)
        .ok_or_else(|| Error::Usage(format!("this method has no {stem} to make the figure of")))
}

/// Level 1 at the left, the smaller ones stacked at its right, as the thesis sets them.
fn visibility_chain(all: &Intermediates, lens: &Lens) -> Result<Rgb> {
    let levels: Vec<Rgb> = all
        .iter()
        .filter(|(stem, kind, _)| *kind == Content::Share && stem != "visibility-0")
        .map(|(_, kind, pixels)| picture(*kind, pixels, lens))
        .collect();
    let Some(first) = levels.first() else {
        return Err(Error::Usage("figure 4.4 needs a method with a visibility chain, and more than one level".into()));
    };
    let gap = 4;
    let column = levels.get(1).map_or(0, |l| l.width + gap);
    let stacked: u32 = levels[1..].iter().map(|l| l.height + gap).sum();
    let mut sheet = blank(first.width + column, first.height.max(stacked), 255);
    paste(&mut sheet, first, 0, 0);
    let mut y = 0;
    for level in &levels[1..] {
        paste(&mut sheet, level, first.width + gap, y);
        y += level.height + gap;
    }
    Ok(sheet)
}

fn ray_split(all: &Intermediates) -> Result<Rgb> {
    let lit = display(find(all, Content::Color, "color-0").or_else(|_| find(all, Content::Color, "color"))?);
    let split = paths(find(all, Content::Hits, "hits")?);
    let bytes = lit
        .bytes
        .iter()
        .zip(&split.bytes)
        .zip(split.bytes.chunks_exact(3).flat_map(|p| [p.iter().any(|v| *v > 0); 3]))
        .map(|((l, s), traced)| if traced { (u16::from(*l) / 2 + u16::from(*s) / 2) as u8 } else { *l })
        .collect();
    Ok(Rgb { bytes, ..lit })
}
