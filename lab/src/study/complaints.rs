//! Complaints of engines' users about reflections. Each complaint has a case: a small scene and its frames, for which
//! every variant and the world reference compute the reflection. One number for each variant says how much of the fault
//! it shows. `ssct stress --complaints` measures all complaints.

mod cases;
mod frames;
mod measures;
mod pictures;
mod row;
mod scenes;
mod suite;

pub use cases::{COMPLAINTS, Complaint};
pub use row::ComplaintRow;
pub use suite::ComplaintStudy;

/// Methods that are measured if the user names none.
pub const METHODS: [&str; 4] = ["ssct", "dda", "stochastic", "unified"];
