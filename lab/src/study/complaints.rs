//! Complaints of engines' users about reflections. Each is a small scene with its truth, what methods show there, and one
//! number for what users complain of. `ssct stress --complaints` measures them.

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
