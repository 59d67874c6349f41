//! The world reference of docs/definitions.md, "Image error": the glossy reflection of each pixel as the mean over rays
//! of its Phong lobe, traced against the triangles of the whole scene, with its standard error. It includes
//! what is off screen or hidden, which no screen-space method can see.
//!
//! Only the first bounce is traced: what a ray hits is lit directly, as in the G-buffer, and does not reflect
//! itself. Each sample depends only on the seed, its pixel and its number, and a pixel's samples are summed in
//! the order of their numbers. A result therefore does not depend on threads or on interruptions.

use super::first_hits::{FirstHits, Receiver};
use super::lobe::lobe_direction;
use super::surface::{World, sky_color};
use super::world_state::WorldState;
use crate::error::Result;
use crate::math::phong;
use crate::math::random::Stream;
use crate::scene::bvh::WorldRay;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// The distance, in metres, from which hits of a reflected ray count (docs/definitions.md, "World agreement").
pub const RAY_START_M: f64 = 1e-4;

/// The radiance of a ray that hits no triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Escape {
    /// Black, like a miss in screen space.
    #[default]
    Black,
    /// The environment, for methods that fall back to it.
    Environment,
}

/// A world reference before sampling: a world and the first hits in it.
pub struct WorldReference<'a> {
    /// The world that rays are traced in.
    pub world: &'a World<'a>,
    /// The points that reflect.
    pub first_hits: &'a FirstHits,
    /// The radiance of rays that hit nothing.
    pub escape: Escape,
    /// A different seed gives a different, independent result.
    pub seed: u64,
}

/// The condition under which [`WorldReference::run`] stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SamplingTarget {
    /// The run stops if [`WorldState::overall_standard_error`] is at most this, in linear colour.
    pub standard_error: f64,
    /// The least samples per pixel, so that the estimate of the error is reliable.
    pub samples_min: u32,
    /// The most samples per pixel.
    pub samples_max: u32,
    /// Samples per pixel between two checks of the error, ≥ 1.
    pub samples_per_pass: u32,
}

impl Default for SamplingTarget {
    /// A standard error of 0.003, a tenth of the error of a good method, within 1024 samples.
    fn default() -> Self {
        Self { standard_error: 0.003, samples_min: 32, samples_max: 1024, samples_per_pass: 16 }
    }
}

/// A reference image; rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldImage {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Reflection colour, linear, before reflectivity; black where nothing reflects.
    pub reflection: Vec<Vec3>,
    /// Standard error of the reflection colour, per channel; 0 for mirrors, infinite with fewer than two
    /// samples.
    pub standard_error: Vec<Vec3>,
    /// Number of samples: 1 for mirrors, 0 where nothing reflects.
    pub samples: Vec<u32>,
    /// Lit colour of the first hits.
    pub lit: Vec<Vec3>,
    /// Lit colour + reflectivity · reflection; there is no fade.
    pub composite: Vec<Vec3>,
}

impl WorldReference<'_> {
    /// A state without samples.
    pub fn start(&self) -> WorldState {
        let mirrors = self.first_hits.receivers.iter().map(|r| r.map(|r| r.roughness <= 0.0));
        WorldState::new(self.fingerprint(), [self.first_hits.width, self.first_hits.height], mirrors)
    }

    /// Adds samples to every glossy pixel, and traces the single ray of every mirror if it is still missing.
    pub fn add(&self, state: &mut WorldState, samples: u32) {
        let first = state.samples;
        state.pixels.par_iter_mut().zip(&self.first_hits.receivers).enumerate().with_min_len(64).for_each(
            |(index, (sums, receiver))| {
                let Some(receiver) = receiver else { return };
                let exponent = phong::exponent(receiver.roughness);
                let wanted = if exponent.is_infinite() { 0..1 } else { 0..first.saturating_add(samples) };
                let stream = Stream::new(self.seed, index as u64);
                for sample in first.min(wanted.end)..wanted.end {
                    let numbers = [0, 1].map(|k| stream.uniform(2 * u64::from(sample) + k));
                    sums.add(self.sample(receiver, exponent, numbers));
                }
            },
        );
        state.samples = first.saturating_add(samples);
    }

    /// Adds passes until the target is met. `progress` is called after each pass and may save the state; an
    /// error that it returns ends the run.
    pub fn run(
        &self,
        state: &mut WorldState,
        target: &SamplingTarget,
        progress: &mut dyn FnMut(&WorldState) -> Result<()>,
    ) -> Result<()> {
        while state.samples < target.samples_max
            && (state.samples < target.samples_min || state.overall_standard_error() > target.standard_error)
        {
            let pass = target.samples_per_pass.max(1).min(target.samples_max - state.samples);
            self.add(state, pass);
            progress(state)?;
            if state.glossy_pixels() == 0 {
                break;
            }
        }
        Ok(())
    }

    /// The image of a state.
    pub fn image(&self, state: &WorldState) -> WorldImage {
        let reflection: Vec<Vec3> = state.means().map(DVec3::as_vec3).collect();
        let strength = self.first_hits.receivers.iter().map(|r| r.map_or(0.0, |r| r.reflectivity as f32));
        let composite = self.first_hits.lit.iter().zip(&reflection).zip(strength).map(|((lit, r), s)| *lit + s * *r);
        WorldImage {
            width: self.first_hits.width,
            height: self.first_hits.height,
            composite: composite.collect(),
            standard_error: state.standard_errors().map(DVec3::as_vec3).collect(),
            samples: state.sample_counts().collect(),
            lit: self.first_hits.lit.clone(),
            reflection,
        }
    }

    /// The radiance along one ray of the lobe.
    fn sample(&self, receiver: &Receiver, exponent: f64, u: [f64; 2]) -> DVec3 {
        let direction = lobe_direction(receiver.mirror(), exponent, u);
        if !receiver.is_above(direction) {
            return DVec3::ZERO;
        }
        let ray = WorldRay { origin: receiver.position, direction, t_min: RAY_START_M, t_max: f64::INFINITY };
        match self.world.closest(&ray) {
            Some(hit) => self.world.color(&ray, &self.world.point(&ray, &hit)),
            None if self.escape == Escape::Environment => sky_color(direction),
            None => DVec3::ZERO,
        }
    }
}

#[cfg(test)]
#[path = "world_tests.rs"]
mod tests;
