//! The oracle of images (docs/definitions.md, "Images"): finds what a reflection ray hits in the screen and in captures
//! by examining every pixel on its path, in f64. The code is slow, short and meant to be read.
//!
//! The screen is one image of the scene, and each face of a capture is another. In each image the ray is a straight line over a
//! field of blocks, as in [`super::oracle`].
//!
//! - **The screen** gives the hits of version 2 of the oracle while it sees the ray. The screen loses the ray at the
//!   first pixel whose block the ray passes behind, or where a miss ends. A ray that leaves through the far plane ends
//!   in the sky. Any other ray that hits nothing is followed in captures, from where the screen lost it.
//! - **A capture sees a point** if the point is not behind the back of its block there, and not before the near plane.
//!   A lost ray goes on in the nearest capture that sees the point where it was lost.
//! - **A face follows a ray** until the ray leaves it or is behind the front of a block. A ray that leaves by a side goes on in
//!   the next face, through the far plane it ends in the sky, and through the near plane it is lost. A ray behind the front of
//!   a block that runs along the normal there passes inside the block, because it leaves that surface; behind the block's back
//!   it is lost. A ray that runs against the normal hits if it was in front of the block where it entered the pixel.
//!   Such a ray also hits if it came through the joint to the previous pixel's block, by the rule of version 2 of the
//!   oracle; else the ray is lost. A ray that begins inside the block hits at once. A ray from another face also hits
//!   if it is behind the block by no more than the thickness of that face's last block. The ray then came through the
//!   joint of a surface that both faces show.
//! - **A ray that a capture lost** goes on in the nearest other capture that sees the point where it was lost. A capture in
//!   which the ray did not advance is left out until the ray advances in another. If no capture is left, the end of the ray is
//!   unknown.
//! - **Outside the scene's bounds** there is no surface, so that a ray that an image lost there ends in the sky.

use super::capture_data::CaptureData;
use super::oracle::{self, Oracle, PassedPixel};
use super::ray::{MissReason, Segment};
use super::thickness::DepthBlock;
use glam::{DMat3, DVec3};
use ssct_ground::math::constants::LEAST_ADVANCE_M;
use ssct_scenes::{Aabb, GBufferData};

/// Where a ray ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EndInImages {
    /// On the screen: continuous pixel coordinates and reversed depth.
    Screen(DVec3),
    /// In a capture.
    Capture {
        /// The index of the capture.
        index: usize,
        /// Where the ray hits, relative to the eye, in world axes, in metres.
        place: DVec3,
        /// Width of a texel of the capture at the hit, in metres.
        texel_m: f64,
    },
    /// In the sky.
    Sky,
    /// At a place that no image sees.
    Unknown,
}

/// A ray that the screen lost, from where it was lost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExactLostRay {
    /// Where the screen lost the ray, relative to the eye, in world axes, in metres.
    pub start: DVec3,
    /// Unit direction in world axes.
    pub direction: DVec3,
}

/// Result of following a ray on the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ScreenRayEnd {
    /// There is no ray, or the ray runs below the surface that it leaves.
    NoRay,
    /// The ray ends on the screen or in the sky.
    Ends(EndInImages),
    /// The screen loses the ray.
    Loses(ExactLostRay),
}

/// The oracle of the screen and of some captures.
#[derive(Debug, Clone)]
pub struct ImageOracle<'a> {
    screen: Oracle<'a>,
    view_to_world: DMat3,
    captures: Vec<Cube<'a>>,
    /// The corners of the scene's bounds relative to the eye.
    bounds: [DVec3; 2],
}

/// A capture.
#[derive(Debug, Clone)]
struct Cube<'a> {
    /// Place relative to the eye.
    place: DVec3,
    faces: Vec<Face<'a>>,
}

/// A face of a capture.
#[derive(Debug, Clone)]
struct Face<'a> {
    image: Oracle<'a>,
    view_to_world: DMat3,
}

/// Result of following a ray in a face or a capture.
#[derive(Debug, Clone, Copy, PartialEq)]
enum FollowEnd {
    /// The ray hits a block.
    Hit,
    /// The ray leaves through the far plane.
    Sky,
    /// The face or the capture does not show where the ray goes.
    Lost,
    /// The ray left a face by a side.
    On {
        /// Axis, in the capture, of the side by which the ray left.
        side: DVec3,
        /// Thickness, in reversed depth, of the last block that the ray passed.
        thickness: f64,
    },
}

impl<'a> ImageOracle<'a> {
    /// Makes the images of the screen's G-buffer and of some captures.
    pub fn new(screen: &'a GBufferData, captures: &'a [CaptureData]) -> Self {
        let view_to_world = |data: &GBufferData| DMat3::from_mat4(data.camera.world_to_view.as_dmat4().inverse());
        let eye = screen.camera.world_to_view.as_dmat4().inverse().w_axis.truncate();
        let face = |data: &'a GBufferData| Face { image: Oracle::new(data), view_to_world: view_to_world(data) };
        let cube =
            |c: &'a CaptureData| Cube { place: c.place.as_dvec3() - eye, faces: c.faces.iter().map(face).collect() };
        Self {
            screen: Oracle::new(screen),
            view_to_world: view_to_world(screen),
            captures: captures.iter().map(cube).collect(),
            bounds: [DVec3::MIN, DVec3::MAX],
        }
    }

    /// Sets a box in the world, in metres, outside of which there is no surface.
    pub fn with_bounds(self, bounds: Aabb) -> Self {
        let eye = self.screen.rays.gbuffer.camera.world_to_view.as_dmat4().inverse().w_axis.truncate();
        Self { bounds: [bounds.min, bounds.max].map(|corner| corner.as_dvec3() - eye), ..self }
    }

    /// Where the mirror ray of a pixel ends; `None` if there is no ray, or if the ray runs below the surface.
    pub fn trace(&self, x: u32, y: u32) -> Option<EndInImages> {
        self.end(self.trace_screen(x, y))
    }

    /// Where the ray ends, given the result on the screen.
    pub fn end(&self, on_screen: ScreenRayEnd) -> Option<EndInImages> {
        match on_screen {
            ScreenRayEnd::NoRay => None,
            ScreenRayEnd::Ends(end) => Some(end),
            ScreenRayEnd::Loses(lost) => Some(self.follow(&lost)),
        }
    }

    /// The mirror direction of a pixel in view space.
    pub fn mirror(&self, x: u32, y: u32) -> Option<DVec3> {
        self.screen.rays.mirror(x, y)
    }

    /// Follows the mirror ray of a pixel on the screen.
    pub fn trace_screen(&self, x: u32, y: u32) -> ScreenRayEnd {
        let rays = &self.screen.rays;
        let direction = rays.mirror(x, y).filter(|d| rays.normal(x, y).is_some_and(|n| n.dot(*d) > 0.0));
        direction.map_or(ScreenRayEnd::NoRay, |direction| self.trace_screen_along(x, y, direction))
    }

    /// Follows a ray on the screen, from a pixel's centre along a view-space direction of any length.
    pub fn trace_screen_along(&self, x: u32, y: u32, direction: DVec3) -> ScreenRayEnd {
        let rays = &self.screen.rays;
        let Some(segment) = rays.segment(x, y, direction) else { return ScreenRayEnd::NoRay };
        let mut lost_at = None;
        for (steps, passed) in self.screen.pixels(&segment).enumerate().skip(1) {
            let PassedPixel { pixel, last: Some(last), entry, exit } = passed else { continue };
            let block = self.screen.block(pixel).unwrap_or(DepthBlock::EMPTY);
            let along = self.screen.along_normal(pixel, &segment);
            if steps == 1 && along > 0.0 {
                continue;
            }
            let [first, nearest] = [segment.depth_at(entry), segment.depth_at(entry).max(segment.depth_at(exit))];
            let is_behind = nearest < block.back && block != DepthBlock::EMPTY;
            let met = oracle::meets(&segment, block, entry, exit);
            if is_behind || met.is_some() && steps > 1 && self.screen.comes_from_behind(first, last, block, along) {
                lost_at = Some(entry);
                break;
            }
            if let Some((s, _)) = met {
                return ScreenRayEnd::Ends(EndInImages::Screen(segment.point_at(s)));
            }
        }
        if lost_at.is_none() && segment.end == MissReason::Far {
            return ScreenRayEnd::Ends(EndInImages::Sky);
        }
        let start = self.view_to_world * rays.unproject(segment.point_at(lost_at.unwrap_or(1.0)));
        ScreenRayEnd::Loses(ExactLostRay { start, direction: self.view_to_world * segment.direction })
    }

    /// Where a ray ends that the screen lost, by following it in captures.
    pub fn follow(&self, lost: &ExactLostRay) -> EndInImages {
        let (mut point, mut excluded) = (lost.start, Vec::new());
        loop {
            if self.is_outside_scene(point) {
                return EndInImages::Sky;
            }
            let Some(index) = self.nearest_seeing_capture(point, &excluded) else { return EndInImages::Unknown };
            let cube = &self.captures[index];
            let (how, offset) = cube.follow(point - cube.place, lost.direction);
            let place = offset + cube.place;
            let gone = |to: DVec3| (to - lost.start).dot(lost.direction);
            match how {
                FollowEnd::Sky => return EndInImages::Sky,
                FollowEnd::Hit => return EndInImages::Capture { index, place, texel_m: cube.texel_m(offset) },
                _ => {}
            }
            if gone(place) > gone(point) + LEAST_ADVANCE_M {
                excluded.clear();
                point = place;
            }
            excluded.push(index);
        }
    }

    /// Whether a point, relative to the eye, lies outside the scene's bounds.
    fn is_outside_scene(&self, point: DVec3) -> bool {
        let [least, greatest] = self.bounds;
        point.cmplt(least).any() || point.cmpgt(greatest).any()
    }

    /// The index of the nearest capture that sees a point, given relative to the eye, among those that are not
    /// excluded.
    fn nearest_seeing_capture(&self, point: DVec3, excluded: &[usize]) -> Option<usize> {
        let distance = |index: &usize| self.captures[*index].place.distance(point);
        let seeing = (0..self.captures.len()).filter(|index| !excluded.contains(index));
        seeing
            .filter(|index| self.captures[*index].sees(point - self.captures[*index].place))
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}

impl Cube<'_> {
    /// The face in which a direction lies: the face along whose axis the direction reaches farthest.
    fn cube_face(&self, direction: DVec3) -> &Face<'_> {
        let along = |face: &&Face| face.view_to_world.z_axis.dot(direction);
        let farthest = self.faces.iter().max_by(|a, b| along(a).total_cmp(&along(b)));
        farthest.unwrap_or(&self.faces[0])
    }

    /// Width of a texel at a place relative to the capture's place, in metres.
    fn texel_m(&self, point: DVec3) -> f64 {
        2.0 * point.abs().max_element() / f64::from(self.faces[0].image.rays.gbuffer.width)
    }

    /// Whether the capture sees a point, given relative to the capture's place: the point lies beyond the near plane,
    /// and not behind the back of the block in its texel. A texel without a block hides nothing.
    fn sees(&self, point: DVec3) -> bool {
        let face = self.cube_face(point);
        let image = &face.image;
        let Some(position) = image.rays.project(face.to_view(point)) else { return false };
        let side = image.rays.gbuffer.width as i32;
        let pixel = [0, 1].map(|axis| (position[axis].floor() as i32).clamp(0, side - 1));
        let block = image.block(pixel).unwrap_or(DepthBlock::EMPTY);
        position.z < 1.0 && (block == DepthBlock::EMPTY || position.z >= block.back)
    }

    /// Follows a ray from face to face, beginning at a point that the capture sees. Returns how the ray ends, and the
    /// place of its end; both places are relative to the capture's.
    fn follow(&self, point: DVec3, direction: DVec3) -> (FollowEnd, DVec3) {
        let (mut face, mut position, mut before) = (self.cube_face(point), point, 0.0);
        // A line crosses each of the six planes between faces at most once.
        for _ in 0..7 {
            let (how, reached) = face.follow(position, direction, before);
            position = reached;
            let FollowEnd::On { side, thickness } = how else { return (how, position) };
            (face, before) = (self.cube_face(side), thickness);
        }
        (FollowEnd::Lost, position)
    }
}

impl Face<'_> {
    /// Turns a vector from world axes to the face's view axes.
    fn to_view(&self, v: DVec3) -> DVec3 {
        self.view_to_world.transpose() * v
    }

    /// Follows a ray over the face, from a point in it. Returns how the ray ends, and the place of its end. Point,
    /// direction and place are in world axes, and points are relative to the capture's place. `before` is the thickness
    /// of the block at which the ray left the previous face, or 0.
    fn follow(&self, point: DVec3, direction: DVec3, before: f64) -> (FollowEnd, DVec3) {
        let (image, rays) = (&self.image, &self.image.rays);
        let Some(segment) = rays.segment_from(self.to_view(point), self.to_view(direction)) else {
            return (FollowEnd::Lost, point);
        };
        if segment.start.z >= 1.0 {
            return (FollowEnd::Lost, point);
        }
        let place = |s: f64| self.view_to_world * rays.unproject(segment.point_at(s));
        let mut thickness = 0.0;
        for PassedPixel { pixel, last, entry, exit } in image.pixels(&segment) {
            let block = image.block(pixel).unwrap_or(DepthBlock::EMPTY);
            thickness = block.thickness();
            let (first, deepest) = (segment.depth_at(entry), segment.depth_at(entry).min(segment.depth_at(exit)));
            if deepest > block.front {
                continue;
            }
            let along = image.along_normal(pixel, &segment);
            let is_inside = first >= block.back;
            if along > 0.0 && is_inside {
                continue;
            }
            let is_lost = match last {
                _ if along > 0.0 => true,
                Some(last) => image.comes_from_behind(first, last, block, along),
                None => first < block.back - before,
            };
            if is_lost {
                return (FollowEnd::Lost, place(entry));
            }
            let s = oracle::meets(&segment, block, entry, exit).map_or(entry, |(s, _)| s);
            return (FollowEnd::Hit, place(s));
        }
        let how = match segment.end {
            MissReason::LeftScreen => FollowEnd::On { side: self.side_at(&segment), thickness },
            MissReason::Far => FollowEnd::Sky,
            _ => FollowEnd::Lost,
        };
        (how, place(1.0))
    }

    /// The direction, in world axes, of the side through which a segment leaves the face.
    fn side_at(&self, segment: &Segment) -> DVec3 {
        let (end, side) = (segment.point_at(1.0), f64::from(self.image.rays.gbuffer.width));
        let sides = [
            (end.x, DVec3::NEG_X, segment.delta.x < 0.0),
            (side - end.x, DVec3::X, segment.delta.x > 0.0),
            (end.y, DVec3::Y, segment.delta.y < 0.0),
            (side - end.y, DVec3::NEG_Y, segment.delta.y > 0.0),
        ];
        let left = sides.into_iter().filter(|(.., towards)| *towards).min_by(|a, b| a.0.total_cmp(&b.0));
        self.view_to_world * left.map_or(DVec3::X, |(_, axis, _)| axis)
    }
}

#[cfg(test)]
mod tests;
