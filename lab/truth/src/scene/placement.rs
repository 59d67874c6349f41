//! Finds places for captures in any scene, without knowing a view (docs/definitions.md, "Captures").
//!
//! People stand on floors, between walls or under roofs (`space`). What their mirrors show is sampled by paths: from an
//! eye to a surface, and from there along the mirror ray to where it ends (`mirrors`). A greedy search then takes,
//! one after another, the place that shows most of those ends that no capture shows yet. All random numbers are
//! counted, not drawn, so that the places depend on nothing but the scene.

mod mirrors;
mod space;

use super::bvh::WorldRay;
use super::capture::MAX_CAPTURES;
use super::{Capture, Scene, Texture, Triangles};
use glam::{DVec3, Vec3};
use mirrors::MirrorEnd;
use rayon::prelude::*;
use std::cell::RefCell;

pub use super::capture::WantedCaptures;

/// The most captures that [`WantedCaptures::Auto`] places.
///
/// Four see nearly all that mirrors show in most scenes, and the images of four cubes of 512² with their pyramids
/// are what fits into 200 MB.
pub const AUTO_MOST: usize = 4;

/// [`WantedCaptures::Auto`] places no further capture that shows less than this share more of what mirrors show beyond the
/// screen. It is five times the standard error of such a share, √(p (1 − p) / n) for p = 0.005 and the n paths of
/// [`mirrors`]: a smaller gain may be one of these paths alone.
const AUTO_GAIN: f32 = 0.005;

/// How much a texel that is as large as the pixel that shows it counts against the capture: the weight of an end is
/// 1 / (1 + `COARSENESS` · (texel's edge / pixel's edge)²).
///
/// So small that resolution decides only between places that see equally much.
const COARSENESS: f64 = 0.02;

/// A surface that is seen more obliquely than this cosine counts as if it were at this angle.
const COSINE_MIN: f64 = 0.01;

/// Captures in the order in which they help, and what they see.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Placement {
    /// The captures.
    pub captures: Vec<Capture>,
    /// How many of them, from the first on, come from the scene file.
    pub own: usize,
    /// The share, 0…1, of what mirrors show beyond the screen (see `mirrors`) that is seen from the first capture
    /// alone, from the first two, and so on; as long as [`Placement::captures`]. 0 where mirrors show nothing.
    pub seen: Vec<f32>,
    /// The eyes of people at the places where they stand, for whom the captures are placed; world, in metres.
    pub stands: Vec<Vec3>,
}

/// Gives a scene the captures that are wanted, and says what they see.
pub fn with_captures(scene: &mut Scene, wanted: WantedCaptures) -> Placement {
    let placement = place(scene, wanted);
    scene.captures.clone_from(&placement.captures);
    placement
}

/// What places the captures of a scene when they are asked for: [`place`] in a copy of the scene, with the captures that
/// it has itself by then.
pub fn finder(scene: &Scene) -> impl Fn(&[Capture], WantedCaptures) -> Vec<Capture> + use<> {
    let bare = RefCell::new(placement_scene(scene));
    move |own, wanted| {
        let mut scene = bare.borrow_mut();
        scene.captures = own.to_vec();
        place(&scene, wanted).captures
    }
}

/// Finds the captures that are wanted for a scene. Its views have no influence.
pub fn place(scene: &Scene, wanted: WantedCaptures) -> Placement {
    let (own, most, least_gain) = match wanted {
        WantedCaptures::Auto if scene.captures.is_empty() => (0, AUTO_MOST, AUTO_GAIN),
        WantedCaptures::Auto => (scene.captures.len(), scene.captures.len(), 0.0),
        WantedCaptures::Count(count) => (count.min(scene.captures.len()), count.min(MAX_CAPTURES), 0.0),
    };
    let triangles = Triangles::new(scene, &scene.materials);
    let inhabited = |size: &f64| {
        let stands = space::stands(&triangles, scene, *size);
        let ends = mirrors::ends(&triangles, &stands);
        (!ends.is_empty()).then_some((stands, ends))
    };
    let Some((stands, ends)) = space::SIZES.iter().find_map(inhabited) else {
        let captures = scene.captures[..own].to_vec();
        return Placement { seen: vec![0.0; own], captures, own, stands: Vec::new() };
    };
    let placement = Placement { stands: stands.iter().map(|s| s.eye.as_vec3()).collect(), ..Placement::default() };
    let mut found = CaptureSearch { triangles: &triangles, best: vec![0.0; ends.len()], ends, placement };
    for capture in &scene.captures[..own] {
        let row = found.row(capture.position.as_dvec3());
        found.take(*capture, &row);
    }
    found.placement.own = own;
    if own < most {
        let base = scene.captures.first().copied().unwrap_or(Capture::at(Vec3::ZERO));
        found.search(base, &space::candidates(&stands), most, least_gain);
    }
    found.placement
}

/// A scene with all that decides where captures stand: its triangles and masks.
fn placement_scene(scene: &Scene) -> Scene {
    let masks: Vec<usize> = scene.materials.iter().filter_map(|m| m.alpha_mask).collect();
    let without_texels = |(i, t): (usize, &Texture)| {
        if masks.contains(&i) {
            t.clone()
        } else {
            Texture { name: String::new(), rgba: vec![255; 4], width: 1, height: 1, encoding: t.encoding }
        }
    };
    Scene {
        name: scene.name.clone(),
        meshes: scene.meshes.clone(),
        materials: scene.materials.clone(),
        textures: scene.textures.iter().enumerate().map(without_texels).collect(),
        lights: scene.lights.clone(),
        ..Scene::default()
    }
}

/// A search in progress.
struct CaptureSearch<'a> {
    triangles: &'a Triangles<'a>,
    ends: Vec<MirrorEnd>,
    /// For each end, how well the best capture so far shows it.
    best: Vec<f32>,
    placement: Placement,
}

impl CaptureSearch<'_> {
    /// Takes the best candidate again and again.
    fn search(&mut self, base: Capture, candidates: &[space::Candidate], most: usize, least_gain: f32) {
        let mut rows: Vec<Vec<f32>> = candidates.par_iter().map(|c| self.row(c.position)).collect();
        while self.placement.captures.len() < most {
            let gains: Vec<f32> = rows.par_iter().map(|row| self.gain(row)).collect();
            // The first of equal gains counts, so that the result does not depend on threads.
            let best = (0..gains.len()).rev().max_by(|a, b| gains[*a].total_cmp(&gains[*b]));
            let Some(index) = best.filter(|i| gains[*i] > 0.0) else { break };
            let row = std::mem::take(&mut rows[index]);
            let candidate = &candidates[index];
            if !space::is_clear(self.triangles, candidate) {
                continue;
            }
            if gains[index] < least_gain * self.ends.len() as f32 {
                break;
            }
            self.take(Capture { position: candidate.position.as_vec3(), ..base }, &row);
        }
    }

    /// How well each end is shown by a capture at a place, 0…1; 0 where it is not seen from there.
    fn row(&self, place: DVec3) -> Vec<f32> {
        self.ends
            .iter()
            .map(|end| if sees(self.triangles, place, end.position) { shown_share(place, end) } else { 0.0 })
            .collect()
    }

    /// What a candidate adds; nothing, if its row is empty.
    fn gain(&self, row: &[f32]) -> f32 {
        row.iter().zip(&self.best).map(|(new, best)| (new - best).max(0.0)).sum()
    }

    fn take(&mut self, capture: Capture, row: &[f32]) {
        self.best.iter_mut().zip(row).for_each(|(best, new)| *best = best.max(*new));
        let seen = self.best.iter().filter(|b| **b > 0.0).count();
        self.placement.captures.push(capture);
        self.placement.seen.push(seen as f32 / self.ends.len().max(1) as f32);
    }
}

/// How finely a capture at a place shows an end that it sees, in 0…1.
fn shown_share(place: DVec3, end: &MirrorEnd) -> f32 {
    let away = place - end.position;
    let cosine = away.normalize_or_zero().dot(end.normal).abs().max(COSINE_MIN);
    // A face spans two units at distance one, and a texel's area on the surface grows with 1 / cosine.
    let texel = away.length() * 2.0 / f64::from(Capture::RESOLUTION) / cosine.sqrt();
    let pixel = end.path_m * mirrors::PIXEL_RADIANS;
    (1.0 / (1.0 + COARSENESS * (texel / pixel).powi(2))) as f32
}

/// Whether no surface stands between two points. The last 0.1 mm and 0.1 ‰ of the way do not count, where the second
/// point's own surface is.
pub fn sees(triangles: &Triangles, from: DVec3, to: DVec3) -> bool {
    let way = to - from;
    let length = way.length();
    let margin = 1e-4 + 1e-4 * length;
    length <= margin
        || !triangles.any(&WorldRay { origin: from, direction: way / length, t_min: 0.0, t_max: length - margin })
}

#[cfg(test)]
mod tests;
