//! Records and images become files. A file is written whole or not at all.

pub mod age_report;
pub mod agreement_report;
pub mod captures;
pub mod compare;
pub mod devices;
pub mod diagrams;
pub mod error_report;
pub mod figures;
pub mod files;
pub mod gbuffer_pictures;
pub mod gpu_study_report;
pub mod html;
pub mod images;
pub mod kept_images;
pub mod library;
pub mod merged;
pub mod mitsuba;
pub mod path_report;
pub mod plot;
pub mod precision_report;
pub mod run_folder;
pub mod sheet;
pub mod stress_report;
pub mod tables;
pub mod trace;
pub mod video_report;
