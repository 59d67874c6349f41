//! One image and, on request, everything that led to it.

use super::gbuffer;
use super::stage::{Shot, Stage};
use crate::error::Result;
use crate::gpu::{FrameReport, Image, Pixels};
use crate::passes::Content;
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

/// Every intermediate with its file stem.
pub type Intermediates = Vec<(String, Content, Pixels)>;

/// Renders a shot and reads it back. With `dump`, intermediates too; a method that gives its hits
/// only when split should be made so.
pub fn render(stage: &mut Stage, shot: &Shot, dump: bool) -> Result<RenderedImage> {
    let (report, drawn, output) = stage.output(shot)?;
    let composite = stage.context.read(output.composite.all())?;
    let reflection = gbuffer::reflection(&mut stage.context, &output)?;
    let mut intermediates = None;
    if dump {
        let gbuffer = shot.gbuffer.gbuffer();
        let mut all: Vec<(String, Content, &Image)> = vec![
            ("albedo".into(), Content::Color, shot.gbuffer.albedo()),
            ("normal".into(), Content::Normal, gbuffer.normal),
            ("depth".into(), Content::ReversedDepth, gbuffer.depth),
            ("material".into(), Content::Material, gbuffer.material),
            ("color".into(), Content::Color, gbuffer.color),
        ];
        all.extend(output.traced.intermediates.iter().map(|i| (i.name.into(), i.content, i.image)));
        all.extend(output.traced.hits.map(|h| ("hits".into(), Content::Hits, h.0)));
        let mut read = vec![
            ("reflection".into(), Content::Color, reflection.clone()),
            ("composite".into(), Content::Color, composite.clone()),
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
