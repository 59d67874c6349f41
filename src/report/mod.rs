//! Records and images become files. A file is written whole or not at all.

pub mod compare;
pub mod error_report;
pub mod figures;
pub mod files;
pub mod html;
pub mod images;
pub mod mitsuba;
pub mod path_report;
pub mod plot;
pub mod stress_report;
pub mod tables;
