//! What a frame at rest is asked: where its rays ended, what a picked ray did, and what the oracle says
//! of the same ray. All of it on the CPU, from one reading of the G-buffer.

use super::state::Side;
use crate::gpu::Pixels;
use crate::methods::thesis::{self, Variant};
use crate::passes::PathCode;
use crate::reference::hi_z::{MinMax, chain};
use crate::reference::hi_z_ray_trace::{self, Constants, HiZTrace, reflection_ray};
use crate::reference::ray::{RaySetup, Segment};
use crate::reference::unified::Traversal;
use crate::reference::{Level, Oracle, Trace};
use crate::scene::GBufferData;
use glam::Vec3;
use rayon::prelude::*;

/// Pixels along a side of a tile of `unified` (`TILE` of `tiles.glsl`).
const TILE: u32 = 8;

/// A frame's G-buffer and hits on the host.
pub struct Inspection {
    /// The G-buffer.
    pub gbuffer: GBufferData,
    /// Where the method's rays ended, if it says so.
    pub hits: Option<Pixels>,
    twin: Option<Twin>,
}

/// How the method's ray trace is done again on the CPU.
enum Twin {
    /// The thesis's Hi-Z ray tracing, with its chain.
    HiZ { constants: Constants, reflection_offset: f32, direction_epsilon: f32, chain: Vec<Level<MinMax>> },
    /// The traversal of `unified`.
    Unified,
}

/// A ray, seen by the method, by the twin of its traversal, and by the oracle.
#[derive(Debug, Clone)]
pub struct PickedRay {
    /// The pixel that it starts from.
    pub pixel: [u32; 2],
    /// Its way in the image; `None` where there is no ray.
    pub segment: Option<Segment>,
    /// How the method says it ended, and where in pixels.
    pub method: Option<(PathCode, [f32; 2])>,
    /// Its cells and levels, if the thesis's Hi-Z ray tracing traces it.
    pub walk: Option<HiZTrace>,
    /// What it truly meets in the G-buffer.
    pub oracle: Trace,
}

/// Tiles of 8 × 8 pixels by what is in them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TileClasses {
    /// Nothing that reflects.
    pub empty: usize,
    /// Mirrors alone.
    pub mirrors: usize,
    /// Gloss alone.
    pub glossy: usize,
    /// Both.
    pub both: usize,
}

impl Inspection {
    /// Of a side's frame.
    pub fn new(gbuffer: GBufferData, hits: Option<Pixels>, side: &Side) -> Self {
        let extent = [gbuffer.width, gbuffer.height];
        let hi_z = |fallback| {
            let variant =
                Variant { preset: side.setup.preset, tuning: side.setup.tuning, fallback, fade: side.setup.fade };
            let levels = crate::gpu::image::full_chain(extent);
            let block = thesis::parameters(&variant, &gbuffer.camera, extent, levels);
            let depth = Level {
                width: gbuffer.width,
                height: gbuffer.height,
                texels: gbuffer.depth.iter().map(|reversed| 1.0 - reversed).collect(),
            };
            Twin::HiZ {
                constants: Constants {
                    start_level: block.start_level.max(0) as u32,
                    iterations: block.iterations.max(0) as u32,
                    cross_offset: block.cross_offset,
                },
                reflection_offset: block.reflection_offset,
                direction_epsilon: block.view_direction_epsilon,
                chain: chain(&depth),
            }
        };
        // At a lower resolution the rays are those of other pixels.
        let twin = match side.method.name {
            _ if side.setup.divisor != 1 => None,
            "ssct" => Some(hi_z(true)),
            "hzct" => Some(hi_z(false)),
            "unified" => Some(Twin::Unified),
            _ => None,
        };
        Self { gbuffer, hits, twin }
    }

    /// Rays by how they ended, with their number.
    pub fn ends(&self) -> Vec<(PathCode, usize)> {
        let mut counts: Vec<(PathCode, usize)> = Vec::new();
        for code in self.hits.iter().flat_map(Pixels::texels).filter_map(|t| PathCode::from_channel(t[3])) {
            match counts.iter_mut().find(|(c, _)| *c == code) {
                Some((_, n)) => *n += 1,
                None => counts.push((code, 1)),
            }
        }
        counts.retain(|(code, _)| *code != PathCode::None);
        counts.sort_by_key(|(code, _)| *code as u8);
        counts
    }

    /// Reflecting pixels: each has a ray.
    pub fn rays(&self) -> usize {
        (0..self.gbuffer.depth.len()).filter(|i| self.gbuffer.reflects(*i)).count()
    }

    /// Tiles by class: what a method that classifies them has to do.
    pub fn tiles(&self) -> TileClasses {
        let g = &self.gbuffer;
        let mut classes = TileClasses::default();
        for top in (0..g.height).step_by(TILE as usize) {
            for left in (0..g.width).step_by(TILE as usize) {
                let rows = top..(top + TILE).min(g.height);
                let pixels = rows.flat_map(|y| (left..(left + TILE).min(g.width)).map(move |x| (x, y)));
                let reflecting = pixels.map(|(x, y)| g.index(x, y)).filter(|i| g.reflects(*i));
                let (mut mirrors, mut glossy) = (false, false);
                for i in reflecting {
                    if g.roughness[i] > 0.0 { glossy = true } else { mirrors = true }
                }
                match (mirrors, glossy) {
                    (false, false) => classes.empty += 1,
                    (true, false) => classes.mirrors += 1,
                    (false, true) => classes.glossy += 1,
                    (true, true) => classes.both += 1,
                }
            }
        }
        classes
    }

    /// Steps of every pixel's ray, rows from the top; `None` for methods whose traversal has no twin.
    pub fn steps(&self) -> Option<Vec<u32>> {
        let (width, pixels) = (self.gbuffer.width, self.gbuffer.width * self.gbuffer.height);
        let at = |i: u32| (i % width, i / width);
        match self.twin.as_ref()? {
            Twin::HiZ { .. } => {
                let steps = |(x, y)| self.hi_z(x, y).map_or(0, |t| t.steps.len() as u32);
                Some((0..pixels).into_par_iter().map(|i| steps(at(i))).collect())
            }
            Twin::Unified => {
                let traversal = Traversal::new(&self.gbuffer);
                let steps = |(x, y)| {
                    let ray = traversal.mirror_ray(x, y).filter(|_| self.gbuffer.reflects(self.gbuffer.index(x, y)));
                    ray.map_or(0, |(ray, _)| traversal.traverse(&ray).steps.max(0) as u32)
                };
                Some((0..pixels).into_par_iter().map(|i| steps(at(i))).collect())
            }
        }
    }

    /// The thesis's Hi-Z ray tracing of a pixel (Alg. 6); `None` where the pixel does not reflect, or its
    /// ray runs towards the camera.
    fn hi_z(&self, x: u32, y: u32) -> Option<HiZTrace> {
        let Some(Twin::HiZ { constants, reflection_offset, direction_epsilon, chain }) = &self.twin else {
            return None;
        };
        let g = &self.gbuffer;
        let (index, finest) = (g.index(x, y), &chain[0]);
        let normal = g.normal[index];
        if g.reflectivity[index] <= GBufferData::REFLECTS_ABOVE || normal.length_squared() <= 1e-4 {
            return None;
        }
        let pixel = Vec3::new(
            (x as f32 + 0.5) / g.width as f32,
            (y as f32 + 0.5) / g.height as f32,
            finest.at_clamped(x, y).min,
        );
        let ray = reflection_ray(&g.camera, pixel, normal.normalize(), *reflection_offset);
        (ray.z > *direction_epsilon).then(|| hi_z_ray_trace::trace(chain, pixel, ray, constants))
    }

    /// The ray of a pixel; `None` off the image.
    pub fn pick(&self, pixel: [u32; 2]) -> Option<PickedRay> {
        let [x, y] = pixel;
        if x >= self.gbuffer.width || y >= self.gbuffer.height {
            return None;
        }
        let setup = RaySetup::new(&self.gbuffer);
        let side = [self.gbuffer.width as f32, self.gbuffer.height as f32];
        let method = self.hits.as_ref().and_then(|hits| {
            let texel = hits.at(x, y);
            Some((PathCode::from_channel(texel[3])?, [texel[0] * side[0], texel[1] * side[1]]))
        });
        Some(PickedRay {
            pixel,
            segment: setup.mirror(x, y).and_then(|direction| setup.segment(x, y, direction)),
            method,
            walk: self.hi_z(x, y),
            oracle: Oracle::new(&self.gbuffer).trace(x, y),
        })
    }
}
