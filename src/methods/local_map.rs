//! `local-map`: cube maps captured in the scene and looked up by direction alone (thesis §3.1.3; left side of figure 29
//! in Schmidt 2013). A lookup is right only at the place of the capture, and for what is infinitely far away. Maps and
//! blending are those of `pccm`; the methods differ only in the correction of parallax.

use super::MethodInfo;
use super::needs::Need;
use super::pccm::PccmMethod;

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    needs: &[Need::Probes],
    takes_orthographic: true,
    ..MethodInfo::scene(
        "local-map",
        "cube maps captured in the scene, looked up by direction without correction of parallax",
        "Hermanns 2015, §3.1.3; Schmidt 2013, §4.2, figure 29",
        |gpu, request| Ok(Box::new(PccmMethod::new(gpu, &request.setup, false)?)),
    )
};
