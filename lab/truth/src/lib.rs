//! Ground truth about a scene: references that trace it on the CPU, and metrics that compare images with the
//! references. The crate shares no code with the GPU's side, so that agreement between both is evidence.

pub mod metrics;
pub mod reference;
