//! Finds places for captures in any scene, independent of a view (docs/definitions.md, "Captures").
//!
//! The module `space` finds where people can stand: on floors, between walls or under roofs. The module `mirrors`
//! samples what people see in mirrors by paths: from an eye to a surface, and from there along the mirror ray to its
//! end. A greedy search then takes captures one after another, each time the capture that shows ends better than the
//! earlier ones by the most. Random numbers are computed from counters, so that the places depend on the scene alone.

mod mirrors;
mod space;

use crate::bvh::WorldRay;
use crate::triangles::Triangles;
use glam::{DVec3, Vec3};
use mirrors::MirrorEnd;
use rayon::prelude::*;
use ssct_ground::scene::capture::MAX_CAPTURES;
use ssct_ground::scene::{Capture, Scene, Texture};
use std::cell::RefCell;

pub use ssct_ground::scene::capture::WantedCaptures;

/// Greatest number of captures that [`WantedCaptures::Auto`] places.
///
/// In most scenes four captures see nearly all that mirrors show. The images of four cubes with faces of 512² texels
/// and their pyramids just fit into 200 MB.
pub const AUTO_MOST: usize = 4;

/// Least gain of a further capture that [`WantedCaptures::Auto`] places, as a share of what mirrors show beyond the
/// screen. The gain is five times the standard error of such a share, √(p (1 − p) / n) for p = 0.005 and the n paths of
/// [`mirrors`]. A smaller gain may come from the random choice of the paths alone.
const AUTO_GAIN: f32 = 0.005;

/// How much coarse texels count against a capture: a seen end counts
/// 1 / (1 + `COARSENESS` · (texel's edge / pixel's edge)²).
///
/// The value is so small that resolution decides only between places that see almost equally much.
const COARSENESS: f64 = 0.02;

/// Least cosine of the angle between the normal of a surface and the direction to the capture. More oblique surfaces
/// count as seen at this angle.
const COSINE_MIN: f64 = 0.01;

/// Captures in the order of their gain, with the shares that they see.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Placement {
    /// The captures.
    pub captures: Vec<Capture>,
    /// Number of captures, from the first on, that come from the scene file.
    pub from_file: usize,
    /// Shares, 0…1, of what mirrors show beyond the screen (see `mirrors`): the share that the first capture sees, the
    /// share that the first two see, and so on. The list is as long as [`Placement::captures`]. All shares are 0 where
    /// mirrors show nothing.
    pub seen: Vec<f32>,
    /// Positions of the eyes of the people for whom the captures are placed; in world space, in metres.
    pub stands: Vec<Vec3>,
}

/// Finds the captures that are wanted, stores them in the scene, and returns them with the shares that they see.
pub fn with_captures(scene: &mut Scene, wanted: WantedCaptures) -> Placement {
    let placement = place(scene, wanted);
    scene.captures.clone_from(&placement.captures);
    placement
}

/// Returns a function that runs [`place`] in a copy of the scene. The function takes the captures of the scene file and
/// how many captures are wanted, and returns the captures that [`place`] finds.
pub fn finder(scene: &Scene) -> impl Fn(&[Capture], WantedCaptures) -> Vec<Capture> + use<> {
    let scene_copy = RefCell::new(placement_scene(scene));
    move |captures_of_file, wanted| {
        let mut scene = scene_copy.borrow_mut();
        scene.captures = captures_of_file.to_vec();
        place(&scene, wanted).captures
    }
}

/// Returns the scene's own captures, as many as are wanted, followed by further ones up to the wanted number. These
/// stand where they show the most of what people see in mirrors. The scene's views have no influence.
pub fn place(scene: &Scene, wanted: WantedCaptures) -> Placement {
    let (from_file, most, least_gain) = match wanted {
        WantedCaptures::Auto if scene.captures.is_empty() => (0, AUTO_MOST, AUTO_GAIN),
        WantedCaptures::Auto => (scene.captures.len(), scene.captures.len(), 0.0),
        WantedCaptures::Count(count) => (count.min(scene.captures.len()), count.min(MAX_CAPTURES), 0.0),
    };
    let triangles = Triangles::new(scene, &scene.materials);
    // The places where people of a size can stand, and the ends of mirror rays that they see beyond the screen; `None`
    // if there are no such ends. The first of the sizes that has some is taken.
    let stands_and_ends = |size: &f64| {
        let stands = space::stands(&triangles, scene, *size);
        let ends = mirrors::ends(&triangles, &stands);
        (!ends.is_empty()).then_some((stands, ends))
    };
    let Some((stands, ends)) = space::SIZES.iter().find_map(stands_and_ends) else {
        let captures = scene.captures[..from_file].to_vec();
        return Placement { seen: vec![0.0; from_file], captures, from_file, stands: Vec::new() };
    };
    let placement = Placement { stands: stands.iter().map(|s| s.eye.as_vec3()).collect(), ..Placement::default() };
    let mut search = CaptureSearch { triangles: &triangles, best: vec![0.0; ends.len()], ends, placement };
    for capture in &scene.captures[..from_file] {
        let shares = search.shown_shares(capture.position.as_dvec3());
        search.add(*capture, &shares);
    }
    search.placement.from_file = from_file;
    if from_file < most {
        let template = scene.captures.first().copied().unwrap_or(Capture::placed_at(Vec3::ZERO));
        search.run(template, &space::candidates(&stands), most, least_gain);
    }
    search.placement
}

/// Copies the parts of a scene that decide where captures are placed: meshes, materials, lights and the texels of alpha
/// masks. All other textures become a single texel, so that the copy is small.
fn placement_scene(scene: &Scene) -> Scene {
    let masks: Vec<usize> = scene.materials.iter().filter_map(|m| m.alpha_mask).collect();
    let reduce = |(index, texture): (usize, &Texture)| {
        if masks.contains(&index) {
            texture.clone()
        } else {
            Texture { name: String::new(), rgba: vec![255; 4], width: 1, height: 1, encoding: texture.encoding }
        }
    };
    Scene {
        name: scene.name.clone(),
        meshes: scene.meshes.clone(),
        materials: scene.materials.clone(),
        textures: scene.textures.iter().enumerate().map(reduce).collect(),
        lights: scene.lights.clone(),
        ..Scene::default()
    }
}

/// A greedy search for captures, while it is in progress.
struct CaptureSearch<'a> {
    triangles: &'a Triangles<'a>,
    /// The ends of sampled mirror rays, which captures should show.
    ends: Vec<MirrorEnd>,
    /// How well the best capture so far shows each end, 0…1.
    best: Vec<f32>,
    /// The captures found so far.
    placement: Placement,
}

impl CaptureSearch<'_> {
    /// Adds copies of the capture `template` at the candidates with the greatest gains, one after another. The search
    /// ends with `most` captures, or when the gain is below `least_gain`, as a share of all ends, or is 0.
    fn run(&mut self, template: Capture, candidates: &[space::Candidate], most: usize, least_gain: f32) {
        let mut shares_of_candidates: Vec<Vec<f32>> =
            candidates.par_iter().map(|c| self.shown_shares(c.position)).collect();
        while self.placement.captures.len() < most {
            let gains: Vec<f32> = shares_of_candidates.par_iter().map(|shares| self.gain(shares)).collect();
            // The first of equal gains is taken, so that the result does not depend on threads.
            let best_index = (0..gains.len()).rev().max_by(|a, b| gains[*a].total_cmp(&gains[*b]));
            let Some(index) = best_index.filter(|index| gains[*index] > 0.0) else { break };
            // A candidate without shares has no gain, so that none is tried twice.
            let shares = std::mem::take(&mut shares_of_candidates[index]);
            let candidate = &candidates[index];
            if !space::is_clear(self.triangles, candidate) {
                continue;
            }
            if gains[index] < least_gain * self.ends.len() as f32 {
                break;
            }
            self.add(Capture { position: candidate.position.as_vec3(), ..template }, &shares);
        }
    }

    /// Returns how well a capture at `place` would show each end, 0…1, in the order of [`CaptureSearch::ends`]; 0 for a
    /// hidden end.
    fn shown_shares(&self, place: DVec3) -> Vec<f32> {
        self.ends
            .iter()
            .map(|end| if sees(self.triangles, place, end.position) { shown_share(place, end) } else { 0.0 })
            .collect()
    }

    /// Returns the gain of a candidate that shows each end as well as `shares` says: by how much it shows ends better
    /// than the captures so far, summed over all ends. Without shares, the gain is 0.
    fn gain(&self, shares: &[f32]) -> f32 {
        shares.iter().zip(&self.best).map(|(share, best)| (share - best).max(0.0)).sum()
    }

    /// Adds a capture, which shows each end as well as `shares` says, and the share of the ends that all captures then
    /// see.
    fn add(&mut self, capture: Capture, shares: &[f32]) {
        self.best.iter_mut().zip(shares).for_each(|(best, share)| *best = best.max(*share));
        let seen_ends = self.best.iter().filter(|best| **best > 0.0).count();
        self.placement.captures.push(capture);
        self.placement.seen.push(seen_ends as f32 / self.ends.len().max(1) as f32);
    }
}

/// Returns how finely a capture at `place` shows the end of a mirror ray, in 0…1: less, the larger the capture's texel
/// at the end is in comparison with the pixel of the eye there.
fn shown_share(place: DVec3, end: &MirrorEnd) -> f32 {
    let to_capture = place - end.position;
    let cosine = to_capture.normalize_or_zero().dot(end.normal).abs().max(COSINE_MIN);
    // A cube face spans two units at distance one, and the area of a texel on the surface grows with 1 / cosine.
    let texel_m = to_capture.length() * 2.0 / f64::from(Capture::RESOLUTION) / cosine.sqrt();
    let pixel_m = end.path_m * mirrors::PIXEL_RADIANS;
    (1.0 / (1.0 + COARSENESS * (texel_m / pixel_m).powi(2))) as f32
}

/// Returns true if no surface lies between two points. The last 0.1 mm plus 0.1 ‰ of the distance are ignored, since
/// the surface that the second point lies on is there.
pub fn sees(triangles: &Triangles, from: DVec3, to: DVec3) -> bool {
    let offset = to - from;
    let length = offset.length();
    let margin = 1e-4 + 1e-4 * length;
    length <= margin
        || !triangles.any(&WorldRay { origin: from, direction: offset / length, t_min: 0.0, t_max: length - margin })
}

#[cfg(test)]
mod tests;
