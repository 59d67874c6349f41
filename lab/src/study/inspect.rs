//! Analyses a frame at rest: where its rays ended, how the ray of a picked pixel walked, and what the oracle finds for
//! that ray. Everything is computed on the CPU from one readback of the G-buffer.

mod walk;

pub use walk::{VisitedCell, Walk, WalkEnd};

use super::twin::hi_z_constants;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use ssct::gpu::Pixels;
use ssct::methods::setup::BeyondScreen;
use ssct::methods::thesis::{self, HiZParams};
use ssct::methods::{MethodInfo, Setup};
use ssct::passes::PathCode;
use ssct::passes::WIDE_ABOVE;
use ssct::passes::tiles::TILE;
use ssct_ground::math::OracleVersion;
use ssct_scenes::GBufferData;
use ssct_truth::reference::hi_z::{MinMax, chain};
use ssct_truth::reference::hi_z_ray_trace::{self, HiZConstants, HiZTrace, reflection_ray};
use ssct_truth::reference::ray::{RaySetup, Segment};
use ssct_truth::reference::unified::{CaptureTraversal, ScreenRayEnd, Traversal};
use ssct_truth::reference::{Level, Oracle, Trace};

/// The G-buffer and the hits of a frame, on the host.
pub struct Inspection {
    /// The G-buffer.
    pub gbuffer: GBufferData,
    /// Where the method's rays ended; `None` if the method does not report this.
    pub hits: Option<Pixels>,
    twin: Option<Twin>,
    oracle: OracleVersion,
    /// Whether rays that leave the screen are followed in captures or among triangles.
    is_followed: bool,
    /// Whether the method's own rays of a rough pixel are drawn from its lobe.
    traces_lobes: bool,
    /// Whether the method is `unified`.
    is_unified: bool,
}

/// How the method's ray tracing is repeated on the CPU.
enum Twin {
    /// The thesis's Hi-Z ray tracing, with its Hi-Z chain.
    HiZ { constants: HiZConstants, reflection_offset: f32, direction_epsilon: f32, chain: Vec<Level<MinMax>> },
    /// The traversal of `unified`.
    Unified,
}

/// A ray as the method, the twin of its traversal, and the oracle see it.
#[derive(Debug, Clone)]
pub struct PickedRay {
    /// Pixel that the ray starts from.
    pub pixel: [u32; 2],
    /// The ray's path in the image; `None` if there is no ray.
    pub segment: Option<Segment>,
    /// How the method reports that the ray ended, and where, in pixels.
    pub method: Option<(PathCode, [f32; 2])>,
    /// Visited cells and levels, if the method traverses a Hi-Z chain and its traversal has a twin.
    pub walk: Option<Walk>,
    /// Hit of the ray in the G-buffer by the oracle.
    pub oracle: Trace,
    /// Way of the ray through the world, if the method reports how the ray ended.
    pub in_world: Option<RayInWorld>,
    /// Way of the ray after the screen lost it, projected onto the image, in pixels, which may lie outside the image.
    pub beyond_on_screen: Option<Vec<Vec2>>,
}

/// The way of a ray through the world, on the screen and, where the screen lost it, in captures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayInWorld {
    /// Where the ray begins, in world space, in metres.
    pub begin: Vec3,
    /// Where the screen lost or hit the ray; the method `captures` follows rays from where they begin.
    pub lost: Vec3,
    /// Where the ray ends: at its hit, at a point far along it for the sky, or where the screen lost it if no image sees its
    /// end.
    pub end: Vec3,
    /// How the ray ends: a hit on the screen, [`PathCode::Capture`], [`PathCode::Triangle`], [`PathCode::Sky`] or
    /// [`PathCode::Unknown`].
    pub code: PathCode,
    /// The capture in which the ray hit, counted from 0.
    pub capture: Option<usize>,
}

impl RayInWorld {
    /// Length of the last part of a way to the sky, in metres.
    const SKY_M: f32 = 1e4;

    /// Points along the way from its beginning to its end. Its two parts, before and after the screen lost the ray,
    /// have equally many points, which lie closer near the start of each part, as a picture needs.
    pub fn way(&self) -> Vec<Vec3> {
        const POINTS: u16 = 256;
        let part = |from: Vec3, to: Vec3| {
            (0..=POINTS).map(move |i| {
                let t = f32::from(i) / f32::from(POINTS);
                // Cubing `t` spaces points closely near `from`, where perspective magnifies them.
                from.lerp(to, t * t * t)
            })
        };
        part(self.begin, self.lost).chain(part(self.lost, self.end)).collect()
    }
}

/// The reflecting pixels by how `unified` treats them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PixelClasses {
    /// Number of mirrors (roughness 0); each has its own ray.
    pub mirrors: usize,
    /// Number of narrow lobes; each has its own ray.
    pub narrow: usize,
    /// Number of wide lobes.
    pub wide: usize,
    /// Number of cells of 2 × 2 pixels that contain wide lobes; each cell has one ray.
    pub wide_cells: usize,
}

impl PixelClasses {
    /// The number of rays.
    pub fn rays(&self) -> usize {
        self.mirrors + self.narrow + self.wide_cells
    }
}

/// The numbers of tiles of `unified`, by content.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TileClasses {
    /// Tiles without reflecting pixels.
    pub empty: usize,
    /// Tiles whose reflecting pixels are all mirrors.
    pub mirrors: usize,
    /// Tiles whose reflecting pixels are all glossy.
    pub glossy: usize,
    /// Tiles with mirrors and glossy pixels.
    pub both: usize,
}

impl Inspection {
    /// Prepares the analysis of a method's frame; the names of the recorded passes tell whether its rays walk over the screen.
    pub fn new(
        gbuffer: GBufferData,
        hits: Option<Pixels>,
        (method, setup): (&MethodInfo, &Setup),
        recorded: &[String],
    ) -> Self {
        let extent = [gbuffer.width, gbuffer.height];
        let hi_z = || {
            let levels = ssct::gpu::image::full_chain(extent);
            let numbers: HiZParams = setup.parameters();
            let block = numbers.fill(thesis::block(&gbuffer.camera, extent, levels, true));
            let depth = Level {
                width: gbuffer.width,
                height: gbuffer.height,
                texels: gbuffer.depth.iter().map(|reversed| 1.0 - reversed).collect(),
            };
            Twin::HiZ {
                constants: hi_z_constants(&block),
                reflection_offset: block.reflection_offset,
                direction_epsilon: block.view_direction_epsilon,
                chain: chain(&depth),
            }
        };
        // At a lower resolution rays start from other pixels than those of a twin, so that no twin repeats them.
        let effect = setup.effect();
        let walks_pyramid = method.follows_oracle && recorded.iter().any(|pass| pass == "pyramid");
        let twin = match effect.divisor() {
            1 if method.traces_hi_z => Some(hi_z()),
            1 if walks_pyramid => Some(Twin::Unified),
            _ => None,
        };
        let is_followed =
            method.takes_captures && method.is_screen_space() && effect.beyond(true) != BeyondScreen::None;
        let oracle = if is_followed { OracleVersion::V2 } else { effect.oracle };
        let (traces_lobes, is_unified) = (method.follows_oracle, method.name == "unified");
        Self { gbuffer, hits, twin, oracle, is_followed, traces_lobes, is_unified }
    }

    /// The number of rays that ended with each path code.
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

    /// The number of reflecting pixels.
    pub fn reflecting(&self) -> usize {
        (0..self.gbuffer.depth.len()).filter(|i| self.gbuffer.reflects(*i)).count()
    }

    /// The tiles by content, which decides how much work a method that classifies tiles has.
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

    /// The reflecting pixels by class.
    pub fn pixels(&self) -> PixelClasses {
        let g = &self.gbuffer;
        let mut classes = PixelClasses::default();
        for top in (0..g.height).step_by(2) {
            for left in (0..g.width).step_by(2) {
                let pixels = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (left + dx, top + dy));
                let there = pixels.into_iter().filter(|(x, y)| *x < g.width && *y < g.height);
                let reflecting = there.map(|(x, y)| g.index(x, y)).filter(|i| g.reflects(*i));
                let mut wide = 0;
                for i in reflecting {
                    match g.roughness[i] {
                        r if r > WIDE_ABOVE => wide += 1,
                        r if r > 0.0 => classes.narrow += 1,
                        _ => classes.mirrors += 1,
                    }
                }
                classes.wide += wide;
                classes.wide_cells += usize::from(wide > 0);
            }
        }
        classes
    }

    /// The version of the oracle that the method is compared with.
    pub fn oracle(&self) -> OracleVersion {
        self.oracle
    }

    /// Whether the method draws the rays of a rough pixel from its lobe, so that they are not mirror rays.
    pub fn traces_lobes(&self) -> bool {
        self.traces_lobes
    }

    /// Whether the frame was rendered by `unified`.
    pub fn is_unified(&self) -> bool {
        self.is_unified
    }

    /// The steps of every pixel's ray, rows from the top; `None` for methods whose traversal has no twin.
    pub fn steps(&self) -> Option<Vec<u32>> {
        let (width, pixels) = (self.gbuffer.width, self.gbuffer.width * self.gbuffer.height);
        let place = |i: u32| (i % width, i / width);
        match self.twin.as_ref()? {
            Twin::HiZ { .. } => {
                let steps = |(x, y)| self.hi_z(x, y).map_or(0, |t| t.steps.len() as u32);
                Some((0..pixels).into_par_iter().map(|i| steps(place(i))).collect())
            }
            Twin::Unified => {
                let traversal = self.traversal();
                let steps = |(x, y)| traversal.mirror_steps(x, y).unwrap_or(0);
                Some((0..pixels).into_par_iter().map(|i| steps(place(i))).collect())
            }
        }
    }

    /// The thesis's Hi-Z ray tracing of a pixel (Alg. 6); `None` if the pixel does not reflect or its ray runs
    /// towards the camera.
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

    /// The twin of the walk of `unified` over the screen, with or without images or triangles in which lost rays go on.
    fn traversal(&self) -> Traversal<'_> {
        let traversal = Traversal::new(&self.gbuffer);
        if self.is_followed { traversal.followed() } else { traversal.of_version(self.oracle) }
    }

    /// The path of a pixel's mirror ray.
    fn walk(&self, x: u32, y: u32) -> Option<Walk> {
        let g = &self.gbuffer;
        match self.twin.as_ref()? {
            Twin::HiZ { .. } => {
                let size = Vec2::new(g.width as f32, g.height as f32);
                self.hi_z(x, y).map(|trace| Walk::of_thesis(&trace, size))
            }
            Twin::Unified if g.reflects(g.index(x, y)) => Walk::of_unified(&self.traversal(), x, y),
            Twin::Unified => None,
        }
    }

    /// The ray of a pixel; `None` outside the image.
    pub fn pick(&self, pixel: [u32; 2]) -> Option<PickedRay> {
        let [x, y] = pixel;
        if x >= self.gbuffer.width || y >= self.gbuffer.height {
            return None;
        }
        let setup = RaySetup::new(&self.gbuffer);
        let side = [self.gbuffer.width as f32, self.gbuffer.height as f32];
        let method = self.hits.as_ref().and_then(|hits| {
            let texel = hits.texel(x, y);
            Some((PathCode::from_channel(texel[3])?, [texel[0] * side[0], texel[1] * side[1]]))
        });
        let in_world = self.in_world(&setup, pixel);
        let beyond = in_world.filter(|ray| !ray.code.is_hit());
        Some(PickedRay {
            pixel,
            segment: setup.mirror(x, y).and_then(|direction| setup.segment(x, y, direction)),
            method,
            walk: self.walk(x, y),
            oracle: Oracle::new(&self.gbuffer).of_version(self.oracle).trace(x, y),
            beyond_on_screen: beyond.map(|ray| self.projected(&ray)),
            in_world,
        })
    }

    /// Points of a ray's way after the screen lost it that lie in front of the camera, in pixels.
    fn projected(&self, ray: &RayInWorld) -> Vec<Vec2> {
        let (g, view_to_clip) = (&self.gbuffer, self.gbuffer.view_to_clip());
        let way = ray.way();
        // The second half of the points is the part after the screen lost the ray.
        let after = way[way.len() / 2..].iter();
        let project = |p: &Vec3| {
            let view = g.camera.world_to_view.transform_point3(*p);
            let ahead = view.z > g.camera.lens.near_m;
            ahead.then(|| g.project(view.as_dvec3(), &view_to_clip)).flatten().map(|p| p.truncate().as_vec2())
        };
        after.filter_map(project).collect()
    }

    /// The way of a pixel's ray through the world; `None` if the method looks into the screen alone and the ray missed.
    fn in_world(&self, setup: &RaySetup, [x, y]: [u32; 2]) -> Option<RayInWorld> {
        let g = &self.gbuffer;
        let texel = self.hits.as_ref()?.texel(x, y);
        let code = PathCode::from_channel(texel[3])?;
        if !code.is_hit() && !matches!(code, PathCode::Capture | PathCode::Triangle | PathCode::Sky | PathCode::Unknown)
        {
            return None;
        }
        let view_to_world = g.camera.world_to_view.as_dmat4().inverse();
        let clip_to_view = g.view_to_clip().inverse();
        let place = |x: f64, y: f64, depth: f64| {
            view_to_world.transform_point3(g.unproject(x, y, depth, &clip_to_view)).as_vec3()
        };
        let begin = place(f64::from(x) + 0.5, f64::from(y) + 0.5, f64::from(g.depth[g.index(x, y)]));
        let direction = view_to_world.transform_vector3(setup.mirror(x, y)?).normalize().as_vec3();
        let lost = if code.is_hit() {
            // The image of hits has texture coordinates and standard depth.
            let [u, v, depth] = [0, 1, 2].map(|c| f64::from(texel[c]));
            place(u * f64::from(g.width), v * f64::from(g.height), 1.0 - depth)
        } else if self.is_followed {
            match CaptureTraversal::new(&g.camera, &[]).trace_screen(&self.traversal(), x, y) {
                ScreenRayEnd::Lost(ray) => g.camera.eye() + ray.start,
                _ => begin,
            }
        } else {
            begin
        };
        let end = match code {
            PathCode::Capture | PathCode::Triangle => g.camera.eye() + Vec3::from_slice(texel),
            PathCode::Sky => lost + RayInWorld::SKY_M * direction,
            _ => lost,
        };
        Some(RayInWorld { begin, lost, end, code, capture: PathCode::capture(texel[3]) })
    }
}
