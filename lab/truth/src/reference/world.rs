//! The world reference of docs/definitions.md, "Image error": the glossy reflection of each pixel as the mean over rays
//! of its Phong lobe, with its standard error. The rays are traced against the triangles of the whole scene. The
//! reflection therefore includes surfaces that are off screen or hidden, which no screen-space method can see.
//!
//! Each sample reflects the camera ray through a random place within the pixel. The ray is reflected at the pixel's own
//! point with the pixel's own normal, as in the screen reference.
//!
//! A surface that a ray hits is lit directly, as in the G-buffer. With several bounces (docs/definitions.md, "Bounces")
//! the surface reflects, too: the sample goes on along one direction of its lobe. Each sample depends only on the seed,
//! its pixel and its number, and a pixel's samples are summed in the order of their numbers, in groups that are always
//! the same ([`super::partial_sums`]). A result therefore does not depend on threads, on interruptions, or on how
//! samples were divided among machines.

pub mod state;

use super::first_hits::{FirstHits, PrimaryRays, Receiver};
use super::lobe::lobe_direction;
use super::screen::MIRROR_SAMPLES_MIN;
use super::surface::{SurfacePoint, World, sky_color};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use ssct_geometry::bvh::WorldRay;
use ssct_ground::math::phong;
use ssct_ground::math::random::Stream;
use ssct_ground::{Error, Result};
use ssct_scenes::Camera;
use state::{Kind, WorldState};

/// The least distance from the start of a reflected ray at which a hit counts, in metres (docs/definitions.md, "World
/// agreement").
pub const RAY_START_M: f64 = 1e-4;

/// The radiance of a ray that hits no triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EscapeRadiance {
    /// The environment.
    #[default]
    Environment,
    /// Black, for renderers that do not know the environment.
    Black,
}

/// A world reference before sampling: a world and the first hits in it.
pub struct WorldReference<'a> {
    /// The world that rays are traced in.
    pub world: &'a World<'a>,
    /// The points that reflect.
    pub first_hits: &'a FirstHits,
    /// The radiance of rays that hit nothing.
    pub escape: EscapeRadiance,
    /// The camera's rays, if samples reflect rays through random places of the pixel; `None` if all samples reflect the
    /// ray through the centre.
    pub footprint: Option<PrimaryRays>,
    /// Seed of the random numbers; another seed gives an independent result.
    pub seed: u64,
    /// Number of times that light is reflected, ≥ 1; the surface that the last bounce meets does not reflect.
    pub bounces: u32,
}

/// The condition under which [`WorldReference::run`] stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SamplingTarget {
    /// Greatest [`WorldState::overall_standard_error`] at which the run stops, in linear colour.
    pub standard_error: f64,
    /// Least number of samples per pixel, so that the estimate of the error is reliable.
    pub samples_min: u32,
    /// Greatest number of samples per pixel.
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
    /// Standard error of the reflection colour, per channel; 0 for mirrors that take one sample, otherwise infinite
    /// with fewer than two samples.
    pub standard_error: Vec<Vec3>,
    /// Number of samples; 0 where nothing reflects.
    pub samples: Vec<u32>,
    /// Lit colour of the first hits.
    pub lit: Vec<Vec3>,
    /// Lit colour + reflectivity · reflection; there is no fade.
    pub composite: Vec<Vec3>,
}

/// One ray of a world reference, with its radiance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorldSample {
    /// Linear radiance of the ray.
    pub radiance: DVec3,
    /// Part of the radiance that further bounces bring; the rest is the lit colour at the ray's end or the environment.
    pub bounced: DVec3,
    /// Unit direction of the ray in the world.
    pub direction: DVec3,
    /// Where the ray ends, in metres; `None` if it escapes, or if it leads below the surface and brings no light.
    pub end: Option<DVec3>,
}

impl<'a> WorldReference<'a> {
    /// Makes the reference of docs/definitions.md: rays through random places of the pixels, the environment for rays
    /// that escape, and one bounce.
    pub fn new(world: &'a World<'a>, first_hits: &'a FirstHits, camera: &Camera, seed: u64) -> Self {
        let footprint = Some(PrimaryRays::new(camera, [first_hits.width, first_hits.height]));
        Self { world, first_hits, escape: EscapeRadiance::Environment, footprint, seed, bounces: 1 }
    }

    /// Makes a reference whose samples all reflect the ray through the pixel's centre, and whose escaping rays are
    /// black, so that another renderer can trace the same rays.
    pub fn of_centres(world: &'a World<'a>, first_hits: &'a FirstHits, seed: u64) -> Self {
        Self { world, first_hits, escape: EscapeRadiance::Black, footprint: None, seed, bounces: 1 }
    }

    /// Returns this reference with the given number of bounces, ≥ 1.
    pub fn with_bounces(self, bounces: u32) -> Self {
        Self { bounces, ..self }
    }

    /// Returns a state without samples.
    pub fn start(&self) -> WorldState {
        self.start_at(0)
    }

    /// Returns a state without samples, whose first sample will have the number `first`, a multiple of
    /// [`LEAF`](super::partial_sums::LEAF). The state is for a part of all samples, which [`super::world_part`] merges
    /// with the other parts.
    pub fn start_at(&self, first: u32) -> WorldState {
        // The samples that a pixel takes. A mirror without a footprint takes a single one, but with several bounces a
        // later bounce may meet a lobe, which needs many samples.
        let kind = |receiver: &Option<Receiver>| match (receiver, self.footprint) {
            (None, _) => Kind::None,
            (Some(receiver), None) if receiver.roughness <= 0.0 && self.bounces == 1 => Kind::Single,
            (Some(receiver), _) if receiver.roughness <= 0.0 => Kind::Sampled { least: MIRROR_SAMPLES_MIN },
            (Some(_), _) => Kind::Sampled { least: 0 },
        };
        let kinds = self.first_hits.receivers.iter().map(kind).collect();
        WorldState::new(self.fingerprint(), [self.first_hits.width, self.first_hits.height], first, kinds)
    }

    /// Adds `samples` samples to every pixel with a lobe. A mirror takes its single ray, or its least number of rays,
    /// with the first samples.
    pub fn add(&self, state: &mut WorldState, samples: u32) {
        let end_sample = state.samples().saturating_add(samples);
        let mut no_values = vec![(); state.sums.pixels()];
        while let Some(stop) = state.sums.next_stop(end_sample) {
            self.add_and_visit(state, stop, &mut no_values, |(), _| ());
        }
    }

    /// Adds the samples before number `stop`, which must be the next stop of the state's sums. `values` has a value of
    /// the caller for each pixel. `visit` is called with this value and each sample of the pixel, in the order of the
    /// samples' numbers.
    pub(super) fn add_and_visit<T: Send>(
        &self,
        state: &mut WorldState,
        stop: u32,
        values: &mut [T],
        visit: impl Fn(&mut T, &WorldSample) + Sync,
    ) {
        let first = state.samples();
        let WorldState { sums, kinds, .. } = state;
        let receivers = self.first_hits.receivers.par_iter().zip(kinds.par_iter());
        // For each pixel: its index, its sums, the caller's value, its receiver and the kind of its samples.
        sums.open().par_iter_mut().zip(values).zip(receivers).enumerate().with_min_len(64).for_each(
            |(index, ((sums, value), (receiver, kind)))| {
                let Some(receiver) = receiver else { return };
                let stream = Stream::new(self.seed, index as u64);
                for number in kind.samples(first)..kind.samples(stop) {
                    let sample = self.sample(index, receiver, u64::from(number), &stream);
                    sums.add(sample.radiance);
                    visit(value, &sample);
                }
            },
        );
        state.sums.close(stop);
    }

    /// Adds samples, pass after pass, until the target is met. `progress` is called after each pass and may save the
    /// state; an error that it returns ends the run.
    pub fn run<E: From<Error>>(
        &self,
        state: &mut WorldState,
        target: &SamplingTarget,
        progress: &mut dyn FnMut(&WorldState) -> Result<(), E>,
    ) -> Result<(), E> {
        while state.samples() < target.samples_max
            && (state.samples() < target.samples_min || state.overall_standard_error() > target.standard_error)
        {
            let pass = target.samples_per_pass.max(1).min(target.samples_max - state.samples());
            self.add(state, pass);
            progress(state)?;
            if state.sampled_pixels() == 0 {
                break;
            }
        }
        Ok(())
    }

    /// Returns the image of the samples that a state has so far.
    pub fn image(&self, state: &WorldState) -> WorldImage {
        let reflection: Vec<Vec3> = state.means().map(DVec3::as_vec3).collect();
        let reflectivities = self
            .first_hits
            .receivers
            .iter()
            .map(|receiver| receiver.map_or(0.0, |receiver| receiver.reflectivity as f32));
        let pixels = self.first_hits.lit.iter().zip(&reflection).zip(reflectivities);
        let composite = pixels.map(|((lit, reflection), reflectivity)| *lit + reflectivity * *reflection);
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

    /// Takes sample `number` of the pixel `index`: traces one ray of the receiver's lobe, and its further bounces.
    /// `stream` has the random numbers of the pixel.
    fn sample(&self, index: usize, receiver: &Receiver, number: u64, stream: &Stream) -> WorldSample {
        let random_pair = |first_ray: u64| [stream.uniform(first_ray), stream.uniform(first_ray + 1)];
        // The receiver with the camera ray of this sample, and the two random numbers for the direction in the lobe.
        let (receiver, lobe_numbers) = match &self.footprint {
            None => (*receiver, random_pair(2 * number)),
            Some(rays) => {
                let (ray, _) = rays.ray_within(index, random_pair(4 * number + 2));
                (Receiver { incoming: ray.direction, ..*receiver }, random_pair(4 * number))
            }
        };
        let Some((first_ray, lit)) = self.trace_lobe_ray(&receiver, lobe_numbers) else {
            let direction = lobe_direction(receiver.mirror(), phong::exponent(receiver.roughness), lobe_numbers);
            return WorldSample { radiance: DVec3::ZERO, bounced: DVec3::ZERO, direction, end: None };
        };
        // The throughput is the share of the light at the last surface that reaches the receiver.
        let (mut bounced, mut throughput, mut last_ray) = (DVec3::ZERO, 1.0, first_ray);
        for bounce in 1..u64::from(self.bounces) {
            let Some(receiver) = last_ray.point.and_then(|point| Receiver::hit_by(&last_ray.ray, &point)) else {
                break;
            };
            // Further bounces use random numbers from 2⁴⁰ on, far from those of the first bounces of fewer than 2³²
            // samples.
            let first_number = (bounce << 40) + 2 * number;
            throughput *= receiver.reflectivity;
            let Some((next_ray, lit)) = self.trace_lobe_ray(&receiver, random_pair(first_number)) else { break };
            bounced += throughput * lit;
            last_ray = next_ray;
        }
        WorldSample { radiance: lit + bounced, bounced, direction: first_ray.ray.direction, end: first_ray.end }
    }

    /// Traces the ray of a receiver's lobe that two random numbers choose. Returns the ray, and the light that arrives
    /// along it from a surface or from the environment. `None` if the ray leads below the surface and brings no light.
    fn trace_lobe_ray(&self, receiver: &Receiver, random_pair: [f64; 2]) -> Option<(TracedRay, DVec3)> {
        let direction = lobe_direction(receiver.mirror(), phong::exponent(receiver.roughness), random_pair);
        if !receiver.is_above(direction) {
            return None;
        }
        let ray = WorldRay { origin: receiver.position, direction, t_min: RAY_START_M, t_max: f64::INFINITY };
        let hit = self.world.closest(&ray);
        let point = hit.map(|hit| self.world.point(&ray, &hit));
        let light = match &point {
            Some(point) => self.world.color(&ray, point),
            None if self.escape == EscapeRadiance::Environment => sky_color(direction),
            None => DVec3::ZERO,
        };
        Some((TracedRay { ray, end: hit.map(|hit| ray.point_at(hit.t)), point }, light))
    }
}

/// A ray, with the place and the surface where it ends; both are `None` if the ray escapes.
#[derive(Clone, Copy)]
struct TracedRay {
    ray: WorldRay,
    end: Option<DVec3>,
    point: Option<SurfacePoint>,
}

#[cfg(test)]
mod tests;
