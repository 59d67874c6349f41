//! `hzct`: Hi-Z cone tracing (Uludag, GPU Pro 5), the method that the thesis extends, as the thesis describes it
//! (§4.2): `ssct` without the linear march, and with a fade for rays towards the camera.

use super::MethodInfo;
use super::ssct::{ThesisDrawing, ThesisMethod};
use super::thesis::{ConeParams, FadeParams, HiZParams};
use crate::gpu::shader::ThesisBlock;
use ssct_ground::parameter::{Parameter, Parameters, parameters};

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    traces_hi_z: true,
    parameters: HzctParams::table,
    ..MethodInfo::screen(
        "hzct",
        "Hi-Z tracing and cone tracing; rays towards the camera fade out",
        "Hermanns 2015, §4.2; Uludag, GPU Pro 5",
        |gpu, request| {
            let HzctParams { hi_z, cone, border, camera_fade, drawn } = request.setup.parameters();
            let fill = move |block| {
                let block = border.fill(cone.fill(hi_z.fill(block)));
                ThesisBlock { fade_towards_camera: camera_fade, ..block }
            };
            Ok(Box::new(ThesisMethod::new(gpu, request, drawn, None, Box::new(fill))?))
        },
    )
};

parameters! {
    /// Parameters of `hzct`.
    pub struct HzctParams {
        /// Parameters of the Hi-Z traversal.
        hi_z: HiZParams,
        /// Parameters of the cone trace.
        cone: ConeParams,
        /// Where reflections fade.
        border: FadeParams,
        /// How fast reflections fade out as their rays turn towards the camera; 0 for not at all.
        camera_fade: f32 = Parameter::new(10.0).between(0.0, 1e6).source("not printed; the author's program"),
        /// How the passes are made.
        drawn: ThesisDrawing,
    }
}
