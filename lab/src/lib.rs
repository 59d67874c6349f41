#![doc = include_str!("../../src/ARCHITECTURE.md")]

pub mod app;
pub mod custom;
pub mod metrics;
pub mod reference;
pub mod report;
pub mod scene;
pub mod study;
#[cfg(feature = "window")]
pub mod window;

use ssct::{error, gpu, math, methods, parameter, passes};
