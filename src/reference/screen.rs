//! The screen reference (docs/definitions.md, "Image error"): the reflection colour by Monte Carlo integration over
//! each pixel's Phong lobe (docs/definitions.md, "Surfaces"; docs/numerics.md, "Gloss"), with its standard error. Rays
//! are traced as the oracle traces them.
//!
//! Samples are independent. Stratified samples would lower the error, but its estimate, which makes the
//! reference trustworthy, would become too large by an unknown factor.

use super::hierarchy::Hierarchy;
use super::lobe::lobe_direction;
use crate::math::random::Stream;
use crate::math::{OracleVersion, phong};
use crate::scene::GBufferData;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Parameters of the sampling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// Rays per pixel with ϱ > 0; if there are fewer than two, the error is unknown. A mirror always takes one
    /// ray.
    pub samples: u32,
    /// Another seed gives an independent image.
    pub seed: u64,
    /// The version of the oracle that decides what rays hit.
    pub oracle: OracleVersion,
}

/// The reflection colour, before fade, reflectivity and composite, and its error.
#[derive(Debug, Clone, PartialEq)]
pub struct ScreenReference {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Mean colour, linear, rows from the top; black outside the mask and where nothing was hit.
    pub color: Vec<Vec3>,
    /// Standard error of the mean, per channel; 0 for mirrors and outside the mask, infinite if a lobe has a
    /// single sample.
    pub standard_error: Vec<Vec3>,
    /// Root mean square of [`Self::standard_error`] over the three channels of the mask's pixels: the RMSE that
    /// the reference itself is expected to have. 0 if the mask is empty.
    pub overall_standard_error: f64,
}

impl ScreenReference {
    /// Renders the pixels of a mask (usually [`GBufferData::reflecting`]); the others stay black. `progress` is
    /// called after each row, from any thread. The image depends only on the G-buffer, the mask and the
    /// sampling, not on threads.
    ///
    /// # Panics
    /// If the mask differs in size from the G-buffer.
    pub fn render(gbuffer: &GBufferData, mask: &[bool], sampling: Sampling, progress: &(dyn Fn() + Sync)) -> Self {
        assert_eq!(mask.len(), gbuffer.depth.len(), "the mask must have the G-buffer's size");
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

/// A mean colour and its standard error.
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
        // A direction below the surface carries no light, but counts as a sample.
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

/// Welford's running mean and variance (Welford 1962), which avoid cancellation.
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

/// The lit colour at continuous pixel coordinates, bilinear between pixel centres and clamped at the border.
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
