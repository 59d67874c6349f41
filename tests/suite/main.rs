//! The integration tests, in one program: they are linked once, and run beside each other on as many threads as
//! there are processors. One file is chosen by its name: `cargo test --test suite gloss::`.
//!
//! No test changes environment variables or the working folder, which all tests share: a test that needs other ones
//! starts the command, or this program again. Tests that measure the process itself, or break devices, are in
//! `tests/alone`.

#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "../common/mod.rs"]
mod common;

mod architecture;
mod area_light;
mod billboard;
mod bounces;
mod camera_capture;
mod captures;
mod chains;
mod ci;
mod cli;
mod compare;
mod complaints;
mod cone;
mod contributing;
mod cube_maps;
mod custom_methods;
mod dda;
mod docs;
mod embed;
mod embed_example;
mod embed_motion;
mod embed_triangles;
mod embed_unsound;
mod error_study;
mod exclusions;
mod figures;
mod filters;
mod foreign;
mod gbuffer_file;
mod gbuffer_maps;
mod gloss;
mod gloss_twin;
mod glossary;
mod golden;
mod hi_z_ray_trace;
mod history;
mod hit_color;
mod ibr;
mod impostors;
#[cfg(unix)]
mod interrupted;
mod layers;
mod library;
mod lists;
mod many;
mod mirror;
mod moving;
mod needs;
mod oracle_rooms;
mod orthographic;
mod overlap;
mod own_rays;
mod page;
mod pixel;
mod plain_words;
mod planar;
mod precision;
mod ray_queries;
mod renewal;
mod resolution;
mod same;
mod scene_loading;
mod schmidt;
mod shader_sources;
mod shaders;
mod shards;
mod stages;
mod stochastic;
mod stress;
mod sync;
mod time_files;
mod trace_normals;
mod triangles;
mod unified;
mod unified_stages;
mod validation;
mod video;
#[cfg(unix)]
mod view_command;
mod world_shared_scenes;
mod world_vs_gbuffer;
