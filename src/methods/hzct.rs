//! `hzct`: Hi-Z cone tracing as the thesis describes its base (§4.2; Uludag, GPU Pro 5): `ssct`
//! without the linear fallback, and with a fade of rays towards the camera.

use super::ssct::ThesisMethod;
use super::{MethodInfo, Sees, thesis};

/// The table's row.
pub const INFO: MethodInfo = MethodInfo {
    name: "hzct",
    summary: "Hi-Z tracing and cone tracing; rays towards the camera fade out",
    source: "Hermanns 2015, §4.2; Uludag, GPU Pro 5",
    sees: Sees::Screen,
    settings: thesis::settings,
    create: |gpu, setup| Ok(Box::new(ThesisMethod::new(gpu, setup, false)?)),
};
