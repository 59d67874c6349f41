//! Ground truth about a scene: the scenes themselves, references that trace them on the CPU, and metrics that compare images
//! with the references. The crate shares no code with the GPU's side, so that agreement between both is evidence.

pub mod inside;
pub mod metrics;
pub mod reference;
pub mod scene;

use ssct::{conventions, error, math};
