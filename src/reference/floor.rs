//! The floor of the screen's picture (docs/definitions.md, "Version 2", item 8): the reflection that shows, for each ray
//! whose end the screen shows, the screen's colour there, and the truth for all others. The hits of a method on the
//! screen cannot bring it nearer to the world.

use super::first_hits::FirstHits;
use super::world::WorldReference;
use super::world_hits::ShownPlaces;
use super::world_state::WorldState;
use crate::scene::GBufferData;
use glam::{DVec3, Vec3};

/// Sums of what a screen shows of the rays of a world reference.
#[derive(Debug, Clone)]
pub struct ScreenFloor<'a> {
    screen: ShownPlaces<'a>,
    sums: Vec<DVec3>,
}

impl<'a> ScreenFloor<'a> {
    /// Of a G-buffer and its own first hits, without samples.
    pub fn new(gbuffer: &'a GBufferData, first_hits: &'a FirstHits) -> Self {
        Self { screen: ShownPlaces::new(gbuffer, first_hits), sums: vec![DVec3::ZERO; gbuffer.depth.len()] }
    }

    /// Adds samples to the state of a reference of the same size, and what the screen shows of the same samples to the
    /// sums.
    pub fn add(&mut self, reference: &WorldReference, state: &mut WorldState, samples: u32) {
        let Self { screen, sums } = self;
        reference.add_beside(state, samples, sums, |sum, sample| {
            let on_screen = sample.end.and_then(|end| screen.color(end, sample.direction));
            *sum += on_screen.unwrap_or(sample.radiance);
        });
    }

    /// The reflection colour, linear, rows from the top; of the state that all samples were added to.
    pub fn image(&self, state: &WorldState) -> Vec<Vec3> {
        let pixels = self.sums.iter().zip(state.sample_counts());
        pixels.map(|(sum, samples)| (*sum / f64::from(samples.max(1))).as_vec3()).collect()
    }
}
