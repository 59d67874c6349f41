//! The references of a cell: hits and an image of the screen by each version of the oracle, and hits and an image of
//! the world.

use super::{ErrorSpec, display};
use crate::error::Result;
use crate::study::ties::are_mirrors;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use ssct_ground::math::OracleVersion;
use ssct_scenes::{GBufferData, Material};
use ssct_truth::metrics::image::masked_rmse;
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::floor::ScreenFloor;
use ssct_truth::reference::hierarchy::Hierarchy;
use ssct_truth::reference::screen::{Sampling, ScreenReference};
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world::WorldReference;
use ssct_truth::reference::world_hits::{WorldHit, world_hits};

/// Rays a pixel of the world reference that are traced between two calls of `go_on`.
const RAYS_AT_ONCE: u32 = 8;

/// The seed of the world references.
const WORLD_SEED: u64 = 2;

/// The references of a cell.
pub(super) struct Truth {
    /// The G-buffer that the variants see.
    pub(super) data: GBufferData,
    /// Whether each pixel reflects.
    pub(super) mask: Vec<bool>,
    /// Whether every reflecting pixel is a mirror; only then are hits compared.
    pub(super) has_only_mirrors: bool,
    /// The references in screen space, by each version of the oracle that a variant is compared with.
    pub(super) screens: Vec<ScreenTruth>,
    /// Where each pixel's mirror ray ends in the world; empty unless all reflecting pixels are mirrors.
    pub(super) world_hits: Vec<WorldHit>,
    /// The world reference.
    pub(super) world: Reference,
    /// The RMSE of the screen's floor.
    pub(super) floor: f64,
}

/// The references in screen space, by one version of the oracle.
pub(super) struct ScreenTruth {
    pub(super) version: OracleVersion,
    /// Hit of each pixel's mirror ray: pixel x, pixel y and reversed depth. `None` for a miss, and for pixels that do
    /// not reflect.
    pub(super) hits: Vec<Option<DVec3>>,
    /// The screen reference.
    pub(super) image: Reference,
}

impl Truth {
    /// Returns the references in screen space by a version of the oracle; if no variant is compared with this version,
    /// those of the first version in the list.
    pub(super) fn screen(&self, version: OracleVersion) -> &ScreenTruth {
        self.screens.iter().find(|s| s.version == version).unwrap_or(&self.screens[0])
    }
}

/// A reference image.
pub(super) struct Reference {
    /// Linear reflection colour of each pixel.
    pub(super) color: Vec<[f32; 3]>,
    /// The display image of the colour, 3 bytes a pixel.
    pub(super) display: Vec<u8>,
    /// RMSE that the reference itself is expected to have, from the finite number of its rays.
    pub(super) standard_error: f64,
}

/// Computes the references for the G-buffer `data` that the variants see, with a number of bounces. `go_on` is called
/// between two steps, and its error ends the computation.
pub(super) fn truth(
    spec: &ErrorSpec,
    data: GBufferData,
    materials: &[Material],
    bounces: u32,
    go_on: &mut dyn FnMut() -> Result<()>,
) -> Result<Truth> {
    let (mask, has_only_mirrors) = (data.reflecting(), are_mirrors(&data));
    let mut screen_truth = |version| {
        let hierarchy = Hierarchy::new(&data).of_version(version);
        let mirror_hit = |pixel: u32| {
            mask[pixel as usize].then(|| hierarchy.trace(pixel % data.width, pixel / data.width).position())
        };
        let sampling = Sampling { samples: spec.rays, seed: 1, oracle: version, bounces };
        let image = ScreenReference::render_while(&data, &mask, sampling, go_on)?;
        Ok(ScreenTruth {
            version,
            hits: (0..mask.len() as u32).into_par_iter().map(|pixel| mirror_hit(pixel).flatten()).collect(),
            image: Reference::new(&image.color, image.overall_standard_error),
        })
    };
    let mut versions: Vec<_> = spec.variants.iter().map(|v| v.setup.effect().oracle).collect();
    versions.sort_by_key(|version| u32::from(*version));
    versions.dedup();
    let screens = versions.into_iter().map(&mut screen_truth).collect::<Result<Vec<_>>>()?;

    let triangles = World::new(spec.scene, materials);
    let first_hits = FirstHits::shown(&triangles, &data);
    let reference = WorldReference::new(&triangles, &first_hits, &data.camera, WORLD_SEED).with_bounces(bounces);
    let mut floor = ScreenFloor::new(&data, &first_hits);
    let mut state = reference.start();
    while state.samples() < spec.rays {
        go_on()?;
        let rays = RAYS_AT_ONCE.min(spec.rays - state.samples());
        floor.add(&reference, &mut state, rays);
    }
    let world = Reference::new(&reference.image(&state).reflection, state.overall_standard_error());
    let floor = masked_rmse(&world.color, &colors(&floor.image(&state)), &mask);
    Ok(Truth {
        has_only_mirrors,
        screens,
        world_hits: if has_only_mirrors { world_hits(&triangles, &data, &first_hits) } else { Vec::new() },
        world,
        floor,
        data,
        mask,
    })
}

/// Converts colours to arrays of red, green and blue.
fn colors(image: &[Vec3]) -> Vec<[f32; 3]> {
    image.iter().map(Vec3::to_array).collect()
}

impl Reference {
    /// Makes a reference from its linear colours and their standard error.
    fn new(color: &[Vec3], standard_error: f64) -> Self {
        let color = colors(color);
        Self { display: display(&color), color, standard_error }
    }
}
