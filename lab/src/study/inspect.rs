//! Analyses a frame of a camera at rest: where its rays ended, how the ray of a picked pixel walked, and what the
//! oracle finds for that ray. All of this is computed on the CPU, from one readback of the G-buffer and of the hits.

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
    /// The twin of the method's ray tracing; `None` if it has none.
    twin: Option<Twin>,
    /// The version of the oracle that the method is compared with.
    pub oracle: OracleVersion,
    /// Whether rays that the screen loses are followed in captures or among triangles.
    is_followed: bool,
    /// Whether the method draws the rays of a rough pixel from its lobe, so that they are not mirror rays.
    pub traces_lobes: bool,
    /// Whether the method is `unified`.
    pub is_unified: bool,
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
    /// How the method reports that the ray ended, and where on the screen, in pixels; `None` without a report.
    pub method: Option<(PathCode, [f32; 2])>,
    /// Visited cells of the Hi-Z chain or of the pyramid; `None` if there is no ray, or the method's walk has no twin.
    pub walk: Option<Walk>,
    /// End of the ray in the G-buffer by the oracle.
    pub oracle: Trace,
    /// Path of the ray through the world; `None` if the method does not report how the ray ended, or looks at the
    /// screen alone and the ray missed.
    pub in_world: Option<RayInWorld>,
    /// Points of the ray's path after the screen lost it, projected onto the image, in pixels; they may lie outside the
    /// image.
    pub beyond_on_screen: Option<Vec<Vec2>>,
}

/// The path of a ray through the world: on the screen and, where the screen lost the ray, in captures or among
/// triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayInWorld {
    /// Where the ray begins, in world space, in metres.
    pub begin: Vec3,
    /// Where the ray hit the screen, or where the screen lost it; the beginning of a ray that was not traced on the
    /// screen.
    pub lost: Vec3,
    /// Where the ray ends: at its hit, at a point far along it if it ends in the sky, or where the screen lost it if
    /// its end is unknown.
    pub end: Vec3,
    /// How the ray ends: a hit on the screen, [`PathCode::Capture`], [`PathCode::Triangle`], [`PathCode::Sky`] or
    /// [`PathCode::Unknown`].
    pub code: PathCode,
    /// The capture in which the ray hit, counted from 0; `None` for any other end.
    pub capture: Option<usize>,
}

impl RayInWorld {
    /// Distance in metres at which a ray that ends in the sky is taken to end, from where the screen lost it.
    const SKY_M: f32 = 1e4;

    /// Returns points along the path, from its beginning to its end, in metres. The two parts, before and after the
    /// screen lost the ray, have equally many points, which lie closer near the start of each part, as a picture needs.
    pub fn points(&self) -> Vec<Vec3> {
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

/// The numbers of reflecting pixels, by how `unified` treats them.
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
    /// Returns the number of rays that `unified` traces for these pixels.
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
    /// Prepares the analysis of a frame of a method with its setup. `recorded` has the labels of the frame's passes,
    /// which tell whether the method's rays walk over the screen's pyramid.
    pub fn new(
        gbuffer: GBufferData,
        hits: Option<Pixels>,
        (method, setup): (&MethodInfo, &Setup),
        recorded: &[String],
    ) -> Self {
        let extent = [gbuffer.width, gbuffer.height];
        let make_hi_z_twin = || {
            let levels = ssct::gpu::image::full_chain(extent);
            let params: HiZParams = setup.parameters();
            let fade = true;
            let block = params.fill(thesis::block(&gbuffer.camera, extent, levels, fade));
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
            1 if method.traces_hi_z => Some(make_hi_z_twin()),
            1 if walks_pyramid => Some(Twin::Unified),
            _ => None,
        };
        let is_followed =
            method.takes_captures && method.is_screen_space() && effect.beyond(true) != BeyondScreen::None;
        let oracle = if is_followed { OracleVersion::V2 } else { effect.oracle };
        let (traces_lobes, is_unified) = (method.follows_oracle, method.name == "unified");
        Self { gbuffer, hits, twin, oracle, is_followed, traces_lobes, is_unified }
    }

    /// Returns each path code that rays ended with, and the number of these rays, in the order of the codes.
    pub fn ends(&self) -> Vec<(PathCode, usize)> {
        let mut counts: Vec<(PathCode, usize)> = Vec::new();
        // The fourth channel of a hit has the path code.
        for code in self.hits.iter().flat_map(Pixels::texels).filter_map(|t| PathCode::from_channel(t[3])) {
            match counts.iter_mut().find(|(counted_code, _)| *counted_code == code) {
                Some((_, count)) => *count += 1,
                None => counts.push((code, 1)),
            }
        }
        counts.retain(|(code, _)| *code != PathCode::None);
        counts.sort_by_key(|(code, _)| *code as u8);
        counts
    }

    /// Returns the number of reflecting pixels.
    pub fn reflecting(&self) -> usize {
        (0..self.gbuffer.depth.len()).filter(|pixel| self.gbuffer.reflects(*pixel)).count()
    }

    /// Counts the tiles by content, which decides how much work a method that classifies tiles has.
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

    /// Counts the reflecting pixels, and the cells of wide lobes, by class.
    pub fn pixels(&self) -> PixelClasses {
        let g = &self.gbuffer;
        let mut classes = PixelClasses::default();
        // Goes through the cells of 2 × 2 pixels.
        for top in (0..g.height).step_by(2) {
            for left in (0..g.width).step_by(2) {
                let pixels = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (left + dx, top + dy));
                let in_image = pixels.into_iter().filter(|(x, y)| *x < g.width && *y < g.height);
                let reflecting = in_image.map(|(x, y)| g.index(x, y)).filter(|i| g.reflects(*i));
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

    /// Counts the steps of every pixel's mirror ray on the screen, rows from the top; 0 without a ray. `None` for
    /// methods whose walk has no twin.
    pub fn steps(&self) -> Option<Vec<u32>> {
        let (width, pixels) = (self.gbuffer.width, self.gbuffer.width * self.gbuffer.height);
        let column_and_row = |i: u32| (i % width, i / width);
        match self.twin.as_ref()? {
            Twin::HiZ { .. } => {
                let steps = |(x, y)| self.trace_hi_z(x, y).map_or(0, |trace| trace.steps.len() as u32);
                Some((0..pixels).into_par_iter().map(|i| steps(column_and_row(i))).collect())
            }
            Twin::Unified => {
                let traversal = self.traversal();
                let steps = |(x, y)| traversal.mirror_steps(x, y).unwrap_or(0);
                Some((0..pixels).into_par_iter().map(|i| steps(column_and_row(i))).collect())
            }
        }
    }

    /// Traces the mirror ray of the pixel (x, y) as the thesis does (Alg. 6). `None` if the pixel does not reflect, if
    /// its ray runs towards the camera, or if the frame was not drawn by Hi-Z ray tracing.
    fn trace_hi_z(&self, x: u32, y: u32) -> Option<HiZTrace> {
        let Some(Twin::HiZ { constants, reflection_offset, direction_epsilon, chain }) = &self.twin else {
            return None;
        };
        let g = &self.gbuffer;
        let (index, finest_level) = (g.index(x, y), &chain[0]);
        let normal = g.normal[index];
        if g.reflectivity[index] <= GBufferData::REFLECTS_ABOVE || normal.length_squared() <= 1e-4 {
            return None;
        }
        // Texture coordinates of the pixel's centre, and its standard depth.
        let start = Vec3::new(
            (x as f32 + 0.5) / g.width as f32,
            (y as f32 + 0.5) / g.height as f32,
            finest_level.at_clamped(x, y).min,
        );
        let ray = reflection_ray(&g.camera, start, normal.normalize(), *reflection_offset);
        (ray.z > *direction_epsilon).then(|| hi_z_ray_trace::trace(chain, start, ray, constants))
    }

    /// Returns the twin of the walk of `unified` over the screen. The walk ends where the screen loses the ray if lost
    /// rays are followed; else it follows the version of the oracle.
    fn traversal(&self) -> Traversal<'_> {
        let traversal = Traversal::new(&self.gbuffer);
        if self.is_followed { traversal.followed() } else { traversal.of_version(self.oracle) }
    }

    /// Returns the walk of the mirror ray of the pixel (x, y) over the screen; `None` if the pixel has no ray, or the
    /// method's walk has no twin.
    fn walk(&self, x: u32, y: u32) -> Option<Walk> {
        let g = &self.gbuffer;
        match self.twin.as_ref()? {
            Twin::HiZ { .. } => {
                let size = Vec2::new(g.width as f32, g.height as f32);
                self.trace_hi_z(x, y).map(|trace| Walk::of_thesis(&trace, size))
            }
            Twin::Unified if g.reflects(g.index(x, y)) => Walk::of_unified(&self.traversal(), x, y),
            Twin::Unified => None,
        }
    }

    /// Analyses the ray of a pixel; `None` outside the image.
    pub fn pick(&self, pixel: [u32; 2]) -> Option<PickedRay> {
        let [x, y] = pixel;
        if x >= self.gbuffer.width || y >= self.gbuffer.height {
            return None;
        }
        let setup = RaySetup::new(&self.gbuffer);
        let [width, height] = [self.gbuffer.width as f32, self.gbuffer.height as f32];
        let method = self.hits.as_ref().and_then(|hits| {
            let texel = hits.texel(x, y);
            Some((PathCode::from_channel(texel[3])?, [texel[0] * width, texel[1] * height]))
        });
        let in_world = self.ray_in_world(&setup, pixel);
        let beyond_screen = in_world.filter(|ray| !ray.code.is_hit());
        Some(PickedRay {
            pixel,
            segment: setup.mirror(x, y).and_then(|direction| setup.segment(x, y, direction)),
            method,
            walk: self.walk(x, y),
            oracle: Oracle::new(&self.gbuffer).of_version(self.oracle).trace(x, y),
            beyond_on_screen: beyond_screen.map(|ray| self.project_beyond(&ray)),
            in_world,
        })
    }

    /// Projects points of a ray's path after the screen lost it onto the image, in pixels. Points behind the near plane
    /// are left out.
    fn project_beyond(&self, ray: &RayInWorld) -> Vec<Vec2> {
        let (g, view_to_clip) = (&self.gbuffer, self.gbuffer.view_to_clip());
        let points = ray.points();
        // The second half of the points is the part after the screen lost the ray.
        let after_loss = points[points.len() / 2..].iter();
        let project = |point: &Vec3| {
            let in_view = g.camera.world_to_view.transform_point3(*point);
            let is_ahead = in_view.z > g.camera.lens.near_m;
            let on_screen = if is_ahead { g.project(in_view.as_dvec3(), &view_to_clip) } else { None };
            on_screen.map(|place| place.truncate().as_vec2())
        };
        after_loss.filter_map(project).collect()
    }

    /// Finds the path of a pixel's ray through the world. `None` if the method does not report how the ray ended, or if
    /// it looks at the screen alone and the ray missed.
    fn ray_in_world(&self, setup: &RaySetup, [x, y]: [u32; 2]) -> Option<RayInWorld> {
        let g = &self.gbuffer;
        let texel = self.hits.as_ref()?.texel(x, y);
        let code = PathCode::from_channel(texel[3])?;
        if !code.is_hit() && !matches!(code, PathCode::Capture | PathCode::Triangle | PathCode::Sky | PathCode::Unknown)
        {
            return None;
        }
        let view_to_world = g.camera.world_to_view.as_dmat4().inverse();
        let clip_to_view = g.view_to_clip().inverse();
        // The point in the world at a place on the screen, in pixels, with a reversed depth.
        let to_world = |x: f64, y: f64, depth: f64| {
            view_to_world.transform_point3(g.unproject(x, y, depth, &clip_to_view)).as_vec3()
        };
        let begin = to_world(f64::from(x) + 0.5, f64::from(y) + 0.5, f64::from(g.depth[g.index(x, y)]));
        let direction = view_to_world.transform_vector3(setup.mirror(x, y)?).normalize().as_vec3();
        let lost = if code.is_hit() {
            // The image of hits has texture coordinates and standard depth.
            let [u, v, depth] = [0, 1, 2].map(|channel| f64::from(texel[channel]));
            to_world(u * f64::from(g.width), v * f64::from(g.height), 1.0 - depth)
        } else if self.is_followed {
            match CaptureTraversal::new(&g.camera, &[]).trace_screen(&self.traversal(), x, y) {
                ScreenRayEnd::Lost(ray) => g.camera.eye() + ray.start,
                _ => begin,
            }
        } else {
            begin
        };
        let end = match code {
            // The image of hits has the end of such a ray relative to the eye.
            PathCode::Capture | PathCode::Triangle => g.camera.eye() + Vec3::from_slice(texel),
            PathCode::Sky => lost + RayInWorld::SKY_M * direction,
            _ => lost,
        };
        Some(RayInWorld { begin, lost, end, code, capture: PathCode::capture(texel[3]) })
    }
}
