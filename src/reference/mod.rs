//! Truth on the CPU. Nothing here knows the GPU or a pass, so that agreement is evidence.

pub mod bvh;
pub mod first_hits;
pub mod lobe;
pub mod random;
pub mod surface;
pub mod world;
pub mod world_hits;
pub mod world_state;
