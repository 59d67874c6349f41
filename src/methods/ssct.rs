//! `ssct`: Hi-Z tracing, a linear march for rays towards the camera, and cone tracing (thesis ch. 4).
//! `hzct` is the same without the march; both are [`ThesisMethod`].

use super::thesis::{self, Variant};
use super::{Input, Intermediate, Method, MethodInfo, Sees, Setup, Traced};
use crate::error::Result;
use crate::gpu::{Frame, Gpu};
use crate::passes::color_chain::ColorChainPass;
use crate::passes::hi_z::HiZPass;
use crate::passes::thesis_trace::{ThesisTracePass, TraceInput};
use crate::passes::visibility::VisibilityPass;
use crate::passes::{Content, GBuffer, Hits, LIT_COLOR, Reflection};
use crate::scene::Camera;

/// The table's row.
pub const INFO: MethodInfo = MethodInfo {
    name: "ssct",
    summary: "Hi-Z tracing, linear fallback for rays towards the camera, cone tracing",
    source: "Hermanns 2015, ch. 4",
    sees: Sees::Screen,
    settings: thesis::settings,
    create: |gpu, setup| Ok(Box::new(ThesisMethod::new(gpu, setup, true)?)),
};

/// The thesis's passes in their order.
pub struct ThesisMethod {
    hi_z: HiZPass,
    visibility: VisibilityPass,
    color: ColorChainPass,
    trace: ThesisTracePass,
    variant: Variant,
}

impl ThesisMethod {
    /// With the linear fallback (`ssct`) or without (`hzct`).
    pub fn new(gpu: &Gpu, setup: &Setup, fallback: bool) -> Result<Self> {
        Ok(Self {
            hi_z: HiZPass::new(gpu, setup.extent)?,
            visibility: VisibilityPass::new(gpu, setup.extent)?,
            color: ColorChainPass::new(gpu, setup.extent, LIT_COLOR, setup.chain_filter)?,
            trace: ThesisTracePass::new(gpu, setup.extent, fallback, setup.split, setup.split)?,
            variant: Variant { preset: setup.preset, tuning: setup.tuning, fallback, fade: setup.fade },
        })
    }
}

impl ThesisMethod {
    /// The chains and the cone trace from hits of any origin: what the cone makes of exact hits.
    /// The method must have been made split.
    pub fn record_cone<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer<'a>,
        camera: &Camera,
        hits: Hits,
    ) -> Result<Reflection<'a>> {
        let hi_z = self.hi_z.record(frame, gbuffer)?;
        let visibility = self.visibility.record(frame, hi_z, &camera.lens)?;
        let color = self.color.record(frame, gbuffer)?;
        let parameters = thesis::parameters(&self.variant, camera, gbuffer.depth.extent(), hi_z.0.levels());
        let input = TraceInput { gbuffer: *gbuffer, hi_z, visibility, color };
        self.trace.record_cone(frame, &input, &parameters, hits)
    }
}

impl Method for ThesisMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<Traced<'a>> {
        let gbuffer = &input.gbuffer;
        let hi_z = self.hi_z.record(frame, gbuffer)?;
        let visibility = self.visibility.record(frame, hi_z, &input.camera.lens)?;
        let color = self.color.record(frame, gbuffer)?;
        let extent = gbuffer.depth.extent();
        let parameters = thesis::parameters(&self.variant, input.camera, extent, hi_z.0.levels());
        let traced = TraceInput { gbuffer: *gbuffer, hi_z, visibility, color };
        let (reflection, hits) = self.trace.record(frame, &traced, &parameters)?;
        let made = |name, content, image| Intermediate { name, content, image };
        let intermediates =
            vec![made("hi-z", Content::StandardDepth, hi_z.0), made("visibility", Content::Share, visibility.0)];
        Ok(Traced { hits, intermediates, ..Traced::new(reflection) })
    }
}
