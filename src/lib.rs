#![doc = include_str!("ARCHITECTURE.md")]

pub mod app;
pub mod error;
pub mod gpu;
pub mod math;
pub mod methods;
pub mod passes;
pub mod report;
pub mod scene;
pub mod study;
