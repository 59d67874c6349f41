//! `unified`: this project's own method, with one exact traversal for every ray, and only the work that the frame
//! needs. `docs/unified.md` has what was measured on the way, and what was tried and left out.
//!
//! # The idea
//!
//! A G-buffer is a height field seen from the camera: each pixel is a block, whose front is its depth and whose back
//! lies a thickness T behind its front. A reflection ray, projected, is a straight line over this field. The true hit
//! of screen space (`reference::oracle`) is the first block on the line that the ray's depth meets. A walk over every
//! pixel finds this block in hundreds of steps. The thesis and the engines that followed it skip pixels, and lose hits
//! on the way: at odd sizes, towards the camera, behind objects, far away. This method skips pixels and loses no hit.
//!
//! **The ray** is followed in the space of (pixel x, pixel y, reversed depth), where it is straight and the frustum is
//! a box. Its direction there is the exact derivative of the projection. A mirror with normal n reflects the direction
//! v, in which the pixel is seen, to v + a n. Since v projects to a point, the derivative depends on a n alone, and
//! nothing cancels (`ray.glsl`). Reversed depth in f32 keeps its precision at any ratio of near to far.
//!
//! **The pyramid** ([`pyramid`]) holds, for each cell of 2ⁿ × 2ⁿ pixels, the interval from the farthest
//! back to the nearest front of its blocks. Sides are padded so that cell = pixel >> n at every size.
//! T follows the slope of the surface (docs/definitions.md, "Oracle", item 3). As depth plus a constant is
//! proportional to 1 / z, the back is found from differences of stored depths (`pyramid.comp`).
//!
//! **The traversal** (`traverse.glsl`) walks over cells. Over a cell the ray's depth is an interval, whichever way the
//! ray runs. If the intervals of ray and cell don't meet, the ray leaves the cell at once: before objects, behind them,
//! away from the camera or towards it. If they meet, the walk goes down a level; in a pixel, the ray hits. Cells have
//! integer coordinates, sides are crossed exactly, and each step goes forward or down: no ray runs out of steps.
//!
//! **From in front.** A block has a thickness so that no ray slips through a surface between two pixels. Therefore a
//! block also stops rays that come from behind it or pass an edge, and the block beside a ray's own pixel stops a ray
//! that leaves its surface. Most false hits are of these kinds. Version 2 of the oracle asks where a ray can have come
//! from. The normal answers for the first pixel, and the pixel before a hit answers for the hit, after the walk.
//! Version 2 is optional, since a miss is black, and a wrong hit is often a better guess than black.
//!
//! **Beyond the screen.** With captures the screen is one image of the scene among several. A ray that the
//! screen loses, because it leaves the screen or goes behind something, goes on through cubes of images with the same
//! pyramid, by the same traversal ([`follow`](crate::passes::follow)). With captures, rays hit only what they meet from
//! in front, and nothing fades at the screen's border.
//!
//! **Only what is needed.** If no material that is drawn reflects, nothing is recorded: the lit colour is the image.
//! Otherwise [`classify`](crate::passes::classify) lists the tiles that hold mirrors, narrow lobes and wide lobes, and
//! the passes for each list draw its tiles indirectly, over the lit colour. If every lit material reflects in one way,
//! nothing is classified, and the whole image is drawn at once. The passes that know the reflection also composite it,
//! and store it as an image of its own only if that is wanted.
//!
//! **Gloss** ([`unified_gloss`](crate::passes::unified_gloss)) takes one ray a pixel for narrow lobes, and one ray for
//! 2 × 2 pixels for wide lobes. Neighbours have different directions of one pattern, and each pixel gathers the rays
//! around it as samples of its own lobe: 9 rays of narrow lobes or 25 of wide ones. A fragment loads only 4 or 9 of
//! them, since the four pixels of a block of 2 × 2, which are shaded in step, exchange what they loaded
//! (`exchanged_rays.glsl`). In compute shaders a workgroup loads its rays once into shared memory (`shared_rays.glsl`).
//! Where a map turns the normals, the wide lobes of neighbours have little in common, and the footprint of each ray
//! covers more of its own lobe. A pixel with a wide lobe interpolates between the cells around it that show its own
//! surface. The pixels that stand for cells lie as on a chequerboard, so that a line one pixel wide does not escape all
//! of them. Nothing is random. Pixels whose neighbours' rays say little of their reflection can have own rays
//! ([`OwnRaysPass`]). With a history, each frame of a camera at rest deals out new directions. Over a fallback
//! ([`Fallback`]) a ray that misses is not black but transparent, so that the fallback shows through.
//!
//! **Two stages.** Each pass that traces or gathers has a fragment program and a compute program, made from one source.
//! The two make the same image to the bit on devices whose stages compute alike; which is faster depends on the device.
//! [`UnifiedParams`] chooses one stage for the traces and one for the passes that gather, and the parameter `stage`
//! chooses one for all. Only the pipelines of the chosen stages are made. A fragment program is drawn over tiles as
//! points. A compute program runs in as many workgroups of 8 × 8 as the classification has counted.
//!
//! **The shaders**, in reading order (`shaders-glsl/unified/`): `parameters.glsl`; `pyramid.glsl` and `pyramid.comp`;
//! `classify.comp`; `tile.vert` and `groups.glsl`, which place fragment programs and compute programs over tiles;
//! `gloss.glsl`, which has the lobes; in `trace/`: `traverse.glsl`, `surface.glsl`, `mirror.glsl` and
//! `gloss_trace.glsl`; in `resolve/`: `gathered.glsl`, `exchanged_rays.glsl`, `shared_rays.glsl`, `narrow.glsl`,
//! `cells.glsl` and `wide.glsl`; for captures `shaders-glsl/captures/`: `lost.glsl`, `seen.glsl`, `faces.glsl`,
//! `follow.comp`. A `.frag` and a `.comp` of the same stem include each file that traces or resolves. The `.comp` files
//! that write finished pixels share `store.glsl`. Pyramid, traversal and gloss have CPU twins in `reference::unified`.

mod beyond;

use super::setup::{HistoryUse, Stage, StageChoice};
use super::thesis::FadeParams;
use super::{Fallback, Input, Method, MethodInfo, MethodOutput, MethodRequest, Setup};
use crate::error::Result;
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{Frame, Gpu, Image, Precision, Sampled, ShaderStage};
use crate::passes::classify::ClassifyPass;
use crate::passes::color_chain::ColorChainPass;
use crate::passes::follow::{FollowInput, FollowPass, FollowWants};
use crate::passes::lost::{ListContent, LostRays, capture_block};
use crate::passes::own_rays::{OwnRaysInput, OwnRaysPass};
use crate::passes::pyramid::{self, PyramidPass};
use crate::passes::tiles::UnifiedSetup;
use crate::passes::triangle_scene::{TriangleBindings, TriangleReading};
use crate::passes::triangle_trace::{TriangleInput, TriangleTracePass, TriangleWants};
use crate::passes::unified_gloss::{UnifiedGlossInput, UnifiedGlossPass};
use crate::passes::unified_trace::{UnifiedTraceInput, UnifiedTracePass};
use crate::passes::{Canvas, LIT_COLOR, Reflection, Reflectors};
use beyond::{BeyondInput, BeyondPass};
use ssct_ground::math::OracleVersion;
use ssct_ground::parameter::{Parameter, Parameters, choices, parameters};
use ssct_ground::scene::Camera;

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    follows_oracle: true,
    takes_captures: true,
    takes_triangles: true,
    takes_orthographic: true,
    parameters: UnifiedParams::table,
    ..MethodInfo::screen(
        "unified",
        "one exact Hi-Z traversal for every direction; only what the scene needs",
        "this project",
        |gpu, request| Ok(Box::new(UnifiedMethod::new(gpu, request)?)),
    )
};

/// If the parameter `first` is `auto`, a CPU traces every ray among the triangles of scenes with up to this many
/// triangles, and a GPU in every scene (docs/unified.md).
const MAX_TRACED_FIRST_ON_CPU: u32 = 60_000;

choices! {
    /// What colour a ray sees where it meets a triangle.
    pub enum HitColor {
        /// The screen's, where a renderer hands over triangles with colours and lights the screen itself; the
        /// triangle's where the lights of the scene are known.
        Auto = "auto",
        /// The screen's where the screen shows the place, else the triangle's.
        Screen = "screen",
        /// The triangle's.
        Triangles = "triangles",
    }
}

choices! {
    /// Who is asked first where a ray ends.
    pub enum FirstTraced {
        /// The screen, on a device that is a CPU and in a scene with many triangles; the triangles everywhere else.
        Auto = "auto",
        /// The screen first, and the triangles for rays whose end the screen does not show.
        Screen = "screen",
        /// The triangles.
        Triangles = "triangles",
    }
}

impl HitColor {
    /// Whether hits on these triangles have the screen's colour. With `auto`, they have it if the triangles are unlit.
    fn is_screen_color(self, triangles: TriangleReading) -> bool {
        match self {
            Self::Auto => triangles.unlit,
            Self::Screen => true,
            Self::Triangles => false,
        }
    }
}

parameters! {
    /// Who answers rays in `unified`, and the shader stages in which it runs.
    pub struct UnifiedParams {
        /// Who is asked first where a ray ends, among the triangles of the scene: the screen, whose rays go on among
        /// the triangles where it loses them; or the triangles, and no ray walks over the screen.
        first: FirstTraced = Parameter::new(FirstTraced::Auto).source("this project (docs/unified.md)"),
        /// What colour a ray sees where it meets a triangle: that of the triangle, as its material and the lights of
        /// the scene make it; or that of the screen wherever the screen shows the place, over the ray's footprint.
        /// Where a renderer lights its screen in a way that nobody else knows, the screen is right.
        hit_color: HitColor = Parameter::new(HitColor::Auto).source("this project (docs/unified.md)"),
        /// The shaders that trace the rays of unified (passes trace/mirrors, trace/narrow and trace/wide). The image is
        /// the same, and which is faster depends on the device (docs/unified.md).
        trace_stage: StageChoice = Parameter::new(StageChoice::Auto).source("this project"),
        /// The shaders that gather what those rays saw (passes resolve/narrow, cells and resolve/wide). The image is
        /// the same.
        resolve_stage: StageChoice = Parameter::new(StageChoice::Auto).source("this project"),
        /// Where reflections fade.
        border: FadeParams,
    }
}

/// The passes in their order, and the images that those which know the reflection write.
pub struct UnifiedMethod {
    pyramid: PyramidPass,
    color: ColorChainPass,
    classify: ClassifyPass,
    trace: UnifiedTracePass,
    gloss: UnifiedGlossPass,
    lost: LostRays,
    own_rays: OwnRaysPass,
    beyond: Option<BeyondPass>,
    /// Whether rays walk over the screen first.
    walks_screen: bool,
    /// Whether hits on triangles have the screen's colours.
    screen_colors: bool,
    /// The finished image, if it is wanted.
    composite: Option<Image>,
    reflection: Option<Image>,
    /// Whether a history asks where rays ended.
    stores_ends: bool,
    fade: bool,
    /// Where reflections fade.
    border: FadeParams,
    /// Greatest distance of a pixel's point from the surface that the pixel shows, in pixels.
    max_point_offset_px: f32,
}

impl UnifiedMethod {
    /// Makes the method `unified`, by its own parameters.
    pub(super) fn new(gpu: &Gpu, request: &MethodRequest) -> Result<Self> {
        let UnifiedParams { first, hit_color, trace_stage, resolve_stage, .. } = request.setup.parameters();
        let walks_screen = match (request.triangles, first) {
            (None, _) | (_, FirstTraced::Screen) => true,
            (Some(_), FirstTraced::Triangles) => false,
            (Some(triangles), FirstTraced::Auto) => gpu.info().is_cpu() && triangles.count > MAX_TRACED_FIRST_ON_CPU,
        };
        let triangles = request
            .triangles
            .map(|triangles| TriangleReading { screen_colors: hit_color.is_screen_color(triangles), ..triangles });
        let stages = [trace_stage, resolve_stage].map(|choice| choice.on(gpu, request.setup.effect().stage));
        Self::in_stages(gpu, request, (walks_screen, triangles), stages)
    }

    /// Makes the method `traced`, whose rays are all traced among the triangles, without a walk over the screen.
    pub(super) fn among_triangles(gpu: &Gpu, request: &MethodRequest) -> Result<Self> {
        let stage = StageChoice::Auto.on(gpu, Stage::Published);
        Self::in_stages(gpu, request, (false, request.triangles), [stage; 2])
    }

    /// Makes the method for the shader stages of the passes that trace and of those that gather. `walks_screen` says
    /// whether rays are followed over the screen first, and `triangles` how shaders read those that rays may meet.
    fn in_stages(
        gpu: &Gpu,
        request: &MethodRequest,
        (walks_screen, triangles): (bool, Option<TriangleReading>),
        [trace_stage, resolve_stage]: [ShaderStage; 2],
    ) -> Result<Self> {
        let Setup { extent, projection, .. } = request.setup;
        let (effect, hits) = (request.setup.effect(), request.hits);
        let follows_lost_rays = request.captures.is_some() || triangles.is_some();
        // A program that writes hits writes composite and reflection, too.
        let (composite, reflection) = (request.composite || hits, request.reflection || hits);
        let stores_ends = effect.history == HistoryUse::On;
        let setup = UnifiedSetup {
            extent,
            projection,
            strip: pyramid::strip(extent),
            // A hit from behind is a worse guess than the end that captures or triangles give.
            oracle: if follows_lost_rays { OracleVersion::V2 } else { effect.oracle },
            over_fallback: effect.fallback != Fallback::None,
            composite,
            reflection,
            walks_screen,
            follows_lost_rays,
            triangles,
            own_rays: if request.captures.is_some() { 0 } else { effect.own_rays.on(gpu, triangles.is_some()) },
            stores_ends,
            trace_stage,
            resolve_stage,
        };
        let image = |name| setup.target(gpu, name, LIT_COLOR);
        let beyond = match (triangles, request.captures) {
            (Some(triangles), _) if walks_screen => {
                let wanted = TriangleWants { composite, reflection, hits, stores_ends, projection };
                Some(BeyondPass::Triangles(TriangleTracePass::new(gpu, triangles, wanted)?))
            }
            (None, Some(face)) => {
                let wanted = FollowWants {
                    over_fallback: setup.over_fallback,
                    composite,
                    reflection,
                    hits,
                    stores_ends,
                    is_fallback: false,
                    projection,
                };
                Some(BeyondPass::Captures(FollowPass::new(gpu, pyramid::strip(face), wanted)?))
            }
            // Rays that are traced among the triangles at once are never lost.
            _ => None,
        };
        let list_content = match &beyond {
            Some(_) => ListContent::Rays,
            None if setup.own_rays > 0 => ListContent::Pixels,
            None => ListContent::Nothing,
        };
        Ok(Self {
            pyramid: PyramidPass::for_projection(gpu, extent, projection)?,
            color: ColorChainPass::in_few_passes(gpu)?,
            classify: ClassifyPass::new(gpu, extent)?,
            trace: UnifiedTracePass::new(gpu, &setup, hits)?,
            gloss: UnifiedGlossPass::new(gpu, &setup)?,
            own_rays: OwnRaysPass::new(gpu, &setup)?,
            lost: LostRays::new(gpu, extent, list_content)?,
            beyond,
            walks_screen,
            screen_colors: triangles.is_some_and(|triangles| triangles.screen_colors),
            stores_ends,
            composite: composite.then(|| image("composite")).transpose()?,
            reflection: reflection.then(|| image("reflection")).transpose()?,
            // Rays go on where the screen ends, so that nothing fades there.
            fade: effect.fade && !follows_lost_rays,
            border: request.setup.parameters(),
            max_point_offset_px: max_point_offset_px(gpu.precision(), effect.divisor()),
        })
    }

    /// Records the pass that empties the list of lost rays, if a later pass follows the rays on the list.
    fn clear_lost(&self, frame: &mut Frame) -> Result<()> {
        if self.beyond.is_some() { self.lost.clear(frame) } else { Ok(()) }
    }

    /// Records the passes of the colour chain, or tells the frame why no ray looks up a blurred colour of the screen.
    fn record_color_chain(&self, frame: &mut Frame, input: &Input, plan: Plan) -> Result<()> {
        let why_skipped = if self.screen_colors {
            None
        } else if !self.walks_screen {
            Some("no ray looks up a colour on the screen")
        } else if input.triangles.is_some() {
            Some("what a ray hits is shaded as the triangle that it is on")
        } else if plan.narrow || plan.wide {
            None
        } else {
            Some("no material that is drawn is glossy")
        };
        match (why_skipped, input.sky) {
            (Some(why), _) => frame.skip("color", why),
            (None, Some(_)) => {
                self.color.record_without_sky(frame, &input.gbuffer)?;
            }
            (None, None) => {
                self.color.record(frame, &input.gbuffer)?;
            }
        }
        Ok(())
    }
}

/// The passes that a frame needs, by the kinds of reflectors that its materials have.
#[derive(Clone, Copy)]
struct Plan {
    mirrors: bool,
    narrow: bool,
    wide: bool,
    /// Whether all lit surfaces reflect in one way, so that nothing is classified and passes draw the whole image.
    whole: bool,
}

impl Plan {
    /// Chooses the passes for the reflectors of a frame.
    fn new(reflectors: Reflectors) -> Self {
        let Reflectors { mirrors, narrow, wide, everywhere } = reflectors;
        Self { mirrors, narrow, wide, whole: everywhere && reflectors.kinds() == 1 }
    }

    /// Tells the frame which passes are left out, and why.
    fn note_skipped(self, frame: &mut Frame) {
        let left_out: [(bool, &[&str], &str); 4] = [
            (self.whole, &["classify"], "every material that is drawn and lit reflects, and in one way"),
            (!self.mirrors, &["trace/mirrors"], "no material that is drawn is a mirror"),
            (!self.narrow, &["trace/narrow", "resolve/narrow"], "no material that is drawn has a narrow lobe"),
            (!self.wide, &["trace/wide", "cells", "resolve/wide"], "no material that is drawn has a wide lobe"),
        ];
        for (_, passes, why) in left_out.into_iter().filter(|(is_left_out, ..)| *is_left_out) {
            passes.iter().for_each(|pass| frame.skip(pass, why));
        }
    }
}

impl Method for UnifiedMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        let gbuffer = input.gbuffer;
        if !gbuffer.reflectors.any() {
            for pass in ["pyramid", "classify", "trace", "composite"] {
                frame.skip(pass, "no material that is drawn reflects");
            }
            return Ok(MethodOutput::nothing(&gbuffer));
        }
        let plan = Plan::new(gbuffer.reflectors);
        plan.note_skipped(frame);
        let mut parameters = parameters(input.camera, gbuffer.depth.extent(), self.fade);
        [parameters.fade_start, parameters.fade_end] = self.border.ends();
        parameters.turn = input.frames_at_rest as i32;
        parameters.sky = i32::from(input.sky.is_some());
        let block = capture_block(input.camera, input.captures.as_ref());
        // First the blocks and bindings of rays beyond the screen, then the passes in their order.
        let lit_triangles = input.triangles.zip(input.scene);
        let lights = lit_triangles.map(|(t, scene)| scene.data.light_block(t.world_to_tree())).unwrap_or_default();
        // The sides of a pixel are twice as long as `pixel_to_view`, which is for half a pixel.
        let [width, height] = parameters.pixel_to_view.map(|half| 2.0 * half);
        let max_offset = self.max_point_offset_px * width.hypot(height);
        let triangle_block = input.triangles.map(|t| t.block(input.camera, max_offset)).unwrap_or_default();
        let triangle_bindings = input.triangles.map(|triangles| TriangleBindings {
            triangles,
            block: &triangle_block,
            lights: &lights,
            screen_color: Sampled::nearest(if self.screen_colors {
                gbuffer.color.all()
            } else {
                gbuffer.color.level(0)
            }),
            screen_depth: Sampled::nearest(gbuffer.depth.all()),
        });
        let wants_triangle = triangle_bindings.is_some() && gbuffer.triangle.is_none();
        let lost_rays = self.lost.bindings(frame, &block, input.sky, wants_triangle)?;
        let beyond_input = match (triangle_bindings, input.captures) {
            (Some(triangle_bindings), _) => {
                Some(BeyondInput::Triangles(TriangleInput { parameters: &parameters, triangle_bindings, lost_rays }))
            }
            (None, Some(captures)) => Some(BeyondInput::Captures(FollowInput { captures, lost_rays })),
            (None, None) => None,
        };
        let beyond = self.beyond.as_ref().zip(beyond_input.as_ref());
        let canvas = Canvas { composite: self.composite.as_ref(), reflection: self.reflection.as_ref() };

        let pyramid = if self.walks_screen {
            input.in_first_bounce(|| self.pyramid.record(frame, &gbuffer, &parameters), || self.pyramid.recorded())?
        } else {
            frame.skip("pyramid", "no ray walks over the screen");
            self.pyramid.recorded()
        };
        self.record_color_chain(frame, input, plan)?;
        let tiles = if plan.whole {
            self.classify.whole()
        } else {
            let classify = &self.classify;
            let tiles =
                input.in_first_bounce(|| classify.record(frame, &gbuffer, &parameters), || classify.recorded())?;
            canvas.begin(frame, gbuffer.color)?;
            tiles
        };
        let hits = if plan.mirrors {
            let input = UnifiedTraceInput { gbuffer, pyramid, tiles, canvas, lost_rays, triangle_bindings };
            self.clear_lost(frame)?;
            let hits = self.trace.record(frame, &input, &parameters)?;
            if let Some((pass, input)) = beyond {
                pass.record_mirrors(frame, input, (&gbuffer, canvas, hits))?;
            }
            hits
        } else {
            self.trace.clear_hits(frame)?
        };
        let gloss = UnifiedGlossInput { gbuffer, pyramid, tiles, canvas, lost_rays, triangle_bindings };
        let own_rays = OwnRaysInput { gbuffer, pyramid, canvas, lost_rays, triangle_bindings };
        let gloss_images = self.gloss.images();
        if plan.narrow {
            self.clear_lost(frame)?;
            self.gloss.trace_narrow(frame, &gloss, &parameters)?;
            if let Some((pass, input)) = beyond {
                pass.record_narrow(frame, input, gloss_images)?;
            }
            self.own_rays.clear(frame, &self.lost)?;
            self.gloss.resolve_narrow(frame, &gloss, &parameters)?;
            self.own_rays.record(frame, "own/narrow", own_rays, &parameters)?;
        }
        if plan.wide {
            self.clear_lost(frame)?;
            self.gloss.trace_wide(frame, &gloss, &parameters)?;
            if let Some((pass, input)) = beyond {
                pass.record_wide(frame, input, gloss_images)?;
            }
            self.own_rays.clear(frame, &self.lost)?;
            self.gloss.resolve_wide(frame, &gloss, &parameters)?;
            self.own_rays.record(frame, "own/wide", own_rays, &parameters)?;
        }

        let reflection = canvas.reflection.map(Reflection);
        let ends = self.stores_ends.then_some(&gloss_images.ends);
        let pyramid = self.walks_screen.then(|| pyramid.as_intermediate(gbuffer.depth.extent()));
        Ok(MethodOutput { reflection, composite: canvas.composite, hits, ends, intermediates: Vec::from_iter(pyramid) })
    }
}

/// Returns how far a pixel's point may lie beside the surface that the pixel shows, in pixels along each axis of the
/// screen. A rasteriser rounds corners to parts of a pixel: to 2⁻⁸ at best, since another device may have drawn the
/// G-buffer. A pixel that stands for `divisor` × `divisor` pixels has the depth of the first of them.
fn max_point_offset_px(precision: Precision, divisor: u32) -> f32 {
    let rounding = 0.5f32.powi(precision.sub_pixel_bits.min(8) as i32 + 1);
    rounding + 0.5 * (divisor - 1) as f32 / divisor as f32
}

/// Returns the parameters of `unified` for a camera and a size in pixels, computed in f64 and rounded once. `fade` says
/// whether reflections fade at the screen's border, and the numbers of the fade are the published ones.
pub fn parameters(camera: &Camera, extent: [u32; 2], fade: bool) -> UnifiedBlock {
    let projection = camera.view_to_clip_reversed().as_dmat4();
    let to_clip = [projection.x_axis.x, projection.y_axis.y];
    let side = extent.map(f64::from);
    // The column that is multiplied by w: by z in a perspective, and by 1 in an orthographic projection.
    let shift = if camera.kind().is_orthographic() { projection.w_axis } else { projection.z_axis };
    let [fade_start, fade_end] = FadeParams::default().ends();
    UnifiedBlock {
        view_to_clip: to_clip.map(|v| v as f32),
        pixel_to_clip: side.map(|n| (1.0 / n) as f32),
        pixel_to_view: [0, 1].map(|i| (1.0 / (side[i] * to_clip[i])) as f32),
        size: extent.map(|v| v as i32),
        padded: pyramid::padded(extent).map(|v| v as i32),
        top_level: pyramid::top_level(extent) as i32,
        depth_offset: -projection.z_axis.z as f32,
        shift: [0, 1].map(|i| (side[i] * shift[i]) as f32),
        depth_origin: projection.w_axis.z as f32,
        reach: camera.reach_m(1.0) as f32,
        fade_start,
        fade_end,
        fade: i32::from(fade),
        ..UnifiedBlock::default()
    }
}
