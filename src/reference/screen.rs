//! The screen reference (DEFINITIONS, "Image error"): the reflection colour by Monte Carlo over each
//! pixel's Phong lobe (DEFINITIONS, "Surfaces"; NUMERICS, "Gloss"), each ray traced as the oracle
//! traces it, with the standard error beside it.
//!
//! Samples are independent. Stratifying them would lower the error and make its estimate, which is
//! what gives the reference its worth, an overestimate by an unknown factor.

use super::hierarchy::Hierarchy;
use super::lobe::lobe_direction;
use super::random::Stream;
use crate::math::{OracleVersion, phong};
use crate::scene::GBufferData;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// How to sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// Rays a pixel with ϱ > 0; with fewer than two the error is unknown. A mirror takes one.
    pub samples: u32,
    /// Another seed gives an independent image.
    pub seed: u64,
    /// What rays hit.
    pub oracle: OracleVersion,
}

/// The reflection colour, before fade, reflectivity and composite, with its error.
#[derive(Debug, Clone, PartialEq)]
pub struct ScreenReference {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Mean colour, linear, rows from the top; black outside the mask and where nothing was hit.
    pub color: Vec<Vec3>,
    /// Standard error of each channel of the mean; 0 for mirrors and outside the mask, infinite for
    /// a single sample of a lobe.
    pub standard_error: Vec<Vec3>,
    /// Root mean square of [`Self::standard_error`] over the mask's pixels and three channels: the
    /// RMSE that the reference itself is expected to have. 0 for an empty mask.
    pub overall_standard_error: f64,
}

impl ScreenReference {
    /// Renders the pixels of a mask (usually [`GBufferData::reflecting`]); the others stay black.
    /// `progress` is called after each row, from any thread. The image depends on the seed alone.
    ///
    /// # Panics
    /// If the mask has another size than the G-buffer.
    pub fn render(gbuffer: &GBufferData, mask: &[bool], sampling: Sampling, progress: &(dyn Fn() + Sync)) -> Self {
        assert_eq!(mask.len(), gbuffer.depth.len(), "a mask of the G-buffer's size");
        let hierarchy = Hierarchy::new(gbuffer).of_version(sampling.oracle);
        let rows: Vec<Vec<Estimate>> = (0..gbuffer.height)
            .into_par_iter()
            .map(|y| {
                let pixel = |x| mask[gbuffer.index(x, y)].then(|| estimate(&hierarchy, x, y, sampling));
                let row = (0..gbuffer.width).map(|x| pixel(x).unwrap_or_default()).collect();
                progress();
                row
            })
            .collect();
        let estimates = rows.concat();
        let squares: f64 = estimates.iter().map(|e| e.standard_error.length_squared()).sum();
        let values = 3 * mask.iter().filter(|m| **m).count();
        Self {
            width: gbuffer.width,
            height: gbuffer.height,
            color: estimates.iter().map(|e| e.mean.as_vec3()).collect(),
            standard_error: estimates.iter().map(|e| e.standard_error.as_vec3()).collect(),
            overall_standard_error: (squares / values.max(1) as f64).sqrt(),
        }
    }
}

/// A mean of colours and its standard error.
#[derive(Debug, Clone, Copy, Default)]
struct Estimate {
    mean: DVec3,
    standard_error: DVec3,
}

fn estimate(hierarchy: &Hierarchy, x: u32, y: u32, sampling: Sampling) -> Estimate {
    let rays = hierarchy.rays();
    let gbuffer = rays.gbuffer;
    let index = gbuffer.index(x, y);
    let (Some(mirror), Some(normal)) = (rays.mirror(x, y), rays.normal(x, y)) else { return Estimate::default() };
    let seen = |direction: DVec3| {
        // Below the surface there is nothing to see, and it counts.
        let hit = (direction.dot(normal) > 0.0).then(|| hierarchy.trace_direction(x, y, direction).position());
        hit.flatten().map_or(DVec3::ZERO, |p| bilinear(gbuffer, p.x, p.y))
    };
    let roughness = f64::from(gbuffer.roughness[index]);
    if roughness <= 0.0 {
        return Estimate { mean: seen(mirror), standard_error: DVec3::ZERO };
    }
    let exponent = phong::exponent(roughness);
    let stream = Stream::new(sampling.seed, index as u64);
    let colors = (0..u64::from(sampling.samples))
        .map(|i| seen(lobe_direction(mirror, exponent, [stream.uniform(2 * i), stream.uniform(2 * i + 1)])));
    mean_and_error(colors)
}

/// Welford's running mean and variance (Welford 1962), which do not cancel.
fn mean_and_error(colors: impl Iterator<Item = DVec3>) -> Estimate {
    let (mut n, mut mean, mut squares) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for color in colors {
        n += 1.0;
        let off = color - mean;
        mean += off / n;
        squares += off * (color - mean);
    }
    let standard_error = if n < 2.0 {
        DVec3::INFINITY
    } else {
        let variance = squares / (n - 1.0) / n;
        DVec3::new(variance.x.sqrt(), variance.y.sqrt(), variance.z.sqrt())
    };
    Estimate { mean, standard_error }
}

/// The lit colour at a position in pixels, bilinear between pixel centres, clamped at the border.
pub fn bilinear(gbuffer: &GBufferData, x: f64, y: f64) -> DVec3 {
    let axis = |v: f64, side: u32| {
        let v = (v - 0.5).clamp(0.0, f64::from(side - 1));
        let low = v.floor() as u32;
        (low, (low + 1).min(side - 1), v - v.floor())
    };
    let (left, right, fx) = axis(x, gbuffer.width);
    let (top, bottom, fy) = axis(y, gbuffer.height);
    let at = |x, y| gbuffer.color[gbuffer.index(x, y)].as_dvec3();
    at(left, top).lerp(at(right, top), fx).lerp(at(left, bottom).lerp(at(right, bottom), fx), fy)
}

#[cfg(test)]
mod tests;
