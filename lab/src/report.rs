//! Records and images become files. A file is written whole or not at all.

pub mod captures;
pub mod clips;
pub mod compare;
pub mod copies;
pub mod devices;
pub mod diagrams;
pub mod dump;
pub mod figures;
pub mod files;
pub mod gbuffer_pictures;
pub mod gpu_study_report;
pub mod html;
pub mod images;
pub mod kept_images;
pub mod legend;
pub mod library;
pub mod mitsuba;
pub mod pixel;
pub mod plot;
pub mod results;
pub mod run_folder;
pub mod sheet;
mod svg;
pub mod tables;
pub mod trace;
