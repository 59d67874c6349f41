//! The two presets of the thesis's methods: which number stands in print, which is the author's.
//! Sources: thesis §4.2, and the facts on the author's own program (named "author" below).

use super::Setup;
use crate::gpu::shader::ThesisBlock;
use crate::passes::color_chain::ChainFilter;
use crate::scene::Camera;

/// Whose constants a published method uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// What the thesis prints, and the author's value where it prints nothing.
    #[default]
    Published,
    /// The author's own program.
    Author,
}

/// A bound for loops that the thesis leaves unbounded (DEFINITIONS, "Time").
pub const UNBOUNDED: i32 = 1024;

/// Numbers that replace a preset's, for studies of run time against error; `None` keeps them.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Tuning {
    /// Bound of the Hi-Z traversal's iterations, ≥ 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub iterations: Option<u32>,
    /// Hi-Z level that the traversal begins at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_level: Option<u32>,
    /// Circles of the cone, ≥ 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cone_samples: Option<u32>,
    /// First step of the linear march and of the poster's, in screen space (1 is the screen's side), > 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub march_stride: Option<f32>,
    /// Pixels that Schmidt's marches take at once, ≥ 1; none: 1, as listing 4 prints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pixel_step: Option<u32>,
    /// Whether `ssr-fast` blurs by the viewer's distance (Schmidt's listing 5, `toggleBlur`).
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub distance_blur: bool,
}

/// Settings of the thesis's methods for the study of run time against error: both presets, around
/// them one parameter at a time, and half resolution.
pub fn settings(base: Setup) -> Vec<Setup> {
    let published = Setup { preset: Preset::Published, ..base };
    let author = Setup { preset: Preset::Author, ..base };
    let tuned = |setup: Setup, tuning| Setup { tuning, ..setup };
    let none = Tuning::default();
    vec![
        published,
        Setup { divisor: 2, ..published },
        Setup { chain_filter: ChainFilter::Gaussian, ..published },
        tuned(published, Tuning { cone_samples: Some(3), ..none }),
        tuned(published, Tuning { cone_samples: Some(15), ..none }),
        tuned(published, Tuning { start_level: Some(2), ..none }),
        author,
        tuned(author, Tuning { iterations: Some(16), ..none }),
        tuned(author, Tuning { iterations: Some(32), ..none }),
        tuned(author, Tuning { iterations: Some(256), ..none }),
    ]
}

/// Which of the thesis's methods, with whose numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variant {
    /// Whose constants.
    pub preset: Preset,
    /// What replaces them.
    pub tuning: Tuning,
    /// Whether rays towards the camera are marched (`ssct`) or fade out (`hzct`).
    pub fallback: bool,
    /// Whether reflections fade at all.
    pub fade: bool,
}

/// The parameters of a variant for a camera and a size in pixels. `levels` is the length of the
/// Hi-Z chain.
pub fn parameters(variant: &Variant, camera: &Camera, extent: [u32; 2], levels: u32) -> ThesisBlock {
    let tuning = variant.tuning;
    let projection = camera.view_to_clip().as_dmat4();
    let shared = ThesisBlock {
        projection: projection.as_mat4().to_cols_array_2d(),
        inverse_projection: projection.inverse().as_mat4().to_cols_array_2d(),
        resolution: extent.map(|v| v as f32),
        near_plane: camera.lens.near_m,
        far_plane: camera.lens.far_m,
        max_level: levels as i32 - 1,
        // Not printed: the author's values, in both presets.
        reflection_offset: camera.lens.near_m,
        view_direction_epsilon: 1e-5,
        cross_offset: 0.5,
        linear_march_stride: 0.001,
        uniform_march_count: 200,
        uniform_stride_min: 0.001,
        uniform_stride_max: 0.1,
        fade_towards_camera: if variant.fallback { 0.0 } else { 10.0 },
        // Printed, and the same in the author's program.
        linear_march_count: 100,
        linear_march_increase: 1.5,
        binary_search_decrease: 0.5,
        cone_samples: 7,
        fade_start: 0.8,
        fade_end: 1.0,
        fade: i32::from(variant.fade),
        ..ThesisBlock::default()
    };
    let block = match variant.preset {
        Preset::Published => ThesisBlock {
            start_level: 0,            // Alg. 4, line 2
            iterations: UNBOUNDED,     // Alg. 4, line 3: while
            binary_search_count: 32,   // listing in §4.2.2
            depth_delta_epsilon: 0.01, // the same
            binary_search_first: 1.0,  // the same: dir * stride
            cone_lengthened: 0,        // Alg. 5, line 2
            uniform_march_back: 0.0,   // §4.3.1: no refinement; first listing of §4.2.2
            ..shared
        },
        Preset::Author => ThesisBlock {
            start_level: 2.min(levels as i32 - 1),
            iterations: 64,
            binary_search_count: 30,
            depth_delta_epsilon: 2e-4,
            // A quarter of the last step; the listing's stride has grown since that step.
            binary_search_first: 0.25 / 1.5,
            cone_lengthened: 1,
            uniform_march_back: 0.5,
            ..shared
        },
    };
    ThesisBlock {
        iterations: tuning.iterations.map_or(block.iterations, |n| n as i32),
        start_level: tuning.start_level.map_or(block.start_level, |l| l.min(levels - 1) as i32),
        cone_samples: tuning.cone_samples.map_or(block.cone_samples, |n| n as i32),
        linear_march_stride: tuning.march_stride.unwrap_or(block.linear_march_stride),
        ..block
    }
}
