#![doc = include_str!("ARCHITECTURE.md")]

pub mod app;
pub mod error;
pub mod gpu;
pub mod math;
pub mod methods;
pub mod metrics;
pub mod parameter;
pub mod passes;
pub mod reference;
pub mod report;
pub mod scene;
pub mod study;
