#![doc = include_str!("../../src/ARCHITECTURE.md")]

pub mod app;
pub mod custom;
pub mod error;
pub mod report;
pub mod stage;
pub mod study;

// Names that the page at the top links to.
#[cfg(doc)]
use ssct::{gpu, methods, passes};
#[cfg(doc)]
use ssct_ground::{conventions, math, parameter};
#[cfg(doc)]
use ssct_scenes::inside;
#[cfg(doc)]
use ssct_truth::{metrics, reference};
