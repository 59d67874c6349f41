//! Measures claims of the documents about methods. A claim is measured by counts (steps, samples, rays) if a count
//! decides it, by errors if an image does, and otherwise by times of variants that are timed in turn. Prints tables in
//! CSV to standard output.
//!
//! - `counts`: `value` is a mean over pixels, or a share of them: see [`counts`].
//! - `judged`: a method unchanged and with one thing changed, each compared with the exact image of the same screen or
//!   with the world: see [`judged`].
//! - `times`: the time of variants over that of the first one of the same turn: see [`times`].
//! - `rays`: the time of the pass that traces, where only the order of its rays differs: see [`rays`].
//! - `popping`: how much the picture jumps when a method switches to another cube map: see [`popping`].
//!
//! Usage: `cargo bench --bench claims -- counts|judged|times|rays|popping [CLAIM…]`

#![allow(clippy::expect_used)]

mod counts;
#[path = "../edited.rs"]
mod edited;
mod judged;
#[path = "../masked.rs"]
mod masked;
mod popping;
mod rays;
mod times;

use edited::Shaders;
use ssct::gpu::{DeviceQuery, Gpu};
use ssct::methods::{METHODS, MethodInfo, Setup};
use ssct_lab::stage::Globals;
use ssct_scenes::{Scene, library};

/// A change of parameters.
type Change = fn(&Setup) -> Setup;

/// The change that leaves all parameters as they are.
const SAME: Change = Setup::clone;

/// The views that show the thesis's figures: all of the rooms and `hall` of the atrium.
const THESIS: &[(&str, &[&str])] = &[
    ("rooms", &["corridor", "cylinder", "window", "window-floor", "two-cylinders", "ceiling"]),
    ("atrium", &["hall"]),
];

/// The device, the shaders, and the names of the claims that are asked for.
struct Bench {
    gpu: Gpu,
    shaders: Shaders,
    /// The names of the claims; empty for all.
    wanted: Vec<String>,
}

impl Bench {
    /// True if a claim was asked for. Without names of claims, all are.
    fn wants(&self, claim: &str) -> bool {
        self.wanted.is_empty() || self.wanted.iter().any(|name| name == claim)
    }
}

/// Returns the built-in method with a name.
fn method(name: &str) -> &'static MethodInfo {
    METHODS.iter().find(|m| m.name == name).expect("a method")
}

/// Makes the built-in scene with a name.
fn scene(name: &str) -> Scene {
    library::scene(name).expect("a built-in scene")
}

/// Returns the global factors that give all surfaces one roughness and one normal deviation.
fn globals(roughness: f32, normal_deviation: f32) -> Globals {
    Globals { roughness: Some(roughness), normal_deviation: Some(normal_deviation), ..Globals::default() }
}

/// Returns the mean of some values; 0 if there are none.
fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        (sum, count) = (sum + value, count + 1.0);
    }
    sum / f64::max(count, 1.0)
}

/// Opens a device, and measures the claims of the kind that the first argument names.
fn main() {
    let arguments: Vec<_> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let kind = arguments.first().map(String::as_str);
    let gpu = Gpu::open(&DeviceQuery::default()).expect("a Vulkan device");
    println!("# {} ({}), ssct {}", gpu.info().name, gpu.info().driver, env!("CARGO_PKG_VERSION"));
    let wanted = arguments.iter().skip(1).cloned().collect();
    let bench = Bench { gpu, shaders: Shaders::new(), wanted };
    match kind {
        Some("counts") => counts::run(&bench),
        Some("judged") => judged::run(&bench),
        Some("times") => times::run(&bench),
        Some("rays") => rays::run(&bench),
        Some("popping") => popping::run(&bench),
        _ => println!("# say which: counts, judged, times, rays or popping"),
    }
}
