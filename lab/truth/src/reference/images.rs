//! The oracle of images (docs/definitions.md, "Images"): finds where a reflection ray hits in the screen and in
//! captures by examining every pixel on its path, in f64. The code is slow, short and meant to be read.
//!
//! The screen is one image of the scene, and each face of a capture is another. In each image the ray is a straight
//! line over a field of blocks, as in [`super::oracle`].
//!
//! - **The screen** shows where a ray hits by version 2 of the oracle, as long as it sees the ray. The screen loses a
//!   ray at the first pixel whose block the ray passes behind, or where a miss ends. A ray that leaves through the far
//!   plane ends in the sky. Any other ray that hits nothing is followed in captures, from where the screen lost it.
//! - **A capture sees a point** if the point is not behind the back of the block in its texel, and not before the near
//!   plane. A lost ray goes on in the nearest capture that sees the point where it was lost.
//! - **A face follows a ray** until the ray leaves the face or is behind the front of a block. A ray that leaves by a
//!   side goes on in the next face. A ray that leaves through the far plane ends in the sky, and one that leaves
//!   through the near plane is lost.
//! - **Behind the front of a block**, a ray that runs along the normal leaves that surface: inside the block it goes
//!   on, and behind the block's back it is lost. A ray that runs against the normal hits if it was in front of the
//!   block where it entered the pixel. Such a ray also hits if it came through the joint to the previous pixel's block,
//!   by the rule of version 2 of the oracle; else the ray is lost. A ray that begins inside the block hits at once. A
//!   ray from another face also hits if it is behind the block by no more than the thickness of that face's last block.
//!   Such a ray came through the joint of a surface that both faces show.
//! - **A ray that a capture lost** goes on in the nearest other capture that sees the point where it was lost. A
//!   capture in which the ray did not advance is left out until the ray advances in another. If no capture is left, the
//!   end of the ray is unknown.
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

/// A ray that the screen lost, from the place where it was lost. The name tells it from the f32 twin's lost ray.
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
    /// Rotation from the screen's view axes to world axes.
    view_to_world: DMat3,
    captures: Vec<Cube<'a>>,
    /// The least and the greatest corner of the scene's bounds, relative to the eye, in metres.
    bounds: [DVec3; 2],
}

/// A capture, with the oracles of its six faces.
#[derive(Debug, Clone)]
struct Cube<'a> {
    /// Place relative to the eye, in world axes, in metres.
    place: DVec3,
    faces: Vec<Face<'a>>,
}

/// A face of a capture.
#[derive(Debug, Clone)]
struct Face<'a> {
    /// The oracle of the face's image, which has its blocks.
    image: Oracle<'a>,
    /// Rotation from the face's view axes to world axes.
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
    /// The ray left a face by a side, and goes on in the next face.
    NextFace {
        /// World axis that points out of the side by which the ray left.
        side: DVec3,
        /// Thickness, in reversed depth, of the last block that the ray passed.
        thickness: f64,
    },
}

impl<'a> ImageOracle<'a> {
    /// Makes the oracle of the screen's G-buffer and of some captures. There are no bounds until [`Self::with_bounds`]
    /// sets them.
    pub fn new(screen: &'a GBufferData, captures: &'a [CaptureData]) -> Self {
        let view_to_world = |data: &GBufferData| DMat3::from_mat4(data.camera.world_to_view.as_dmat4().inverse());
        let eye = screen.camera.world_to_view.as_dmat4().inverse().w_axis.truncate();
        let face = |data: &'a GBufferData| Face { image: Oracle::new(data), view_to_world: view_to_world(data) };
        let cube = |data: &'a CaptureData| Cube {
            place: data.place.as_dvec3() - eye,
            faces: data.faces.iter().map(face).collect(),
        };
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

    /// Returns where the mirror ray of pixel (x, y) ends; `None` if there is no ray, or if the ray runs below the
    /// surface.
    pub fn trace(&self, x: u32, y: u32) -> Option<EndInImages> {
        self.end(self.trace_screen(x, y))
    }

    /// Returns where a ray ends, given how it ended on the screen: a ray that the screen lost is followed in captures.
    /// `None` if there is no ray.
    pub fn end(&self, on_screen: ScreenRayEnd) -> Option<EndInImages> {
        match on_screen {
            ScreenRayEnd::NoRay => None,
            ScreenRayEnd::Ends(end) => Some(end),
            ScreenRayEnd::Loses(lost) => Some(self.follow(&lost)),
        }
    }

    /// Returns the unit mirror direction of pixel (x, y) in view space; `None` for sky or without a normal.
    pub fn mirror(&self, x: u32, y: u32) -> Option<DVec3> {
        self.screen.rays.mirror(x, y)
    }

    /// Follows the mirror ray of pixel (x, y) on the screen.
    pub fn trace_screen(&self, x: u32, y: u32) -> ScreenRayEnd {
        let rays = &self.screen.rays;
        let direction =
            rays.mirror(x, y).filter(|mirror| rays.normal(x, y).is_some_and(|normal| normal.dot(*mirror) > 0.0));
        direction.map_or(ScreenRayEnd::NoRay, |direction| self.trace_screen_along(x, y, direction))
    }

    /// Follows a ray on the screen, from the centre of pixel (x, y) along a view-space direction of any length.
    pub fn trace_screen_along(&self, x: u32, y: u32, direction: DVec3) -> ScreenRayEnd {
        let rays = &self.screen.rays;
        let Some(segment) = rays.segment(x, y, direction) else { return ScreenRayEnd::NoRay };
        // The ray's parameter s (0 to 1) where the screen loses it behind a block.
        let mut lost_s = None;
        for (pixels_passed, passed) in self.screen.pixels(&segment).enumerate().skip(1) {
            let PassedPixel { pixel, previous: Some(previous), entry, exit } = passed else { continue };
            let block = self.screen.block(pixel).unwrap_or(DepthBlock::EMPTY);
            let normal_cosine = self.screen.along_normal(pixel, &segment);
            // The first pixel after the start belongs to the surface that the ray leaves.
            if pixels_passed == 1 && normal_cosine > 0.0 {
                continue;
            }
            let [entry_depth, nearest_depth] =
                [segment.depth_at(entry), segment.depth_at(entry).max(segment.depth_at(exit))];
            let is_behind = nearest_depth < block.back && block != DepthBlock::EMPTY;
            let meeting = oracle::meets(&segment, block, entry, exit);
            let from_behind =
                pixels_passed > 1 && self.screen.comes_from_behind(entry_depth, previous, block, normal_cosine);
            if is_behind || (meeting.is_some() && from_behind) {
                lost_s = Some(entry);
                break;
            }
            if let Some((s, _)) = meeting {
                return ScreenRayEnd::Ends(EndInImages::Screen(segment.point_at(s)));
            }
        }
        if lost_s.is_none() && segment.end == MissReason::Far {
            return ScreenRayEnd::Ends(EndInImages::Sky);
        }
        let start = self.view_to_world * rays.unproject(segment.point_at(lost_s.unwrap_or(1.0)));
        ScreenRayEnd::Loses(ExactLostRay { start, direction: self.view_to_world * segment.direction })
    }

    /// Follows in captures a ray that the screen lost, and returns where it ends.
    pub fn follow(&self, lost: &ExactLostRay) -> EndInImages {
        // The point that the ray has reached, and the captures in which it did not get farther from there.
        let (mut point, mut excluded) = (lost.start, Vec::new());
        loop {
            if self.is_outside_scene(point) {
                return EndInImages::Sky;
            }
            let Some(index) = self.nearest_seeing_capture(point, &excluded) else { return EndInImages::Unknown };
            let cube = &self.captures[index];
            let (end, offset) = cube.follow(point - cube.place, lost.direction);
            let place = offset + cube.place;
            let distance_along = |reached: DVec3| (reached - lost.start).dot(lost.direction);
            match end {
                FollowEnd::Sky => return EndInImages::Sky,
                FollowEnd::Hit => return EndInImages::Capture { index, place, texel_m: cube.texel_m(offset) },
                _ => {}
            }
            if distance_along(place) > distance_along(point) + LEAST_ADVANCE_M {
                excluded.clear();
                point = place;
            }
            excluded.push(index);
        }
    }

    /// Returns whether a point, relative to the eye, lies outside the scene's bounds.
    fn is_outside_scene(&self, point: DVec3) -> bool {
        let [least, greatest] = self.bounds;
        point.cmplt(least).any() || point.cmpgt(greatest).any()
    }

    /// Returns the index of the nearest capture that sees a point, which is relative to the eye. Captures whose indices
    /// are in `excluded` do not count.
    fn nearest_seeing_capture(&self, point: DVec3, excluded: &[usize]) -> Option<usize> {
        let distance = |index: &usize| self.captures[*index].place.distance(point);
        let seeing = (0..self.captures.len()).filter(|index| !excluded.contains(index));
        seeing
            .filter(|index| self.captures[*index].sees(point - self.captures[*index].place))
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}

impl Cube<'_> {
    /// Returns the face in which a direction in world axes lies: the face along whose axis the direction reaches
    /// farthest.
    fn cube_face(&self, direction: DVec3) -> &Face<'_> {
        let axis_distance = |face: &&Face| face.view_to_world.z_axis.dot(direction);
        let farthest = self.faces.iter().max_by(|a, b| axis_distance(a).total_cmp(&axis_distance(b)));
        farthest.unwrap_or(&self.faces[0])
    }

    /// Returns the width in metres of a texel at the distance of a point, which is relative to the capture's place.
    fn texel_m(&self, point: DVec3) -> f64 {
        2.0 * point.abs().max_element() / f64::from(self.faces[0].image.rays.gbuffer.width)
    }

    /// Returns whether the capture sees a point, which is relative to the capture's place: whether the point lies
    /// beyond the near plane, and not behind the back of the block in its texel. A texel without a block hides nothing.
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
    /// place of its end. Both points are relative to the capture's place, in world axes, in metres.
    fn follow(&self, point: DVec3, direction: DVec3) -> (FollowEnd, DVec3) {
        let (mut face, mut position, mut last_thickness) = (self.cube_face(point), point, 0.0);
        // A line crosses each of the six planes between faces at most once, so that it visits at most seven faces.
        for _ in 0..7 {
            let (end, reached) = face.follow(position, direction, last_thickness);
            position = reached;
            let FollowEnd::NextFace { side, thickness } = end else { return (end, position) };
            (face, last_thickness) = (self.cube_face(side), thickness);
        }
        (FollowEnd::Lost, position)
    }
}

impl Face<'_> {
    /// Rotates a vector from world axes to the face's view axes.
    fn to_view(&self, v: DVec3) -> DVec3 {
        self.view_to_world.transpose() * v
    }

    /// Follows a ray over the face, from a point in it. Returns how the ray ends, and the place of its end. Point,
    /// direction and place are in world axes, and both points are relative to the capture's place. `last_thickness`
    /// is the thickness of the block at which the ray left the previous face, or 0.
    fn follow(&self, point: DVec3, direction: DVec3, last_thickness: f64) -> (FollowEnd, DVec3) {
        let (image, rays) = (&self.image, &self.image.rays);
        let Some(segment) = rays.segment_from(self.to_view(point), self.to_view(direction)) else {
            return (FollowEnd::Lost, point);
        };
        if segment.start.z >= 1.0 {
            return (FollowEnd::Lost, point);
        }
        let place = |s: f64| self.view_to_world * rays.unproject(segment.point_at(s));
        let mut thickness = 0.0;
        for PassedPixel { pixel, previous, entry, exit } in image.pixels(&segment) {
            let block = image.block(pixel).unwrap_or(DepthBlock::EMPTY);
            thickness = block.thickness();
            let (entry_depth, farthest_depth) =
                (segment.depth_at(entry), segment.depth_at(entry).min(segment.depth_at(exit)));
            if farthest_depth > block.front {
                continue;
            }
            let normal_cosine = image.along_normal(pixel, &segment);
            let is_inside = entry_depth >= block.back;
            if normal_cosine > 0.0 && is_inside {
                continue;
            }
            // A ray along the normal is behind the block's back here. Only the pixel in which the ray begins has no
            // previous one.
            let is_lost = match previous {
                _ if normal_cosine > 0.0 => true,
                Some(previous) => image.comes_from_behind(entry_depth, previous, block, normal_cosine),
                None => entry_depth < block.back - last_thickness,
            };
            if is_lost {
                return (FollowEnd::Lost, place(entry));
            }
            let s = oracle::meets(&segment, block, entry, exit).map_or(entry, |(s, _)| s);
            return (FollowEnd::Hit, place(s));
        }
        let end = match segment.end {
            MissReason::LeftScreen => FollowEnd::NextFace { side: self.side_at(&segment), thickness },
            MissReason::Far => FollowEnd::Sky,
            _ => FollowEnd::Lost,
        };
        (end, place(1.0))
    }

    /// Returns the world axis that points out of the side through which a segment leaves the face: of the sides towards
    /// which the segment runs, the one that is nearest to its end.
    fn side_at(&self, segment: &Segment) -> DVec3 {
        let (end, side) = (segment.point_at(1.0), f64::from(self.image.rays.gbuffer.width));
        // Distance of the end from each side, the view axis out of it, and whether the segment runs towards it.
        let sides = [
            (end.x, DVec3::NEG_X, segment.delta.x < 0.0),
            (side - end.x, DVec3::X, segment.delta.x > 0.0),
            (end.y, DVec3::Y, segment.delta.y < 0.0),
            (side - end.y, DVec3::NEG_Y, segment.delta.y > 0.0),
        ];
        let exit_side =
            sides.into_iter().filter(|(.., is_towards)| *is_towards).min_by(|(a, ..), (b, ..)| a.total_cmp(b));
        self.view_to_world * exit_side.map_or(DVec3::X, |(_, axis, _)| axis)
    }
}

#[cfg(test)]
mod tests;
