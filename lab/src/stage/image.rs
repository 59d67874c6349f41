//! Renders one image and, on request, every image on the way to it.

use super::gbuffer;
use super::{Shot, Stage};
use ssct::error::Result;
use ssct::gpu::{FrameReport, ImageSlice, Pixels};
use ssct::methods::{Intermediate, Output};
use ssct::passes::Content;
use ssct::passes::gbuffer::DrawnCounts;
use ssct::passes::pyramid;

/// A finished image and how it was made.
pub struct RenderedImage {
    /// Linear colour, RGBA.
    pub composite: Pixels,
    /// Reflection colour before fade and reflectivity, and the fade in the fourth channel.
    pub reflection: Pixels,
    /// Meshes drawn and culled.
    pub drawn: DrawnCounts,
    /// The passes that were recorded.
    pub report: FrameReport,
    /// The ends of rays, if the shot was made with hits and the method writes them.
    pub hits: Option<Pixels>,
    /// The intermediates, if asked for.
    pub intermediates: Option<Intermediates>,
}

/// The images on the way to a finished one. Each comes with the stem of its file's name, and with the kind of its
/// content before its pixels.
pub type Intermediates = Vec<(String, Content, Pixels)>;

/// Returns the images on the way to a frame's reflection: the G-buffer, the method's intermediates and its hits.
pub fn intermediates<'s>(shot: &'s Shot, output: &Output<'s>) -> Vec<Intermediate<'s>> {
    let gbuffer = shot.gbuffer.gbuffer();
    let image = |name, content, image| Intermediate { name, content, image };
    let mut images = vec![
        image("albedo", Content::Color, shot.gbuffer.albedo()),
        image("normal", Content::Normal, gbuffer.normal),
        image("depth", Content::ReversedDepth, gbuffer.depth),
        image("material", Content::Material, gbuffer.material),
        image("color", Content::Color, gbuffer.color),
    ];
    images.extend(output.traced.intermediates.iter().copied());
    images.extend(output.traced.hits.map(|h| image("hits", Content::Hits, h.0)));
    images
}

/// Renders a shot and reads its images back. If `keeps_intermediates` is true, the intermediates are read, too; they
/// include the hits if the shot was made with hits.
pub fn render(stage: &mut Stage, shot: &Shot, keeps_intermediates: bool) -> Result<RenderedImage> {
    let (report, drawn, output) = stage.output_at_rest(shot)?;
    let composite = stage.context.read(output.composite.level(0))?;
    let reflection = gbuffer::reflection(&mut stage.context, &output)?;
    let hits = output.traced.hits.map(|hits| stage.context.read(hits.0.all())).transpose()?;
    let mut intermediates = None;
    if keeps_intermediates {
        let mut images = vec![
            ("reflection".into(), Content::Color, reflection.clone()),
            ("composite".into(), Content::Color, composite.clone()),
        ];
        images.extend(read_intermediates(stage, shot, &output)?);
        intermediates = Some(images);
    }
    Ok(RenderedImage { composite, reflection, drawn, report, hits, intermediates })
}

/// Reads the images on the way to a frame's reflection. Each level of a chain becomes an image of its own.
fn read_intermediates<'s>(stage: &mut Stage, shot: &'s Shot, output: &Output<'s>) -> Result<Intermediates> {
    let mut images = Vec::new();
    for Intermediate { name, content, image } in intermediates(shot, output) {
        let parts = image.parts();
        let is_chain = parts.len() > 1 || matches!(content, Content::Pyramid(_));
        let stem = |n: usize| if is_chain { format!("{name}-{n}") } else { name.to_owned() };
        // Only levels that a pass of the frame has written are read. They are found before any is read, since
        // reading a level marks it as written.
        let written: Vec<_> = parts.iter().map(ImageSlice::is_written).collect();
        for (n, part) in parts.iter().enumerate().filter(|(n, _)| written[*n]) {
            let pixels = stage.context.read(*part)?;
            match content {
                Content::Pyramid(extent) => {
                    let levels = pyramid::levels(&pixels, extent).into_iter().enumerate();
                    images.extend(levels.map(|(n, level)| (stem(n), content, level)));
                }
                _ => images.push((stem(n), content, pixels)),
            }
        }
    }
    Ok(images)
}
