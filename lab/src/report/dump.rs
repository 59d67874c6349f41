//! Writes the files of `ssct render --dump`: every image on the way to a frame, the fade, and whether each pixel is right (docs/dump.md has
//! a row for every file).

use super::files;
use super::images::{Color, PATH_COLORS, Rgb, paths, picture, write_exr};
use super::legend::legend;
use crate::error::Result;
use crate::stage::Intermediates;
use ssct::gpu::Pixels;
use ssct::passes::{Content, PathCode};
use ssct_scenes::Lens;
use ssct_scenes::inside::PathInFolder;
use ssct_truth::metrics::verdict::PixelVerdict;

/// The verdicts, each with its colour and its text in the legend.
const VERDICT_COLORS: [(PixelVerdict, Color, &str); 4] = [
    (PixelVerdict::NotReflecting, [0; 3], "does not reflect"),
    (PixelVerdict::Right, [0, 170, 0], "right: what the world shows"),
    (PixelVerdict::WrongByScreen, [230, 60, 0], "wrong by the screen, which has what belongs there"),
    (PixelVerdict::WrongByWorld, [60, 90, 230], "wrong by the world: the screen does not have it"),
];

/// The images and verdicts of a frame.
pub struct Dump<'a> {
    /// Every image on the way, with the stem of its file's name.
    pub intermediates: &'a Intermediates,
    /// The lens of the camera, which decides the shades of depths.
    pub lens: &'a Lens,
    /// Reflection colour, and the fade in the fourth channel.
    pub reflection: &'a Pixels,
    /// The verdict of each pixel, rows from the top.
    pub verdicts: &'a [PixelVerdict],
}

impl Dump<'_> {
    /// Writes every image as PNG and EXR, with legends beside the pictures whose colours mean something.
    pub fn write(&self, folder: &PathInFolder) -> Result<()> {
        for (stem, content, pixels) in self.intermediates {
            picture(*content, pixels, self.lens).write_png(folder.join(format!("{stem}.png")))?;
            write_exr(folder.join(format!("{stem}.exr")), pixels, channels(*content))?;
            if *content == Content::Hits {
                paths(pixels).write_png(folder.join("paths.png"))?;
                files::write(folder.join("paths-legend.svg"), path_legend(pixels).as_bytes())?;
            }
        }
        self.write_fade(folder)?;
        self.write_verdicts(folder)
    }

    /// Writes the fade, which is the fourth channel of the reflection.
    fn write_fade(&self, folder: &PathInFolder) -> Result<()> {
        let Pixels { width, height, .. } = *self.reflection;
        let values = self.reflection.texels().map(|texel| texel[3]).collect();
        let fade = Pixels { width, height, channels: 1, values };
        picture(Content::Share, &fade, self.lens).write_png(folder.join("fade.png"))?;
        Ok(write_exr(folder.join("fade.exr"), &fade, &["fade"])?)
    }

    /// Writes the verdicts as a picture in the colours of [`VERDICT_COLORS`], with a legend, and as an EXR whose
    /// numbers are the rows of the verdicts in that table.
    fn write_verdicts(&self, folder: &PathInFolder) -> Result<()> {
        let Pixels { width, height, .. } = *self.reflection;
        let row = |verdict: &PixelVerdict| VERDICT_COLORS.iter().position(|(known, ..)| known == verdict).unwrap_or(0);
        let rows: Vec<usize> = self.verdicts.iter().map(row).collect();
        let bytes = rows.iter().flat_map(|row| VERDICT_COLORS[*row].1).collect();
        Rgb { width, height, bytes }.write_png(folder.join("verdict.png"))?;
        let values = rows.iter().map(|row| *row as f32).collect();
        write_exr(folder.join("verdict.exr"), &Pixels { width, height, channels: 1, values }, &["verdict"])?;
        let count = |n: usize| rows.iter().filter(|row| **row == n).count();
        let entries: Vec<_> =
            VERDICT_COLORS.iter().enumerate().map(|(n, (_, color, meaning))| (*color, *meaning, count(n))).collect();
        Ok(files::write(folder.join("verdict-legend.svg"), legend("verdict.png", &entries).as_bytes())?)
    }
}

/// The names of an image's channels in OpenEXR.
fn channels(content: Content) -> &'static [&'static str] {
    match content {
        Content::Color => &["R", "G", "B", "A"],
        Content::Normal => &["N.X", "N.Y", "N.Z", "N.W"],
        Content::ReversedDepth => &["depth"],
        Content::StandardDepth => &["min", "max"],
        Content::LinearDepth => &["z"],
        Content::Pyramid(_) => &["front", "back"],
        Content::Numbers => &["X", "Y", "Z", "W"],
        Content::Share => &["share"],
        Content::Material => &["reflectivity", "roughness"],
        Content::Hits => &["u", "v", "depth", "path"],
        Content::Steps => &["steps"],
    }
}

/// Returns the legend of paths.png as SVG: the colours that occur, with the number of pixels that have each.
fn path_legend(hits: &Pixels) -> String {
    let codes: Vec<_> = hits.texels().filter_map(|texel| PathCode::from_channel(texel[3])).collect();
    let count = |paths: &[PathCode]| codes.iter().filter(|code| paths.contains(code)).count();
    let entries: Vec<_> = PATH_COLORS
        .iter()
        .map(|(color, paths, meaning)| (*color, *meaning, count(paths)))
        .filter(|(.., count)| *count > 0)
        .collect();
    legend("paths.png", &entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_path_code_has_one_colour() {
        for code in (0..=PathCode::Capture as u8).filter_map(|code| PathCode::from_channel(code.into())) {
            let rows = PATH_COLORS.iter().filter(|(_, codes, _)| codes.contains(&code)).count();
            assert_eq!(rows, 1, "{code:?}");
        }
        let colors: std::collections::BTreeSet<_> = PATH_COLORS.iter().map(|(color, ..)| color).collect();
        assert_eq!(colors.len(), PATH_COLORS.len(), "colours tell codes apart");
    }

    #[test]
    fn a_legend_counts_the_colours_that_occur() {
        let texel = |code: PathCode| [0.0, 0.0, 0.0, f32::from(code as u8)];
        let values = [PathCode::HiZ, PathCode::HiZ, PathCode::None, PathCode::Linear].map(texel).concat();
        let text = path_legend(&Pixels { width: 4, height: 1, channels: 4, values });
        assert!(text.contains("hit by the Hi-Z traversal, 2 pixels, 50.0 %"), "{text}");
        assert!(text.contains("1 pixel, 25.0 %") && !text.contains("capture"), "{text}");
    }
}
