//! `captures`: follows the mirror rays of pixels through captures of the scene alone, from where they begin. A lobe is
//! one cone around the mirror ray. As the fallback of a screen-space method, `captures` allows a fair comparison with
//! `unified`, whose lost rays go on in the captures.

use super::{Input, Method, MethodInfo, MethodOutput, MethodRequest, Setup};
use crate::error::Result;
use crate::gpu::{Frame, Gpu, Image};
use crate::passes::follow::{FollowInput, FollowPass, FollowWants};
use crate::passes::lost::{ListContent, LostRays, capture_block};
use crate::passes::{Canvas, HITS, Hits, LIT_COLOR, NO_HIT, Reflection, pyramid, stored_target};

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    takes_captures: true,
    takes_orthographic: true,
    ..MethodInfo::scene(
        "captures",
        "rays followed exactly through captures of the scene alone",
        "this project",
        |gpu, request| Ok(Box::new(CapturesMethod::new(gpu, request)?)),
    )
};

/// The passes, and the images that they write.
pub struct CapturesMethod {
    lost: LostRays,
    /// `None` where there are no captures.
    follow: Option<FollowPass>,
    reflection: Image,
    hits: Option<Image>,
}

impl CapturesMethod {
    /// Makes the passes and the images that they write. Without captures, no pass follows rays.
    pub(super) fn new(gpu: &Gpu, request: &MethodRequest) -> Result<Self> {
        let Setup { extent, projection, .. } = request.setup;
        let (hits, is_fallback) = (request.hits, request.is_fallback);
        let wants = FollowWants { reflection: true, hits, is_fallback, projection, ..FollowWants::default() };
        Ok(Self {
            lost: LostRays::new(gpu, extent, ListContent::Rays)?,
            follow: request.captures.map(|face| FollowPass::new(gpu, pyramid::strip(face), wants)).transpose()?,
            reflection: stored_target(gpu, "captured reflection", LIT_COLOR, extent)?,
            hits: request.hits.then(|| stored_target(gpu, "hits", HITS, extent)).transpose()?,
        })
    }
}

impl Method for CapturesMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        let gbuffer = input.gbuffer;
        let hits = self.hits.as_ref().map(Hits);
        frame.clear("reflection", self.reflection.all(), [0.0; 4])?;
        if let Some(hits) = &self.hits {
            frame.clear("hits", hits.all(), NO_HIT)?;
        }
        let Some((follow, captures)) = self.follow.as_ref().zip(input.captures) else {
            frame.skip("follow", "the scene has no place for a capture");
            return Ok(MethodOutput { hits, ..MethodOutput::new(Reflection(&self.reflection)) });
        };
        let (fades, wants_triangle) = (false, false);
        let parameters = super::unified::parameters(input.camera, gbuffer.depth.extent(), fades);
        let block = capture_block(input.camera, Some(&captures));
        let lost_rays = self.lost.bindings(frame, &block, input.sky, wants_triangle)?;
        self.lost.clear(frame)?;
        follow.record_begin(frame, lost_rays, &gbuffer, input.in_front, &parameters)?;
        let canvas = Canvas { composite: None, reflection: Some(&self.reflection) };
        follow.record_mirrors(frame, FollowInput { captures, lost_rays }, &gbuffer, canvas, hits)?;
        Ok(MethodOutput { hits, ..MethodOutput::new(Reflection(&self.reflection)) })
    }
}
