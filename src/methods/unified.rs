//! `unified`: this project's own method. One exact traversal for every ray, and only the work that the
//! frame needs.
//!
//! # The idea
//!
//! A G-buffer is a height field seen from the camera: each pixel is a block, whose front is its depth
//! and whose back lies a thickness T behind it. A reflection ray, projected, is a straight line over
//! this field. The truth of screen space ([`oracle`](crate::reference::oracle)) is the first block on
//! the line that the ray's depth meets. Walking every pixel finds it, in hundreds of steps. The thesis
//! and the engines that followed it skip, and lose hits on the way: at odd sizes, towards the camera,
//! behind objects, far away. This method skips and loses none.
//!
//! **The ray** is followed in (pixel x, pixel y, reversed depth), where it is straight and the frustum is
//! a box. Its direction there is the exact derivative of the projection. For a mirror it has a form in
//! which nothing cancels: the direction v in which the pixel is seen projects to a point and drops out,
//! and of the reflected direction v + a n only the normal's share remains (`ray.glsl`). Reversed depth
//! in f32 keeps its precision at any ratio of near to far.
//!
//! **The pyramid** ([`pyramid`]) holds, for each cell of 2ⁿ × 2ⁿ pixels, the interval from the farthest
//! back to the nearest front of its blocks. Sides are padded so that cell = pixel >> n at every size.
//! T follows the slope of the surface (DEFINITIONS, "Oracle", item 3). As depth plus a constant is
//! proportional to 1 / z, the back is found from differences of stored depths (`pyramid.comp`).
//!
//! **The traversal** (`traverse.glsl`) walks over cells. Over a cell the ray's depth is an interval,
//! whichever way it runs. Where the two intervals don't meet, the ray leaves the cell at once: before
//! objects, behind them, away from the camera or towards it. Where they meet it goes down a level, and
//! in a pixel that is a hit. Cells are integers, the side by which the ray leaves is crossed exactly, and
//! each step goes forward or down, so that no ray can run out of steps.
//!
//! **From in front.** A block has a thickness so that no ray slips through a surface between two pixels. A ray
//! that comes from behind meets it as well, or past an edge, where in the world it passes, or ends on a side of it that
//! the screen does not show; and a ray meets the pixel beside its own, whose surface it leaves. Of the hits that the
//! world does not have, these are most. Version 2 of the oracle (`--oracle 2`) asks where a ray can have come from: of
//! the first pixel by the normal there, and after the walk by one more look at the pyramid, at the pixel before. What
//! is wrong in the world then falls from 0.31 to 0.18 of what is wrong with `ssct` (960×540, medians of 17 views). But a
//! miss is black, and a wrong hit is often a better guess than that: the error against the world becomes 1.01 (0.94 to
//! 1.04) of what it was for mirrors and 1.05 (0.59 to 1.10) at roughness 0.6, so that it is a choice.
//!
//! **Only what is needed.** If no material that is drawn reflects, nothing is recorded: the lit colour is
//! the image. Else [`classify`](crate::passes::classify) lists the tiles that hold mirrors, narrow lobes and
//! wide ones, and each list is drawn indirectly by the passes for it, over the lit colour; where every lit
//! material reflects in one way there is nothing to find out, and the image is drawn at once. Composites are
//! part of the passes that know the reflection, which is stored as an image of its own only for those who
//! ask for it.
//!
//! **Gloss** ([`unified_gloss`](crate::passes::unified_gloss)) is a ray a pixel for narrow lobes, and one
//! for 2 × 2 pixels for wide ones, in directions that neighbours have dealt out among them: each pixel
//! gathers the rays around it as samples of its own lobe, 9 narrow ones or 25 wide ones. Of these it loads 4 or 9:
//! the four of a block of 2 × 2, which are shaded in step, hand on what they loaded (`block.glsl`). Where a map turns
//! the normals, neighbours have little of their wide lobes in common, and each ray stands for more of its own. Wide
//! lobes are shown between the cells around a pixel, as far as their surfaces are its own; the pixels that stand for
//! the cells lie on a chequerboard, so that a joint between tiles, a pixel wide, is not missed by all of them. There
//! is no randomness and no history. Over a fallback ([`Fallback`]) the share of the rays that miss is not
//! black but not there: what is behind shows through it.
//!
//! # What was measured (lavapipe, CPU time of the effect, against the same walk)
//!
//! A walk waits for its fetches. Loading the pyramid as a storage image instead of through a sampler
//! makes the effect 12 to 19 % faster, work moved out of the loop 9 %. A texel that also holds
//! the cell above saves a fifth of the steps and costs more than that; starting at a coarser level, and
//! advancing to the front before going down, gain nothing. Over tiles, only what reflects is paid for, since a
//! device without branches runs every shader for every pixel that is drawn: on the atrium of Sponza, a sixth
//! of which reflects, gloss takes 0.6 of the time that it takes over the whole image, and on the built-in
//! one, of which a half does, 0.9. Where all reflects, tiles of 16 pixels as points make the trace 2 to 8 %
//! slower than the whole image in one draw, of 8 pixels 16 to 20 %, of 32 as much as of 16; dispatched as
//! workgroups they are as slow as those of 8, and as quads a fifth slower, since blocks on their diagonals
//! are shaded twice. What rays saw is not cleared between the tiles: who gathers asks which neighbours were drawn.
//! (Where a tenth reflects, the clear was two fifths of the trace of narrow lobes.)
//!
//! A texel lies in memory beside those above and below it, not only beside those to its left and right
//! (`pyramid.glsl`): most rays walk up the screen. What the loop writes, it writes as often as it runs: parameters are
//! read before it and the block that was hit after it, and one coordinate of two is followed. Together the effect takes
//! 0.89 of its time for mirrors, by version 2 0.92 (record `walk`).
//!
//! What version 2 costs more is not arithmetic, but the normal at the hit, which no pixel beside it has asked for:
//! with normals as a storage image it takes 0.88 of its time for mirrors, and with the colour chain's coarse levels in one
//! dispatch 0.92 and 0.91 at roughness 0.1 and 0.6 (record `normals`).
//!
//! Cells that hold a plane and the blocks' distances from it, instead of an interval of depth, would be passed earlier
//! by rays along a floor. Counted on the CPU in a trial, with the best plane of each cell, mirror rays look at 0.04 to 0.09
//! fewer cells (nine views), and from 640×480 to 1920×1080 their number grows as it does without. What grows is the climb to
//! coarse cells and the way down again, one to five cells for twice the pixels along a side. (Levels of 4 × 4 cells, and
//! going up or down several levels at once, take 1.02 to 1.10 of the time.)
//!
//! The pyramid in one dispatch takes 1.1 times what the thesis's depth and Hi-Z, which have no backs, take in a
//! fragment pass a level (960×540). Gathering four depths at once made it 16 % faster, and 64 pixels a thread instead
//! of 16 another 17 %. A third of what remains are the stores of level 0.
//!
//! Handing on what a block loads takes 0.75 of the time of the cells. As one load of four packed words instead of two
//! of floats and halves, a ray of a wide lobe makes them 1.6 times as slow: unpacking costs more than the load. Of
//! narrow lobes the record stays packed. Materials as storage images make the classification take 0.65 of the time.
//!
//! A cell in one word of 32 bits instead of two floats (20 bits of front, 12 of span, rounded outwards, and
//! the block itself asked for at every candidate) takes a tenth longer: what is saved in fetches goes into
//! unpacking; as two words of an image with one channel it is no faster either. Not storing the reflection saves a
//! tenth of a frame of mirrors.
//!
//! A colour chain that is aware of edges, by a finer level wherever the pyramid's cell around the hit is thicker than a
//! tenth of its depth, has 0.90 to 1.05 of the error (1.01 in the median of four views and four roughness values): each
//! ray stands for so small a part of a lobe that its footprint seldom reaches across an edge.
//!
//! Narrow lobes with a ray for two pixels take 0.7 of the time, at 1.5 times the error and with a third more change
//! under a moving camera. Traced, gathered and composited in one pass, from the four rays of a block alone, they
//! take 0.9 of the time, at 1.08 times the error and with a quarter to a third more change. (Both against six rays
//! gathered, not nine.)

use super::{Fallback, Input, Making, Method, MethodInfo, Traced};
use crate::error::Result;
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{Frame, Gpu, Image};
use crate::passes::classify::ClassifyPass;
use crate::passes::color_chain::ColorChainPass;
use crate::passes::pyramid::{self, PyramidPass};
use crate::passes::unified_gloss::UnifiedGlossPass;
use crate::passes::unified_trace::{UnifiedTraceInput, UnifiedTracePass};
use crate::passes::{Canvas, LIT_COLOR, Reflection};
use crate::scene::Camera;

/// The table's row.
pub const INFO: MethodInfo = MethodInfo {
    name: "unified",
    summary: "one exact Hi-Z traversal for every direction; only what the scene needs",
    source: "this project",
    follows_oracle: true,
    create: |gpu, making| Ok(Box::new(UnifiedMethod::new(gpu, making)?)),
    ..MethodInfo::SCREEN
};

/// The passes in their order, and what the last of them draw into.
pub struct UnifiedMethod {
    pyramid: PyramidPass,
    color: ColorChainPass,
    classify: ClassifyPass,
    trace: UnifiedTracePass,
    gloss: UnifiedGlossPass,
    composite: Image,
    reflection: Option<Image>,
    fade: bool,
    /// Whether hits are wanted beside the image.
    hits: bool,
    /// Whether the image is finished by the passes that know the reflection.
    composites: bool,
}

impl UnifiedMethod {
    /// Makes pipelines and images.
    pub(super) fn new(gpu: &Gpu, making: &Making) -> Result<Self> {
        let (extent, effect, hits) = (making.setup.extent, making.setup.effect(), making.hits);
        let image = |name| Image::target(gpu, name, LIT_COLOR, extent);
        // The shader that writes hits writes the reflection, too.
        let reflection = making.reflection || hits;
        // STRIP, ORACLE and OVER of parameters.glsl: nobody pays for what another setup asks for.
        let over = effect.fallback != Fallback::None;
        let constants = [pyramid::strip(extent) as i32, u32::from(effect.oracle) as i32, i32::from(over)];
        Ok(Self {
            pyramid: PyramidPass::new(gpu, extent)?,
            color: ColorChainPass::in_few_passes(gpu)?,
            classify: ClassifyPass::new(gpu, extent)?,
            trace: UnifiedTracePass::new(gpu, extent, reflection, hits, &constants)?,
            gloss: UnifiedGlossPass::new(gpu, extent, reflection, hits, &constants)?,
            composite: image("composite")?,
            reflection: reflection.then(|| image("reflection")).transpose()?,
            fade: effect.fade,
            hits,
            composites: making.composite,
        })
    }
}

impl Method for UnifiedMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<Traced<'a>> {
        let gbuffer = &input.gbuffer;
        let reflectors = gbuffer.reflectors;
        if !reflectors.any() {
            for pass in ["pyramid", "classify", "trace", "composite"] {
                frame.skip(pass, "no material that is drawn reflects");
            }
            return Ok(Traced::nothing(gbuffer));
        }
        let parameters = parameters(input.camera, gbuffer.depth.extent(), self.fade);
        let canvas = Canvas { composite: &self.composite, reflection: self.reflection.as_ref() };
        let pyramid = self.pyramid.record(frame, gbuffer, &parameters)?;
        if reflectors.glossy() {
            self.color.record(frame, gbuffer)?;
        } else {
            frame.skip("color", "no material that is drawn is glossy");
        }

        // Over the tiles that hold each kind of reflector; everywhere, where all that is lit is of one kind.
        let tiles = if reflectors.everywhere && reflectors.kinds() == 1 && !self.hits {
            frame.skip("classify", "every material that is drawn and lit reflects, and in one way");
            None
        } else {
            let tiles = self.classify.record(frame, gbuffer, &parameters)?;
            canvas.begin(frame, gbuffer.color)?;
            Some(tiles)
        };
        let mut hits = None;
        if reflectors.mirrors || self.hits {
            let traced = UnifiedTraceInput { gbuffer: *gbuffer, pyramid, tiles, canvas };
            hits = self.trace.record(frame, &traced, &parameters)?;
        } else {
            frame.skip("trace/mirrors", "no material that is drawn is a mirror");
        }
        self.gloss.record(frame, gbuffer, pyramid, &parameters, canvas, tiles)?;

        let composite = self.composites.then_some(canvas.composite);
        let reflection = canvas.reflection.map(Reflection);
        Ok(Traced { reflection, composite, hits, intermediates: Vec::new() })
    }
}

/// The parameters of a camera for a size in pixels. What of the projection is needed is computed in
/// f64 and rounded once.
pub fn parameters(camera: &Camera, extent: [u32; 2], fade: bool) -> UnifiedBlock {
    let projection = camera.view_to_clip_reversed().as_dmat4();
    let to_clip = [projection.x_axis.x, projection.y_axis.y];
    let side = extent.map(f64::from);
    UnifiedBlock {
        view_to_clip: to_clip.map(|v| v as f32),
        pixel_to_clip: side.map(|n| (1.0 / n) as f32),
        pixel_to_view: [0, 1].map(|i| (1.0 / (side[i] * to_clip[i])) as f32),
        size: extent.map(|v| v as i32),
        padded: pyramid::padded(extent).map(|v| v as i32),
        top_level: pyramid::top_level(extent) as i32,
        depth_offset: -projection.z_axis.z as f32,
        fade_start: 0.8,
        fade_end: 1.0,
        fade: i32::from(fade),
        ..UnifiedBlock::default()
    }
}
