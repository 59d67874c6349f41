//! Complaints of engines' users about reflections, each as a small scene with its truth: what methods show there, and one
//! number for each that says what users complain of. `ssct stress --complaints` measures them.

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

/// Methods that are tried where none are named.
pub const METHODS: [&str; 4] = ["ssct", "dda", "stochastic", "unified"];
