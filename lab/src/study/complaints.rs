//! Complaints of engines' users about reflections. Each complaint has a small scene, the true reflection there, the
//! reflections by methods, and one number that measures the complaint. `ssct stress --complaints` measures all
//! complaints.

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
