//! What a frame at rest is asked: where its rays ended, what a picked ray did, and what the oracle says
//! of the same ray. All of it on the CPU, from one reading of the G-buffer.

use super::state::Side;
use crate::gpu::Pixels;
use crate::methods::thesis::{self, Variant};
use crate::passes::PathCode;
use crate::reference::hi_z_walk::{HiZWalk, Parameters, Walk};
use crate::reference::ray::{RaySetup, Segment};
use crate::reference::{Oracle, Trace};
use crate::scene::GBufferData;
use glam::Mat4;
use rayon::prelude::*;

/// A frame's G-buffer and hits on the host.
pub struct Inspection {
    /// The G-buffer.
    pub gbuffer: GBufferData,
    /// Where the method's rays ended, if it says so.
    pub hits: Option<Pixels>,
    /// The Hi-Z traversal's parameters, for methods that have one.
    walk: Option<Parameters>,
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
    /// Its cells and levels, for methods that traverse the Hi-Z.
    pub walk: Option<Walk>,
    /// What it truly meets in the G-buffer.
    pub oracle: Trace,
}

impl Inspection {
    /// Of a side's frame.
    pub fn new(gbuffer: GBufferData, hits: Option<Pixels>, side: &Side) -> Self {
        let extent = [gbuffer.width, gbuffer.height];
        let fallback = match side.method.name {
            "ssct" => Some(true),
            "hzct" => Some(false),
            _ => None,
        };
        // At a lower resolution the rays are those of other pixels.
        let walk = fallback.filter(|_| side.setup.divisor == 1).map(|fallback| {
            let variant =
                Variant { preset: side.setup.preset, tuning: side.setup.tuning, fallback, fade: side.setup.fade };
            let levels = crate::gpu::image::full_chain(extent);
            let block = thesis::parameters(&variant, &gbuffer.camera, extent, levels);
            Parameters {
                projection: Mat4::from_cols_array_2d(&block.projection),
                inverse_projection: Mat4::from_cols_array_2d(&block.inverse_projection),
                reflection_offset: block.reflection_offset,
                view_direction_epsilon: block.view_direction_epsilon,
                cross_offset: block.cross_offset,
                start_level: block.start_level,
                iterations: block.iterations,
            }
        });
        Self { gbuffer, hits, walk }
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

    /// Steps of every pixel's ray through the Hi-Z, rows from the top; `None` for methods without one.
    pub fn steps(&self) -> Option<Vec<u32>> {
        let walks = HiZWalk::new(&self.gbuffer, self.walk?);
        let (width, pixels) = (self.gbuffer.width, self.gbuffer.width * self.gbuffer.height);
        Some((0..pixels).into_par_iter().map(|i| walks.steps(i % width, i / width)).collect())
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
            walk: self.walk.map(|parameters| HiZWalk::new(&self.gbuffer, parameters).walk(x, y)),
            oracle: Oracle::new(&self.gbuffer).trace(x, y),
        })
    }
}
