//! `ssr-fast`: the optimised march of Schmidt 2013 (section 5.4, listing 5). It goes ten pixels forward while the ray
//! is before the surface, and a tenth of a pixel back while the ray is behind it.

use super::MethodInfo;
use super::layers::LayerParams;
use super::ssr::SchmidtMethod;
use crate::passes::color_chain::ChainFilter;
use crate::passes::schmidt_trace::SchmidtMarch;
use ssct_ground::parameter::{Parameter, Parameters, Preset, parameters};

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    parameters: SsrFastParams::table,
    ..MethodInfo::screen(
        "ssr-fast",
        "the same in steps of ten pixels forward and a tenth back; mirrors only",
        "Schmidt 2013, §5.4, listing 5",
        |gpu, request| {
            let SsrFastParams { pixel_step, distance_blur, chain_filter, .. } = request.setup.parameters();
            let blur = distance_blur.then_some(chain_filter);
            Ok(Box::new(SchmidtMethod::new(gpu, request, SchmidtMarch::Optimized, pixel_step, blur)?))
        },
    )
};

parameters! {
    /// Parameters of `ssr-fast`.
    pub struct SsrFastParams {
        /// Pixels that the march goes at once.
        pixel_step: u32 = Parameter::new(1)
            .within(1, 1024)
            .unit("pixels")
            .sweep(Preset::Published, &[2])
            .source("Schmidt 2013, listing 5"),
        /// Blur by the distance from the viewer.
        distance_blur: bool = Parameter::new(false)
            .sweep(Preset::Published, &[true])
            .source("Schmidt 2013, listing 5: toggleBlur"),
        /// How the colour chain is filtered.
        chain_filter: ChainFilter =
            Parameter::new(ChainFilter::Hardware).source("Schmidt 2013, listing 5: a mip level of the diffuse colour"),
        /// Layers of depth.
        layers: LayerParams,
    }
}
