#![doc = include_str!("../../src/ARCHITECTURE.md")]

pub mod app;
pub mod custom;
pub mod report;
pub mod stage;
pub mod study;

pub use ssct_truth::{inside, metrics, reference, scene};

use ssct::{conventions, error, gpu, math, methods, parameter, passes};
