//! CPU twin of the pyramid and the traversal of `unified` (`shaders-glsl/unified/`): the same operations in f32 in the
//! same order, so that the results can be compared bit by bit. The twin keeps the shaders' names, and comments in
//! `pyramid.comp` and `traverse.glsl` give the reasons of each step. A ray's s counts pixels along its faster axis.
//!
//! The twin is no evidence for the method, since both share the same ideas; [`super::oracle`] is. A difference between
//! twin and device shows a fault of device or shader. The twin also counts the cells looked at; a shader cannot.

mod blocks;
mod follow;
mod gather;
mod gloss;
mod gloss_trace;
mod lobe;
mod resolve;
mod surface;

pub use follow::{CaptureRayEnd, CaptureTraversal, LostRay, RayEndKind, ScreenRayEnd};
pub use gather::ResolvedCell;
pub use gloss::Gloss;
pub use gloss_trace::{AimedRay, NeighbourRay, encode_octahedral};
pub use lobe::Lobe;

use super::Level;
use glam::{IVec2, Vec2, Vec3};
use ssct_ground::math::{OracleVersion, constants};
use ssct_scenes::{Camera, GBufferData, ProjectionKind};

/// Twin of the parameter block in `parameters.glsl`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// M₀₀ and M₁₁ of the projection matrix, by which view-space x and y are scaled.
    pub view_to_clip: Vec2,
    /// 1 / width and 1 / height.
    pub pixel_to_clip: Vec2,
    /// `pixel_to_clip` divided by `view_to_clip`.
    pub pixel_to_view: Vec2,
    /// Size of the image in pixels.
    pub size: IVec2,
    /// Size of the pyramid in pixels: a multiple of the cells of its coarsest level.
    pub padded: IVec2,
    /// The pyramid's coarsest level.
    pub top_level: i32,
    /// near / (far − near), or 1 / (far − near) for an orthographic camera.
    pub depth_offset: f32,
    /// Shift of the image against the axis of the view, in half pixels.
    pub shift: Vec2,
    /// Reversed depth at z = 0 for an orthographic camera.
    pub depth_origin: f32,
    /// Metres from the lower to the upper side of the image for an orthographic camera.
    pub reach: f32,
    /// Kind of the projection; `ORTHOGRAPHIC` in the shader.
    pub kind: ProjectionKind,
}

impl Parameters {
    /// Returns the parameters for a camera and an image size in pixels, computed in f64 and rounded once.
    pub fn new(camera: &Camera, [width, height]: [u32; 2]) -> Self {
        let projection = camera.view_to_clip_reversed().as_dmat4();
        let to_clip = glam::DVec2::new(projection.x_axis.x, projection.y_axis.y);
        let size = glam::UVec2::new(width, height);
        let top_level = width.max(height).next_power_of_two().ilog2().min(6);
        let shift = if camera.kind().is_orthographic() { projection.w_axis } else { projection.z_axis };
        Self {
            view_to_clip: to_clip.as_vec2(),
            pixel_to_clip: (1.0 / size.as_dvec2()).as_vec2(),
            pixel_to_view: (1.0 / (size.as_dvec2() * to_clip)).as_vec2(),
            size: size.as_ivec2(),
            padded: glam::UVec2::from([width, height].map(|side| side.next_multiple_of(1 << top_level))).as_ivec2(),
            top_level: top_level as i32,
            depth_offset: -projection.z_axis.z as f32,
            shift: (size.as_dvec2() * shift.truncate().truncate()).as_vec2(),
            depth_origin: projection.w_axis.z as f32,
            reach: camera.reach_m(1.0) as f32,
            kind: camera.kind(),
        }
    }
}

/// An interval of reversed depth that a pixel's surface, or those of all pixels of a cell, fill.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// Nearest depth.
    pub front: f32,
    /// Farthest depth.
    pub back: f32,
}

impl Block {
    /// The block of sky, which no depth meets, since its front lies behind its back.
    pub const EMPTY: Self = Self { front: -1.0, back: 2.0 };

    /// Returns the smallest interval that contains both blocks.
    fn union(self, other: Self) -> Self {
        Self { front: self.front.max(other.front), back: self.back.min(other.back) }
    }
}

/// Twin of `Ray`: a straight line in (pixel x, pixel y, reversed depth).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Continuous pixel coordinates of the start: a pixel's centre on the screen, or any place of a face.
    pub start: Vec2,
    /// Pixel in which the ray begins.
    pub pixel: IVec2,
    /// Reversed depth of the start.
    pub depth: f32,
    /// Change of x, y and depth with s.
    pub rate: Vec3,
    /// 1 / rate.xy, or 1e30 where the rate is 0.
    pub inverse: Vec2,
    /// s at which the ray leaves the frustum.
    pub end: f32,
    /// Direction in view space, of any length.
    pub direction: Vec3,
}

/// How a ray ended; the values of `PATH_*`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HitCode {
    /// The ray met a pixel's block.
    Surface = constants::PATH_HI_Z as isize,
    /// The ray left the frustum.
    Miss = constants::PATH_MISS as isize,
    /// The ray ran out of steps, which must not happen.
    Unfinished = constants::PATH_UNFINISHED as isize,
    /// The ray met a block from behind (version 2 of the oracle).
    MissBehind = constants::PATH_MISS_BEHIND as isize,
}

/// Twin of `Hit` in `traverse.glsl`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// How the ray ended.
    pub code: HitCode,
    /// The pixel that was hit.
    pub pixel: IVec2,
    /// Continuous pixel coordinates of the hit, within `pixel`.
    pub position: Vec2,
    /// Reversed depth of the ray at the hit.
    pub depth: f32,
    /// Number of cells looked at.
    pub steps: i32,
    /// s of the hit, or of the end of a miss.
    pub s: f32,
}

/// Twin of `Walk`: the state of a ray's walk over the pyramid.
#[derive(Debug, Clone, Copy)]
struct Walk {
    /// Pixel that the ray is in.
    pixel: IVec2,
    /// Level of the cell that is looked at next; below 0, the ray has met the pixel's block.
    level: i32,
    /// s at which the ray enters the pixel.
    entry: f32,
    /// Reversed depth of the ray at `entry`.
    entry_depth: f32,
    /// Number of cells looked at.
    steps: i32,
}

/// How a walk treats blocks that hide the ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum WalkMode {
    /// The ray goes on behind blocks that it does not meet.
    Unfollowed,
    /// The ray is followed only while the image sees it: it meets a block as soon as it is behind the block's front.
    /// `passes` lets the ray through the first pixel of the walk; `border` is the last pixel of a face.
    Followed { passes: bool, border: IVec2 },
}

/// A cell that a ray looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Visit {
    /// Level of the pyramid.
    pub level: u32,
    /// Index of the cell: pixel >> level.
    pub cell: IVec2,
    /// Interval of depth that the cell holds.
    pub block: Block,
    /// Whether the ray's depth meets the block. If so, the walk goes down a level, or ends; otherwise it goes on to the
    /// next cell.
    pub meets: bool,
    /// s at which the ray enters and leaves the cell.
    pub span: [f32; 2],
}

impl Ray {
    /// Returns the continuous pixel coordinates and the reversed depth at s, which counts pixels along the faster axis.
    pub fn point_at(&self, s: f32) -> Vec3 {
        self.start.extend(self.depth) + s * self.rate
    }

    /// Twin of `Ahead`: returns, for each axis, 1 if the ray leaves a cell by its side of greater coordinates, else 0.
    fn ahead(&self) -> IVec2 {
        IVec2::new(i32::from(self.inverse.x > 0.0), i32::from(self.inverse.y > 0.0))
    }
}

/// Number that the shader uses for infinity.
const NEVER: f32 = constants::NEVER as f32;

/// The pyramid of one G-buffer, with the rays that walk over it.
#[derive(Debug, Clone)]
pub struct Traversal<'a> {
    gbuffer: &'a GBufferData,
    /// Parameters of the camera and the sizes.
    pub parameters: Parameters,
    /// Levels of the pyramid; level n has padded >> n cells along each axis.
    pub levels: Vec<Level<Block>>,
    /// Version of the oracle by whose rules rays hit.
    version: OracleVersion,
    /// Whether rays that the screen loses go on in captures (`FOLLOWED`).
    is_followed: bool,
}

impl<'a> Traversal<'a> {
    /// Builds the pyramid of a G-buffer. Rays hit by version 1 of the oracle until [`Self::of_version`] says otherwise.
    pub fn new(gbuffer: &'a GBufferData) -> Self {
        let parameters = Parameters::new(&gbuffer.camera, [gbuffer.width, gbuffer.height]);
        let [width, height] = parameters.padded.as_uvec2().to_array();
        let mut levels = vec![Level::from_fn(width, height, |x, y| {
            blocks::depth_block(gbuffer, &parameters, IVec2::new(x as i32, y as i32))
        })];
        for level in 0..parameters.top_level as usize {
            let finer = &levels[level];
            levels.push(Level::from_fn(finer.width / 2, finer.height / 2, |x, y| {
                let block = |dx, dy| finer.at_clamped(2 * x + dx, 2 * y + dy);
                block(0, 0).union(block(1, 0)).union(block(0, 1).union(block(1, 1)))
            }));
        }
        Self { gbuffer, parameters, levels, version: OracleVersion::V1, is_followed: false }
    }

    /// Returns the traversal for rays that are followed in captures after the screen loses them (`FOLLOWED`). They hit
    /// by version 2 of the oracle.
    pub fn followed(self) -> Self {
        Self { version: OracleVersion::V2, is_followed: true, ..self }
    }

    /// Returns the traversal by the rules of the given version of the oracle.
    pub fn of_version(self, version: OracleVersion) -> Self {
        Self { version, ..self }
    }

    /// Twin of `MirrorRay`: returns the mirror ray of a pixel, and whether the pixel is seen from its normal's side.
    /// `None` for sky or without a normal.
    pub fn mirror_ray(&self, x: u32, y: u32) -> Option<(Ray, bool)> {
        let (parameters, index) = (&self.parameters, self.gbuffer.index(x, y));
        let (pixel, depth) = (IVec2::new(x as i32, y as i32), self.levels[0].at_clamped(x, y).front);
        let normal = self.gbuffer.normal[index];
        if depth <= 0.0 || normal == Vec3::ZERO {
            return None;
        }
        // The mirror direction is v + factor · normal. The line of sight v itself does not move in the image.
        let (view, ndc) = self.pixel_point(pixel);
        let along_normal = view.x * normal.x + view.y * normal.y + normal.z;
        let squared = normal.x * normal.x + normal.y * normal.y + normal.z * normal.z;
        let factor = -2.0 * along_normal * (1.0 / squared);
        let change = parameters.ndc_change(ndc, normal) * factor;
        let change_z = parameters.depth_change(depth, 1.0 + factor * normal.z);
        let direction = view.extend(1.0) + factor * normal;
        let ray = self.make_ray(pixel.as_vec2() + 0.5, pixel, depth, direction, change.extend(change_z));
        Some((ray, along_normal < 0.0))
    }

    /// Twin of `RayAlong`: returns the ray of pixel (x, y) along a view-space direction of any length; `None` for sky.
    pub fn ray_along(&self, x: u32, y: u32, direction: Vec3) -> Option<Ray> {
        let (parameters, pixel) = (&self.parameters, IVec2::new(x as i32, y as i32));
        let depth = self.levels[0].at_clamped(x, y).front;
        let (_, ndc) = self.pixel_point(pixel);
        let change = parameters.ndc_change(ndc, direction);
        let change_z = parameters.depth_change(depth, direction.z);
        let start = pixel.as_vec2() + 0.5;
        (depth > 0.0).then(|| self.make_ray(start, pixel, depth, direction, change.extend(change_z)))
    }

    /// Twin of `PixelPoint`: returns x and y of the view-space direction in which a pixel is seen, where z is 1, and
    /// the pixel's place as ndc from the view's axis.
    fn pixel_point(&self, pixel: IVec2) -> (Vec2, Vec2) {
        let p = &self.parameters;
        let centre = IVec2::new(2 * pixel.x + 1 - p.size.x, p.size.y - 2 * pixel.y - 1).as_vec2() - p.shift;
        let view = if p.kind.is_orthographic() { Vec2::ZERO } else { centre * p.pixel_to_view };
        (view, centre * p.pixel_to_clip)
    }

    /// Twin of `MakeRay`: returns a ray from the place `start` in a pixel along a view-space direction. `change` is
    /// that direction as a change of (ndc x, ndc y, depth). A ray that does not move in the image ends at s = 0.
    fn make_ray(&self, start: Vec2, pixel: IVec2, depth: f32, direction: Vec3, change: Vec3) -> Ray {
        let size = self.parameters.size;
        let moved = change.truncate() * size.as_vec2() * Vec2::new(0.5, -0.5);
        let fastest = moved.x.abs().max(moved.y.abs());
        if fastest.is_nan() || fastest <= 1e-30 {
            let rate = Vec3::new(0.0, 0.0, change.z);
            return Ray { start, pixel, depth, rate, inverse: Vec2::splat(NEVER), end: 0.0, direction };
        }
        let scale = 1.0 / fastest;
        let (rate, depth_rate) = (moved * scale, change.z * scale);
        let invert = |v: f32| if v.abs() > 1.0 / NEVER { 1.0 / v } else { NEVER };
        let depth_inverse = invert(depth_rate);
        let inverse = Vec2::new(invert(rate.x), invert(rate.y));
        let side = IVec2::new(if inverse.x > 0.0 { size.x } else { 0 }, if inverse.y > 0.0 { size.y } else { 0 });
        let side_s = (side.as_vec2() - start) * inverse;
        let plane_s = ((if depth_inverse > 0.0 { 1.0 } else { 0.0 }) - depth) * depth_inverse;
        let end = side_s.x.min(side_s.y).min(plane_s);
        Ray { start, pixel, depth, rate: rate.extend(depth_rate), inverse, end, direction }
    }

    /// Twin of `MaxSteps`: returns the greatest number of steps of a walk over the screen. Each step goes forward by a
    /// pixel or more along either axis, or down a level; only steps forward go up, so that no more steps go down.
    pub fn max_steps(&self) -> i32 {
        2 * (self.parameters.size.x + self.parameters.size.y)
    }

    /// Twin of `MaxSteps` with `FACES`, for a walk over a face. It adds a step for each pixel that the ray passes
    /// inside a block, and the steps down from the level at which the walk begins.
    pub fn max_face_steps(&self) -> i32 {
        3 * (self.parameters.size.x + self.parameters.size.y) + constants::FACE_LEVEL
    }

    /// Returns the number of steps of the mirror ray of a pixel; `None` for a pixel that does not reflect.
    pub fn mirror_steps(&self, x: u32, y: u32) -> Option<u32> {
        let (ray, _) = self.mirror_ray(x, y).filter(|_| self.gbuffer.reflects(self.gbuffer.index(x, y)))?;
        Some(self.traverse(&ray).steps.max(0) as u32)
    }

    /// Twin of `Traverse`: follows the ray over the pyramid until it hits a block or ends, and returns how it ends.
    pub fn traverse(&self, ray: &Ray) -> Hit {
        self.walk(ray, |_| {})
    }

    /// Traces a ray as [`Self::traverse`] does, and calls `visit` for every cell that is looked at.
    pub fn walk(&self, ray: &Ray, visit: impl FnMut(Visit)) -> Hit {
        let (pixel, position) = (ray.pixel, Vec2::ZERO);
        let hit = Hit { code: HitCode::Miss, pixel, position, depth: 0.0, steps: 0, s: ray.end };
        let ahead = ray.ahead();
        // The first step leaves the starting pixel without looking at it.
        let side_s = (ahead.as_vec2() - 0.5) * ray.inverse;
        let entry = side_s.x.min(side_s.y);
        if entry.is_nan() || entry >= ray.end {
            return hit;
        }
        let at_side = (ray.start + entry * ray.rate.truncate()).as_ivec2();
        let next_pixel = ray.pixel + 2 * ahead - 1;
        let pixel = IVec2::new(
            if side_s.x == entry { next_pixel.x } else { at_side.x },
            if side_s.y == entry { next_pixel.y } else { at_side.y },
        );
        let mut entry_depth = ray.depth + entry * ray.rate.z;
        let leaves_surface = self.version == OracleVersion::V2 && dot(ray.direction, self.normal(pixel)) > 0.0;
        // The first pixel may show the surface that the ray leaves. A depth beyond all others then meets nothing there.
        if leaves_surface && !self.is_followed {
            entry_depth = if ray.rate.z < 0.0 { -NEVER } else { NEVER };
        }
        let mut walk = Walk { pixel, level: 0, entry, entry_depth, steps: 0 };
        let border = IVec2::MAX;
        let mode =
            if self.is_followed { WalkMode::Followed { passes: leaves_surface, border } } else { WalkMode::Unfollowed };
        self.advance(ray, ahead, mode, &mut walk, visit);
        let hit = Hit { steps: walk.steps, ..hit };
        // At level 0 or above, the walk has met no pixel's block: the ray has ended, or has run out of steps.
        if walk.level >= 0 {
            return Hit { code: if walk.entry < ray.end { HitCode::Unfinished } else { HitCode::Miss }, ..hit };
        }
        let (block, entry_depth) = (self.block(walk.pixel), walk.entry_depth);
        let is_behind = self.version == OracleVersion::V2
            && hit.steps > 1
            && entry_depth < block.front
            && self.is_behind(ray, entry_depth, walk.pixel, block, ahead);
        let exit_depth = ray.depth + pixel_exit(ray, &walk, ahead) * ray.rate.z;
        // The ray passes behind the block by the rule of version 2, or is followed and lies wholly behind the block.
        if is_behind || (self.is_followed && entry_depth.max(exit_depth) < block.back) {
            return Hit { code: HitCode::MissBehind, s: walk.entry, ..hit };
        }
        let s = front_crossing(ray, &walk, ahead, block.front);
        let first_corner = (walk.pixel - ray.pixel).as_vec2();
        let offset = (s * ray.rate.truncate() + 0.5).max(first_corner).min(first_corner + 1.0);
        let position = ray.pixel.as_vec2() + offset;
        Hit { code: HitCode::Surface, pixel: walk.pixel, position, depth: ray.depth + s * ray.rate.z, s, ..hit }
    }

    /// Twin of `Advance`: walks on until the ray meets a block, which sets the level below 0, or the ray ends. `ahead`
    /// is [`Ray::ahead`]; `visit` is called for each cell looked at.
    fn advance(&self, ray: &Ray, ahead: IVec2, mode: WalkMode, walk: &mut Walk, mut visit: impl FnMut(Visit)) {
        let (start, recedes) = (ray.start, ray.rate.z < 0.0);
        let (mut passes, border, is_followed) = match mode {
            WalkMode::Unfollowed => (false, IVec2::MAX, false),
            WalkMode::Followed { passes, border } => (passes, border, true),
        };
        let max_steps = if border == IVec2::MAX { self.max_steps() } else { self.max_face_steps() };
        while walk.level >= 0 && walk.entry < ray.end && walk.steps < max_steps {
            walk.steps += 1;
            let level = walk.level;
            let cell = walk.pixel >> level;
            let cells = &self.levels[level as usize];
            let block = cells.texels[(cell.y as u32 * cells.width + cell.x as u32) as usize];
            let edge = (cell + ahead) << level;
            let crossings = (edge.as_vec2() - start) * ray.inverse;
            let exit = crossings.x.min(crossings.y);
            let last_s = exit.min(ray.end);
            let exit_depth = ray.depth + last_s * ray.rate.z;
            let (near, far) = if recedes { (walk.entry_depth, exit_depth) } else { (exit_depth, walk.entry_depth) };
            let meets = far <= block.front && if is_followed { !passes } else { near >= block.back };
            passes = false;
            visit(Visit { level: level as u32, cell, block, meets, span: [walk.entry, last_s] });
            // The next pixel lies across the side that is nearer, and along the other axis where the ray is then.
            let inside = (start + last_s * ray.rate.truncate()).as_ivec2();
            let first = cell << level;
            let mut next_pixel = inside.clamp(first, first + ((1 << level) - 1)).min(border);
            if crossings.x == exit {
                next_pixel.x = edge.x - 1 + ahead.x;
            }
            if crossings.y == exit {
                next_pixel.y = edge.y - 1 + ahead.y;
            }
            let left_parent = (if crossings.x <= crossings.y { edge.x } else { edge.y }) & (1 << level) == 0;
            if meets {
                walk.level -= 1;
            } else {
                if left_parent {
                    walk.level = (level + 1).min(self.parameters.top_level);
                }
                (walk.pixel, walk.entry, walk.entry_depth) = (next_pixel, exit, exit_depth);
            }
        }
    }

    /// Returns the block of a pixel.
    fn block(&self, pixel: IVec2) -> Block {
        self.levels[0].at_clamped(pixel.x as u32, pixel.y as u32)
    }

    /// Returns the normal of a pixel, or zero beyond the image: rounding may put the first pixel of a ray through a
    /// corner there.
    fn normal(&self, pixel: IVec2) -> Vec3 {
        let is_inside = pixel.cmpge(IVec2::ZERO).all() && pixel.cmplt(self.parameters.size).all();
        if is_inside { self.gbuffer.normal[self.gbuffer.index(pixel.x as u32, pixel.y as u32)] } else { Vec3::ZERO }
    }

    /// Twin of `IsBehind`: returns whether a ray that enters a pixel at `entry_depth`, behind the front of its block,
    /// passes behind the block and does not hit it (version 2 of the oracle). It does if it was behind the front of the
    /// pixel before, or, at an edge, if it is deeper in the block than the thickness times the cosine between ray and
    /// reversed normal.
    fn is_behind(&self, ray: &Ray, entry_depth: f32, pixel: IVec2, block: Block, ahead: IVec2) -> bool {
        let block_before = self.block(pixel_before(ray, pixel, ahead));
        let (direction, normal) = (ray.direction, self.normal(pixel));
        let thickness = block.front - block.back;
        let joined_gap = constants::JOINED as f32 * (thickness + (block_before.front - block_before.back));
        let (along_normal, depth_in_block) = (dot(direction, normal), block.front - entry_depth);
        let depth_squared = (depth_in_block * depth_in_block) * (dot(normal, normal) * dot(direction, direction));
        let is_deep = along_normal >= 0.0 || depth_squared > (along_normal * along_normal) * (thickness * thickness);
        entry_depth < block_before.front || (block.front - block_before.front > joined_gap && is_deep)
    }
}

/// Twin of `PixelBefore`: returns the pixel that a ray leaves as it enters `pixel`, across the boundary that it crosses
/// last. `ahead` is [`Ray::ahead`].
fn pixel_before(ray: &Ray, pixel: IVec2, ahead: IVec2) -> IVec2 {
    let entry_s = ((pixel + 1 - ahead).as_vec2() - ray.start) * ray.inverse;
    let back = 1 - 2 * ahead;
    pixel + IVec2::new(if entry_s.x >= entry_s.y { back.x } else { 0 }, if entry_s.y >= entry_s.x { back.y } else { 0 })
}

/// Twin of `PixelExit`: returns the ray's parameter s where it ends or leaves the walk's current pixel.
fn pixel_exit(ray: &Ray, walk: &Walk, ahead: IVec2) -> f32 {
    let crossings = ((walk.pixel + ahead).as_vec2() - ray.start) * ray.inverse;
    crossings.x.min(crossings.y).min(ray.end).max(walk.entry)
}

/// Twin of `FrontCrossing`: returns the parameter s where the ray crosses the depth `front` inside the walk's current
/// pixel, or where it enters the pixel if it does not.
fn front_crossing(ray: &Ray, walk: &Walk, ahead: IVec2, front: f32) -> f32 {
    let exit = pixel_exit(ray, walk, ahead);
    let exit_depth = ray.depth + exit * ray.rate.z;
    let (near, far) = (walk.entry_depth.max(exit_depth), walk.entry_depth.min(exit_depth));
    let crossing = (front - ray.depth) * (1.0 / ray.rate.z);
    if far <= front && front <= near && far < near { crossing.max(walk.entry).min(exit) } else { walk.entry }
}

/// Twin of `Dot`: returns the scalar product, whose terms are added in the shader's order.
fn dot(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// The greatest 16-bit float.
const GREATEST: f32 = constants::GREATEST_HALF as f32;

/// Twin of `Sound`: returns a value of a colour that can be summed and stored in 16 bits: at most the greatest half,
/// and 0 for negative values and NaN.
fn sound(value: f32) -> f32 {
    if value > 0.0 { value.min(GREATEST) } else { 0.0 }
}

/// Rounds a value to the nearest 16-bit float.
fn half(value: f32) -> f32 {
    half::f16::from_f32(value).to_f32()
}

#[cfg(test)]
mod tests;
