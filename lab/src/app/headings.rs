//! The headings of the long help. They have a file of their own, so that whoever declares options need not know the help.

/// The heading of the options that choose what is looked at.
pub const SCENE: &str = "Scene and camera";
/// The heading of the options that choose methods, and of the parameters of the effect around every method.
pub const METHOD: &str = "Method";
/// The heading of the options that say what is measured, and how much of it.
pub const MEASUREMENT: &str = "Measurement";
/// The heading of the options of the window.
pub const WINDOW: &str = "Window";
/// The heading of the options that say what is written and printed.
pub const OUTPUT: &str = "Output";
/// The heading of the options that choose the device, and of those that every command has.
pub const DEVICE: &str = "Device and help";
