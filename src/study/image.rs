//! One image and, on request, everything that led to it.

use super::gbuffer;
use super::stage::{Shot, Stage};
use crate::error::Result;
use crate::gpu::{FrameReport, Image, Pixels};
use crate::passes::gbuffer::Drawn;

/// A finished image and how it was made.
pub struct RenderedImage {
    /// Linear colour, RGBA.
    pub composite: Pixels,
    /// Reflection colour before fade and reflectivity, and the fade in the fourth channel.
    pub reflection: Pixels,
    /// Meshes drawn and culled.
    pub drawn: Drawn,
    /// Passes recorded.
    pub report: FrameReport,
    /// The intermediates, if asked for.
    pub intermediates: Option<Intermediates>,
}

/// What an intermediate's numbers are, for whoever draws it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dump {
    /// Linear colour.
    Color,
    /// View-space normal.
    Normal,
    /// Reversed depth.
    ReversedDepth,
    /// Standard depth, minimum and maximum.
    StandardDepth,
    /// Shares 0…1.
    Share,
    /// Reflectivity and roughness.
    Material,
    /// Texture coordinates, depth and path code.
    Hits,
}

/// Every intermediate with its file stem.
pub type Intermediates = Vec<(String, Dump, Pixels)>;

/// Renders a shot and reads it back. With `dump`, intermediates too; a method that gives its hits
/// only when split should be made so.
pub fn render(stage: &mut Stage, shot: &Shot, dump: bool) -> Result<RenderedImage> {
    let (report, drawn, output) = stage.output(shot)?;
    let composite = stage.context.read(output.composite.all())?;
    let reflection = gbuffer::reflection(&mut stage.context, &output)?;
    let mut intermediates = None;
    if dump {
        let gbuffer = shot.gbuffer.gbuffer();
        let mut all: Vec<(String, Dump, &Image)> = vec![
            ("albedo".into(), Dump::Color, shot.gbuffer.albedo()),
            ("normal".into(), Dump::Normal, gbuffer.normal),
            ("depth".into(), Dump::ReversedDepth, gbuffer.depth),
            ("material".into(), Dump::Material, gbuffer.material),
            ("color".into(), Dump::Color, gbuffer.color),
        ];
        all.extend(output.hi_z.map(|c| ("hi-z".into(), Dump::StandardDepth, c.0)));
        all.extend(output.visibility.map(|c| ("visibility".into(), Dump::Share, c.0)));
        all.extend(output.hits.map(|h| ("hits".into(), Dump::Hits, h.0)));
        let mut read = vec![
            ("reflection".into(), Dump::Color, reflection.clone()),
            ("composite".into(), Dump::Color, composite.clone()),
        ];
        for (name, kind, image) in all {
            for level in 0..image.levels() {
                let stem = if image.levels() > 1 { format!("{name}-{level}") } else { name.clone() };
                read.push((stem, kind, stage.context.read(image.level(level))?));
            }
        }
        intermediates = Some(read);
    }
    Ok(RenderedImage { composite, reflection, drawn, report, intermediates })
}
