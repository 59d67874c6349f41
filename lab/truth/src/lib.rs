//! What is true of a scene: the scenes themselves, references that trace them on the CPU, and metrics that hold images
//! against these. It shares no code with the GPU's side of anything, so that its agreement with it is evidence.

pub mod inside;
pub mod metrics;
pub mod reference;
pub mod scene;

use ssct::{conventions, error, math};
