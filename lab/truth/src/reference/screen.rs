//! The screen reference (docs/definitions.md, "Image error"): the reflection colour, computed by Monte Carlo
//! integration over each pixel's Phong lobe (docs/definitions.md, "Surfaces"; docs/numerics.md, "Gloss"), with its
//! standard error. Rays hit what they hit by the oracle.
//!
//! Each sample reflects the camera ray through a random place within the pixel. A G-buffer has one position and one
//! normal for the whole pixel. The reflected ray therefore leaves from the position of the pixel's centre, and the
//! normal of the centre is used.
//!
//! With several bounces (docs/definitions.md, "Bounces") a sample goes on from the pixel that it hits: from the pixel's
//! centre, along one direction of the lobe around the mirror direction of the incoming ray.
//!
//! Samples are independent. Stratified samples would lower the error, but the estimate of the error would then be too
//! large by an unknown factor. That estimate is what makes the reference trustworthy.

use super::hierarchy::Hierarchy;
use super::lobe::lobe_direction;
use super::ray::{MissReason, Outcome};
use super::surface_color::{ReflectedRay, SurfaceColors};
use glam::{DMat4, DVec3, Vec3};
use rayon::prelude::*;
use ssct_ground::math::random::Stream;
use ssct_ground::math::{OracleVersion, phong};
use ssct_scenes::GBufferData;
use std::convert::Infallible;

/// Least number of rays for a pixel of a mirror.
pub const MIRROR_SAMPLES_MIN: u32 = 16;

/// Number of rows that are rendered between two calls of `go_on`. Threads wait for each other after each such band.
const BAND_ROWS: u32 = 16;

/// Parameters of the sampling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// Rays per pixel; with fewer than two, the error is unknown. A mirror takes at least [`MIRROR_SAMPLES_MIN`].
    pub samples: u32,
    /// Seed of the random numbers; another seed gives an independent image.
    pub seed: u64,
    /// The version of the oracle that decides what rays hit.
    pub oracle: OracleVersion,
    /// Number of times that light is reflected, ≥ 1; the surface that the last bounce meets does not reflect.
    pub bounces: u32,
}

/// The reflection colour, before fade, reflectivity and composite, with its standard error.
#[derive(Debug, Clone, PartialEq)]
pub struct ScreenReference {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Mean colour, linear, rows from the top; black outside the mask, and where no ray hit anything.
    pub color: Vec<Vec3>,
    /// Standard error of the mean, per channel; 0 outside the mask, infinite if a lobe has a single sample.
    pub standard_error: Vec<Vec3>,
    /// Root mean square of [`Self::standard_error`] over the three channels of the mask's pixels: the expected RMSE of
    /// the reference itself. 0 if the mask is empty.
    pub overall_standard_error: f64,
}

impl ScreenReference {
    /// Renders the pixels of a mask (usually [`GBufferData::reflecting`]); other pixels stay black. The image depends
    /// only on G-buffer, mask and sampling, not on threads.
    ///
    /// # Panics
    /// If the mask differs in size from the G-buffer.
    pub fn render(gbuffer: &GBufferData, mask: &[bool], sampling: Sampling) -> Self {
        match Self::render_while(gbuffer, mask, sampling, &mut || Ok::<(), Infallible>(())) {
            Ok(image) => image,
            Err(impossible) => match impossible {},
        }
    }

    /// Renders as [`Self::render`] does, and calls `go_on` before every 16 rows; its error ends the rendering.
    ///
    /// # Errors
    /// The errors of `go_on`.
    ///
    /// # Panics
    /// If the mask differs in size from the G-buffer.
    pub fn render_while<E>(
        gbuffer: &GBufferData,
        mask: &[bool],
        sampling: Sampling,
        go_on: &mut dyn FnMut() -> Result<(), E>,
    ) -> Result<Self, E> {
        assert_eq!(mask.len(), gbuffer.depth.len(), "the mask must have the G-buffer's size");
        let hierarchy = Hierarchy::new(gbuffer).of_version(sampling.oracle);
        let view_to_world = gbuffer.camera.world_to_view.as_dmat4().inverse();
        let pixels = Pixels { hierarchy: &hierarchy, colors: SurfaceColors::new(gbuffer), view_to_world, sampling };
        let estimate_row = |y| -> Vec<Estimate> {
            let pixel = |x| mask[gbuffer.index(x, y)].then(|| pixels.estimate(x, y));
            (0..gbuffer.width).map(|x| pixel(x).unwrap_or_default()).collect()
        };
        let mut estimates = Vec::with_capacity(mask.len());
        for first_row in (0..gbuffer.height).step_by(BAND_ROWS as usize) {
            go_on()?;
            let band = first_row..gbuffer.height.min(first_row.saturating_add(BAND_ROWS));
            let rows: Vec<Vec<Estimate>> = band.into_par_iter().map(estimate_row).collect();
            estimates.extend(rows.into_iter().flatten());
        }
        let squared_errors: f64 = estimates.iter().map(|e| e.standard_error.length_squared()).sum();
        let value_count = 3 * mask.iter().filter(|masked| **masked).count();
        Ok(Self {
            width: gbuffer.width,
            height: gbuffer.height,
            color: estimates.iter().map(|e| e.mean.as_vec3()).collect(),
            standard_error: estimates.iter().map(|e| e.standard_error.as_vec3()).collect(),
            overall_standard_error: (squared_errors / value_count.max(1) as f64).sqrt(),
        })
    }
}

/// A mean linear colour and the standard error of each channel.
#[derive(Debug, Clone, Copy, Default)]
struct Estimate {
    mean: DVec3,
    standard_error: DVec3,
}

/// Data that all pixels of an image share.
struct Pixels<'a> {
    hierarchy: &'a Hierarchy<'a>,
    colors: SurfaceColors<'a>,
    view_to_world: DMat4,
    sampling: Sampling,
}

impl Pixels<'_> {
    /// Returns the reflection of pixel (x, y), as the mean over samples. Sample i uses the random numbers 4 i to 4 i +
    /// 3 of the pixel: two for the direction in the lobe, and two for the place within the pixel.
    fn estimate(&self, x: u32, y: u32) -> Estimate {
        let (rays, Sampling { samples, seed, .. }) = (self.hierarchy.rays(), self.sampling);
        let index = rays.gbuffer.index(x, y);
        let Some(normal) = rays.normal(x, y) else { return Estimate::default() };
        let roughness = f64::from(rays.gbuffer.roughness[index]);
        let exponent = phong::exponent(roughness);
        let stream = Stream::new(seed, index as u64);
        let random_pair = |first: u64| [stream.uniform(first), stream.uniform(first + 1)];
        // Further bounces use random numbers with indices from 2⁴⁰ on; the first bounce uses indices below 2³⁴.
        let color =
            |i: u64, direction| self.ray_color([x, y], direction, &|bounce| random_pair((bounce << 40) + 2 * i));
        let sample = |i| {
            let [u, v] = random_pair(4 * i + 2);
            let mirror = rays.camera_ray(f64::from(x) + u, f64::from(y) + v).reflect(normal);
            color(i, lobe_direction(mirror, exponent, random_pair(4 * i)))
        };
        let samples = if roughness <= 0.0 { samples.max(MIRROR_SAMPLES_MIN) } else { samples };
        mean_and_error((0..u64::from(samples)).map(sample))
    }

    /// Returns the colour that a ray from the pixel `from` brings, including further bounces; black if the ray hits
    /// nothing or runs below the surface. `random_pair` returns two random numbers for each further bounce.
    fn ray_color(&self, from: [u32; 2], direction: DVec3, random_pair: &dyn Fn(u64) -> [f64; 2]) -> DVec3 {
        let rays = self.hierarchy.rays();
        // The throughput is the share of the light at the current hit that reaches the first pixel.
        let (mut from, mut direction, mut throughput, mut radiance) = (from, direction, 1.0, DVec3::ZERO);
        for bounce in 1..=u64::from(self.sampling.bounces) {
            let Some(([i, j], color)) = self.hit(from, direction) else { break };
            radiance += throughput * color;
            let index = rays.gbuffer.index(i, j);
            let normal = rays.normal(i, j).filter(|_| rays.gbuffer.reflects(index));
            let (Some(normal), true) = (normal, bounce < u64::from(self.sampling.bounces)) else { break };
            throughput *= f64::from(rays.gbuffer.reflectivity[index]);
            let exponent = phong::exponent(f64::from(rays.gbuffer.roughness[index]));
            let mirror = direction.normalize().reflect(normal);
            (from, direction) = ([i, j], lobe_direction(mirror, exponent, random_pair(bounce)));
        }
        radiance
    }

    /// Returns the pixel in which a ray from pixel (x, y) ends, and the colour there. `None` if the screen shows
    /// neither a hit nor sky beyond the far plane, or if the ray leads below the surface.
    fn hit(&self, [x, y]: [u32; 2], direction: DVec3) -> Option<([u32; 2], DVec3)> {
        let rays = self.hierarchy.rays();
        let normal = rays.normal(x, y).filter(|normal| direction.dot(*normal) > 0.0)?;
        let (pixel, position) = match self.hierarchy.trace_direction(x, y, direction).outcome {
            Outcome::Hit { pixel, position } => (pixel, position),
            Outcome::Miss { reason: MissReason::Far, .. } => {
                let end = rays.segment(x, y, direction)?.point_at(1.0);
                let end_pixel = [(end.x, rays.gbuffer.width), (end.y, rays.gbuffer.height)]
                    .map(|(v, side)| (v.max(0.0) as u32).min(side - 1));
                let is_sky = rays.gbuffer.depth[rays.gbuffer.index(end_pixel[0], end_pixel[1])] <= 0.0;
                is_sky.then_some((end_pixel, end))?
            }
            Outcome::Miss { .. } => return None,
        };
        let world_direction = self.view_to_world.transform_vector3(direction);
        let index = rays.gbuffer.index(pixel[0], pixel[1]);
        let ray = rays.position(x, y).map(|point| ReflectedRay { point, normal, direction });
        Some((pixel, self.colors.shown(index, [position.x, position.y], world_direction, ray)))
    }
}

/// Returns the mean of the colours and its standard error, by Welford's running mean and variance (Welford 1962), which
/// avoid cancellation. The error is infinite for fewer than two colours.
fn mean_and_error(colors: impl Iterator<Item = DVec3>) -> Estimate {
    let (mut count, mut mean, mut squared_deviations) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for color in colors {
        count += 1.0;
        let deviation = color - mean;
        mean += deviation / count;
        squared_deviations += deviation * (color - mean);
    }
    let standard_error =
        if count < 2.0 { DVec3::INFINITY } else { (squared_deviations / (count - 1.0) / count).map(f64::sqrt) };
    Estimate { mean, standard_error }
}

#[cfg(test)]
mod tests;
