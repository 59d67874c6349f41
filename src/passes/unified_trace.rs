//! The trace of `unified`: one ray for each mirror pixel over the pyramid, its hit's colour, and the
//! composite in the same pass, over the tiles of a list or over the whole image.

use super::tiles::{TileList, TiledPipeline, TiledTarget, Tiles};
use super::{Canvas, GBuffer, HITS, Hits, LIT_COLOR, Pyramid};
use crate::error::Result;
use crate::gpu::shader::{UNIFIED_MIRROR_FRAG, UNIFIED_MIRROR_HITS_FRAG, UNIFIED_MIRROR_WHOLE_FRAG, UnifiedBlock};
use crate::gpu::{Frame, Gpu, Image, Resource};

/// Pipeline and images of one size.
pub struct UnifiedTracePass {
    mirrors: TiledPipeline,
    hits: Option<Image>,
}

/// What the pass reads.
#[derive(Clone, Copy)]
pub struct UnifiedTraceInput<'a> {
    /// Normals, materials and lit colour.
    pub gbuffer: GBuffer<'a>,
    /// Blocks to trace.
    pub pyramid: Pyramid<'a>,
    /// Where to trace, over a canvas that has begun; `None`, which asks for no hits: all that reflects is a
    /// mirror, and the canvas holds nothing.
    pub tiles: Option<Tiles<'a>>,
    /// Where to draw.
    pub canvas: Canvas<'a>,
}

impl UnifiedTracePass {
    /// For images of a size in pixels. `reflection` says whether the canvases will have one; `hits`, which
    /// need it, asks for them beside the image; `constants` are those of `parameters.glsl`.
    ///
    /// # Errors
    /// As [`TiledPipeline::new`].
    pub fn new(gpu: &Gpu, extent: [u32; 2], reflection: bool, hits: bool, constants: &[i32]) -> Result<Self> {
        let (shader, whole, formats) = if hits {
            (&UNIFIED_MIRROR_HITS_FRAG, None, &[LIT_COLOR, LIT_COLOR, HITS][..])
        } else {
            let drawn = &[LIT_COLOR; 2][..1 + usize::from(reflection)];
            (&UNIFIED_MIRROR_FRAG, Some(&UNIFIED_MIRROR_WHOLE_FRAG), drawn)
        };
        Ok(Self {
            mirrors: TiledPipeline::new(gpu, TileList::Mirrors, shader, whole, formats, constants)?,
            hits: hits.then(|| Image::target(gpu, "hits", HITS, extent)).transpose()?,
        })
    }

    /// Pass "trace/mirrors". Gives where each ray ended, if that was asked for.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        input: &UnifiedTraceInput,
        parameters: &UnifiedBlock,
    ) -> Result<Option<Hits<'a>>> {
        let gbuffer = &input.gbuffer;
        let resources = [
            ("unified", Resource::Uniform(bytemuck::bytes_of(parameters))),
            ("pyramid", Resource::Loaded(input.pyramid.0.all())),
            ("normal_buffer", gbuffer.unified_normals(self.hits.is_some())),
            ("material_buffer", Resource::Loaded(gbuffer.material.all())),
            ("color_buffer", Resource::trilinear(gbuffer.color.level(0))),
        ];
        let hits = self.hits.as_ref();
        let no_hit = hits.map(|image| TiledTarget { image, elsewhere: Some([-1.0, -1.0, -1.0, 0.0]) });
        let targets: Vec<_> =
            input.canvas.images().map(|image| TiledTarget { image, elsewhere: None }).chain(no_hit).collect();
        self.mirrors.draw(frame, "trace/mirrors", &targets, &resources, input.tiles, false)?;
        Ok(hits.map(Hits))
    }
}
