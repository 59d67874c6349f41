//! Finds places for captures in any scene, without knowing a view.
//!
//! People stand on floors under a roof or between walls ([`space`]). What their mirrors show is sampled by paths:
//! from an eye to a surface, and from there along the mirror ray to where it ends ([`mirrors`]). A greedy search
//! takes, one after another, the place from which most of these ends are seen that no place sees yet.

mod mirrors;
mod space;

use super::bvh::WorldRay;
use super::{Capture, Scene, Triangles};
use glam::DVec3;
use mirrors::End;
use rayon::prelude::*;

pub use space::{Stand, stands};

/// Captures in the order in which they help most, and what they see.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Placement {
    /// The captures.
    pub captures: Vec<Capture>,
    /// The share, 0…1, of what mirrors show beyond the screen that is seen from the first capture alone, from the
    /// first two, and so on.
    pub seen: Vec<f32>,
}

/// Places at most `most` captures.
pub fn place(scene: &Scene, most: usize) -> Placement {
    let triangles = Triangles::new(scene, &scene.materials);
    let stands = stands(&triangles, scene);
    let ends = mirrors::ends(&triangles, &stands);
    let candidates = space::candidates(&triangles, &stands);
    let quality: Vec<Vec<f32>> = candidates
        .par_iter()
        .map(|place| ends.iter().map(|end| quality(&triangles, *place, end)).collect())
        .collect();
    greedy(&candidates, &quality, &ends, most)
}

fn greedy(candidates: &[DVec3], quality: &[Vec<f32>], ends: &[End], most: usize) -> Placement {
    let mut best = vec![0.0_f32; ends.len()];
    let total: f32 = ends.iter().map(|e| e.weight).sum();
    let mut placement = Placement::default();
    let gain_of = |best: &[f32], row: &[f32]| -> f32 {
        row.iter().zip(best).zip(ends).map(|((q, b), e)| e.weight * (q - b).max(0.0)).sum()
    };
    while placement.captures.len() < most {
        let gains: Vec<f32> = quality.par_iter().map(|row| gain_of(&best, row)).collect();
        let Some((index, gain)) = gains.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
        else {
            break;
        };
        if gain <= 0.0 {
            break;
        }
        best.iter_mut().zip(&quality[index]).for_each(|(b, q)| *b = b.max(*q));
        placement.captures.push(Capture::at(candidates[index].as_vec3()));
        let seen: f32 = best.iter().zip(ends).map(|(b, e)| if *b > 0.0 { e.weight } else { 0.0 }).sum();
        placement.seen.push(seen / total);
    }
    placement
}

/// How well a capture at a place shows an end: 0 if it does not see it, else the size of the end's texel there.
fn quality(triangles: &Triangles, place: DVec3, end: &End) -> f32 {
    if !sees(triangles, place, end.position) {
        return 0.0;
    }
    let away = place - end.position;
    let cosine = (away.normalize_or_zero().dot(end.normal)).abs().max(0.01);
    // The edge of a texel on the surface over that of a pixel that the path leads to.
    let texel = away.length() * 2.0 / f64::from(Capture::RESOLUTION) / cosine.sqrt();
    let pixel = end.path_m * mirrors::PIXEL;
    let k: f64 = std::env::var("K").ok().and_then(|v| v.parse().ok()).unwrap_or(0.0);
    (1.0 / (1.0 + k * (texel / pixel).powi(2))) as f32
}

/// Whether nothing stands between two points.
pub fn sees(triangles: &Triangles, from: DVec3, to: DVec3) -> bool {
    let way = to - from;
    let length = way.length();
    let margin = 1e-4 + 1e-4 * length;
    if length <= margin {
        return true;
    }
    !triangles.any(&WorldRay { origin: from, direction: way / length, t_min: 0.0, t_max: length - margin })
}
