//! `stochastic`: each pixel draws rays from its lobe and gathers those of the pixels around it, by a ratio estimator; a
//! history averages over frames. Engines call this stochastic screen-space reflections (Stachowiak, "Stochastic
//! Screen-Space Reflections", SIGGRAPH 2015 course Advances in Real-Time Rendering; Heitz, Hill and McGuire 2018 for
//! the estimator). With many rays and without neighbours, it is the average of several rays of thesis §3.1.5.

use super::ssct::SsctParams;
use super::thesis::FadeParams;
use super::{Fallback, Input, Intermediate, Method, MethodInfo, MethodOutput, MethodRequest, thesis, unified};
use crate::error::Result;
use crate::gpu::programs::{StochasticExact, StochasticThesis};
use crate::gpu::shader::{StochasticBlock, UnifiedBlock};
use crate::gpu::{Frame, Gpu};
use crate::passes::Content;
use crate::passes::hi_z::HiZPass;
use crate::passes::lost::{ListContent, LostRays, capture_block};
use crate::passes::pyramid::{self, PyramidPass};
use crate::passes::stochastic::{Rays, StochasticResolvePass, StochasticTrace};
use ssct_ground::parameter::{Parameter, Parameters, Preset, choices, parameters};

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    follows_oracle: true,
    parameters: StochasticParams::table,
    ..MethodInfo::screen(
        "stochastic",
        "rays drawn from the lobe, resolved over neighbours by ratios; with a history over frames",
        "Stachowiak 2015; Heitz et al. 2018",
        |gpu, request| Ok(Box::new(StochasticMethod::new(gpu, request)?)),
    )
};

choices! {
    /// How `stochastic` walks its rays.
    pub enum StochasticWalk {
        /// The exact walk, over the pyramid of `unified`.
        Exact = "exact",
        /// The thesis's walk, which `ssct` uses: over the Hi-Z buffer, and by a march towards the camera.
        Thesis = "thesis",
    }
}

/// The source of values that are tuned.
const TUNED: &str = "tuned (docs/findings.md)";

parameters! {
    /// Parameters of `stochastic`.
    pub struct StochasticParams {
        /// Rays that each pixel traces in a frame.
        stochastic_rays: u32 = Parameter::new(1)
            .within(1, 64)
            .unit("rays")
            .sweep(Preset::Published, &[2, 4])
            .source("Stachowiak 2015: one; thesis §3.1.5: several"),
        /// Rays that a pixel gathers of those around it, its own among them; with 1 there is no spatial filter.
        stochastic_gathered: u32 = Parameter::new(9)
            .within(1, 32)
            .unit("rays")
            .sweep(Preset::Published, &[1, 4, 16])
            .source(TUNED),
        /// Distance within which they are gathered.
        stochastic_radius: f32 = Parameter::new(2.0)
            .between(0.0, 64.0)
            .unit("pixels")
            .sweep(Preset::Published, &[1.5, 3.0])
            .source(TUNED),
        /// Part of the lobe's distribution that rays are drawn from: below 1 the rare wide ones are left out.
        stochastic_part: f32 = Parameter::new(0.7)
            .above(0.0, 1.0)
            .sweep(Preset::Published, &[0.5, 1.0])
            .source("Stachowiak 2015: 0.7 and the like; tuned (docs/findings.md)"),
        /// How rays are walked, so that traversal and denoising can be told apart.
        stochastic_walk: StochasticWalk = Parameter::new(StochasticWalk::Exact)
            .sweep(Preset::Published, &[StochasticWalk::Thesis])
            .source("this project"),
        /// Where reflections fade.
        border: FadeParams,
    }
}

struct StochasticMethod {
    walk: Walk,
    resolve: StochasticResolvePass,
    /// An empty list, since no ray of this method goes on beyond the screen; shaders get the sky with it.
    lost: LostRays,
    parameters: StochasticParams,
    fade: bool,
}

/// The passes that trace rays, by the kind of walk.
enum Walk {
    Exact(PyramidPass, StochasticTrace<StochasticExact<'static>>),
    Thesis(HiZPass, SsctParams, StochasticTrace<StochasticThesis<'static>>),
}

impl StochasticMethod {
    fn new(gpu: &Gpu, request: &MethodRequest) -> Result<Self> {
        let (setup, extent, stage) = (&request.setup, request.setup.extent, request.setup.stage());
        let parameters: StochasticParams = setup.parameters();
        let effect = setup.effect();
        let walk = match parameters.stochastic_walk {
            StochasticWalk::Exact => {
                let strip = pyramid::strip(extent);
                let trace =
                    StochasticTrace::<StochasticExact>::new(gpu, stage, extent, strip, effect.oracle, request.hits)?;
                Walk::Exact(PyramidPass::new(gpu, extent)?, trace)
            }
            StochasticWalk::Thesis => {
                let ssct: SsctParams = setup.parameters();
                let trace =
                    StochasticTrace::<StochasticThesis>::new(gpu, stage, extent, ssct.march.numbers(), request.hits)?;
                Walk::Thesis(HiZPass::new(gpu, stage, extent, false)?, ssct, trace)
            }
        };
        let resolve = StochasticResolvePass::new(gpu, extent, effect.fallback != Fallback::None)?;
        let lost = LostRays::new(gpu, extent, ListContent::Nothing)?;
        Ok(Self { walk, resolve, lost, parameters, fade: effect.fade })
    }

    /// Records trace and resolve once for each ray that a pixel traces in a frame. `trace` records one trace.
    fn record_turns<'r>(
        &self,
        frame: &mut Frame,
        input: &Input,
        unified: &UnifiedBlock,
        trace: impl Fn(&mut Frame, &StochasticBlock) -> Result<Rays<'r>>,
    ) -> Result<()> {
        let StochasticParams { stochastic_rays: rays, stochastic_part, stochastic_radius, stochastic_gathered, .. } =
            self.parameters;
        (0..rays).try_for_each(|ray| {
            let stochastic = StochasticBlock {
                turn: input.frame.wrapping_mul(rays).wrapping_add(ray) as i32,
                part: stochastic_part,
                radius: stochastic_radius,
                gathered: stochastic_gathered as i32,
                first: i32::from(ray == 0),
                last: i32::from(ray + 1 == rays),
            };
            let traced = trace(frame, &stochastic)?;
            self.resolve.record(frame, &input.gbuffer, traced, (unified, &stochastic))
        })
    }
}

impl Method for StochasticMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        let gbuffer = &input.gbuffer;
        if !gbuffer.reflectors.any() {
            for pass in ["pyramid", "trace", "resolve", "composite"] {
                frame.skip(pass, "no material that is drawn reflects");
            }
            return Ok(MethodOutput::nothing(gbuffer));
        }
        let extent = gbuffer.depth.extent();
        let mut unified = unified::parameters(input.camera, extent, self.fade);
        [unified.fade_start, unified.fade_end] = self.parameters.border.ends();
        unified.sky = i32::from(input.sky.is_some());
        let (sky_block, wants_triangle) = (capture_block(input.camera, None), false);
        let lost_rays = self.lost.bindings(frame, &sky_block, input.sky, wants_triangle)?;
        let mut intermediates = Vec::new();
        let hits = match &self.walk {
            Walk::Exact(pyramid, trace) => {
                let pyramid =
                    input.in_first_bounce(|| pyramid.record(frame, gbuffer, &unified), || pyramid.recorded())?;
                intermediates.push(pyramid.as_intermediate(extent));
                self.record_turns(frame, input, &unified, |frame, stochastic| {
                    trace.record(frame, gbuffer, pyramid, lost_rays, (&unified, stochastic))
                })?;
                trace.hits()
            }
            Walk::Thesis(hi_z_pass, ssct, trace) => {
                let hi_z = input.in_first_bounce(|| hi_z_pass.record(frame, gbuffer), || hi_z_pass.recorded())?;
                let (name, content) = ("hi-z", Content::StandardDepth);
                intermediates.push(Intermediate { name, content, image: hi_z.0 });
                let camera_block = thesis::block(input.camera, extent, hi_z.0.levels(), self.fade);
                let block = ssct.border.fill(ssct.march.fill(ssct.hi_z.fill(camera_block)));
                self.record_turns(frame, input, &unified, |frame, stochastic| {
                    trace.record(frame, gbuffer, (hi_z, &block), lost_rays, (&unified, stochastic))
                })?;
                trace.hits()
            }
        };
        let (reflection, ends) = self.resolve.resolved();
        Ok(MethodOutput { hits, intermediates, ends: Some(ends), ..MethodOutput::new(reflection) })
    }
}
