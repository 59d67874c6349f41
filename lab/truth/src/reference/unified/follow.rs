//! Twin of the shaders that follow rays through captures (`captures/faces.glsl`, `captures/follow.comp`, and
//! `PushIfLost` of `captures/seen.glsl`), operation for operation. The twin keeps the shaders' names; comments in the
//! shaders give the reasons of each step. The twin does not compute the colour that a ray sees.

use super::{Hit, HitCode, NEVER, Ray, Traversal, Walk, WalkMode, dot, front_crossing};
use crate::reference::CaptureData;
use glam::{IVec2, Mat3, Vec2, Vec3};
use ssct_ground::math::constants;
use ssct_scenes::{Aabb, Camera, ProjectionKind};

/// Distance at which the sky is put, in metres.
const SKY_DISTANCE: f32 = constants::SKY_DISTANCE as f32;
/// Least distance that a ray must advance in a capture to count as having moved, in metres.
const LEAST_ADVANCE_M: f32 = constants::LEAST_ADVANCE_M as f32;

/// Captures in which the rays of one camera are followed.
#[derive(Debug, Clone)]
pub struct CaptureTraversal<'a> {
    /// Faces in Vulkan's order +x −x +y −y +z −z; face f of capture k is at 6 k + f.
    pub faces: Vec<Traversal<'a>>,
    /// Offset from the camera's eye to each capture's place, in world axes, in metres.
    pub places: Vec<Vec3>,
    /// Rotation from the camera's view axes to world axes.
    view_to_world: Mat3,
    /// Metres in one unit of the points that are computed from the screen's depth.
    view_unit: f32,
    /// Metres in one unit of the points that are computed from a face's depth.
    face_unit: f32,
    /// Position of the camera in the world, in metres.
    eye: Vec3,
    /// A box, relative to the eye, outside of which there is no surface.
    bounds: Aabb,
}

/// Twin of `LostRay`, without the ray's footprint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LostRay {
    /// Where the ray was lost, relative to the eye, in world axes, in metres.
    pub start: Vec3,
    /// Unit direction in world axes.
    pub direction: Vec3,
}

/// How a mirror ray ended on the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ScreenRayEnd {
    /// The pixel has no ray, or its ray goes below its own surface.
    NoRay,
    /// The ray ended in the sky.
    Sky,
    /// The ray hit.
    Hit(Hit),
    /// The screen lost the ray.
    Lost(LostRay),
}

/// How a ray ended after the screen lost it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RayEndKind {
    /// The ray hit in the capture of this index.
    Capture(usize),
    /// The ray ended in the sky.
    Sky,
    /// The ray ended where no image sees it.
    Unknown,
}

impl RayEndKind {
    /// Returns the path code: the value of `PATH_*` in the shaders.
    pub fn code(self) -> i32 {
        match self {
            Self::Capture(capture) => constants::PATH_CAPTURE + capture as i32,
            Self::Sky => constants::PATH_SKY,
            Self::Unknown => constants::PATH_UNKNOWN,
        }
    }
}

/// Twin of `CaptureRayEnd`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CaptureRayEnd {
    /// How the ray ended.
    pub kind: RayEndKind,
    /// Where the ray hit, or a point far along it for the sky: relative to the eye, in world axes, in metres.
    pub place: Vec3,
    /// Number of cells looked at in all captures.
    pub steps: i32,
    /// Number of faces walked over.
    pub faces: i32,
    /// Whether a walk ran out of steps, which must not happen.
    pub is_exhausted: bool,
}

/// Twin of the values `FOLLOW_*`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FollowEnd {
    /// The ray hits a block from in front.
    Hit,
    /// The ray leaves the scene through the far plane.
    Sky,
    /// The ray goes behind something, or too near to the capture's place.
    Lost,
    /// The ray leaves a face by a side, and goes on in the next face.
    On,
}

impl<'a> CaptureTraversal<'a> {
    /// Greatest number of faces that a ray is followed over: seven each time that it is followed in a capture.
    pub const MAX_FACES: i32 = 7 * 2 * constants::CAPTURE_SLOTS;

    /// Returns the greatest number of cells that a ray looks at in all captures.
    pub fn max_steps(&self) -> i32 {
        self.faces.first().map_or(0, |face| Self::MAX_FACES * face.max_face_steps())
    }

    /// Makes the twin for the rays of a camera and the given captures, whose faces all have the same lens and size.
    /// There are no bounds until [`Self::with_bounds`] sets them.
    pub fn new(camera: &Camera, captures: &'a [CaptureData]) -> Self {
        let faces = || captures.iter().flat_map(|capture| &capture.faces);
        // In a perspective, points that are computed from depth are divided by near (1 + k), where k is `depth_offset`.
        let metres_per_unit = |camera: &Camera| match camera.kind() {
            ProjectionKind::Perspective => camera.view_to_clip_reversed().as_dmat4().w_axis.z as f32,
            ProjectionKind::Orthographic => 1.0,
        };
        Self {
            faces: faces().map(Traversal::new).collect(),
            places: captures.iter().map(|capture| capture.place - camera.eye()).collect(),
            view_to_world: Mat3::from_mat4(camera.world_to_view.as_dmat4().inverse().as_mat4()),
            view_unit: metres_per_unit(camera),
            face_unit: faces().next().map_or(0.0, |face| metres_per_unit(&face.camera)),
            eye: camera.eye(),
            bounds: Aabb::ALL,
        }
    }

    /// Sets a box in the world, in metres, outside of which there is no surface.
    pub fn with_bounds(self, bounds: Aabb) -> Self {
        Self { bounds: bounds.moved(-self.eye), ..self }
    }

    /// Follows the mirror ray of pixel (x, y) on the screen (`mirror.glsl`) and returns how it ends there. The screen's
    /// traversal must be [`Traversal::followed`].
    pub fn trace_screen(&self, screen: &Traversal, x: u32, y: u32) -> ScreenRayEnd {
        let Some((ray, true)) = screen.mirror_ray(x, y) else { return ScreenRayEnd::NoRay };
        let hit = screen.traverse(&ray);
        match hit.code {
            HitCode::Miss if screen.ends_in_sky(&ray) => ScreenRayEnd::Sky,
            HitCode::Surface => ScreenRayEnd::Hit(hit),
            _ => ScreenRayEnd::Lost(self.lost_ray(screen, &ray, &hit)),
        }
    }

    /// Twin of `PushIfLost`: returns the lost ray that begins where the screen lost `ray`, at the s of `hit`.
    fn lost_ray(&self, screen: &Traversal, ray: &Ray, hit: &Hit) -> LostRay {
        let parameters = &screen.parameters;
        let depth = ray.depth + hit.s * ray.rate.z;
        let start = parameters.view_point(ray.start + hit.s * ray.rate.truncate(), depth.max(0.0)) * self.view_unit;
        let world_direction = self.to_world(ray.direction);
        LostRay {
            start: self.to_world(start),
            direction: world_direction * (1.0 / dot(world_direction, world_direction).sqrt()),
        }
    }

    /// Twin of `ToWorld`: rotates a vector from view axes to world axes.
    fn to_world(&self, v: Vec3) -> Vec3 {
        let rotation = &self.view_to_world;
        rotation.x_axis * v.x + rotation.y_axis * v.y + rotation.z_axis * v.z
    }

    /// Twin of `TraceCaptures`: follows a lost ray from capture to capture until it ends.
    pub fn trace_captures(&self, ray: &LostRay) -> CaptureRayEnd {
        let mut ray_end =
            CaptureRayEnd { kind: RayEndKind::Unknown, place: ray.start, steps: 0, faces: 0, is_exhausted: false };
        // The point that the ray has reached, and a bit for each capture in which it did not get farther from there.
        let (mut point, mut excluded) = (ray.start, 0_u32);
        for _ in 0..2 * constants::CAPTURE_SLOTS {
            if self.is_outside_scene(point) {
                ray_end.kind = RayEndKind::Sky;
                break;
            }
            let Some(capture) = self.nearest_seeing_capture(point, excluded) else { break };
            let capture_place = self.places[capture];
            let (follow_end, end_offset) =
                self.trace_capture(capture, point - capture_place, ray.direction, &mut ray_end);
            let end_point = end_offset + capture_place;
            match follow_end {
                FollowEnd::Sky => {
                    ray_end.kind = RayEndKind::Sky;
                    break;
                }
                FollowEnd::Hit => {
                    (ray_end.kind, ray_end.place) = (RayEndKind::Capture(capture), end_point);
                    break;
                }
                FollowEnd::Lost | FollowEnd::On => {}
            }
            let has_moved =
                dot(end_point - ray.start, ray.direction) > dot(point - ray.start, ray.direction) + LEAST_ADVANCE_M;
            excluded = if has_moved { 1 << capture } else { excluded | 1 << capture };
            if has_moved {
                point = end_point;
            }
        }
        if ray_end.kind == RayEndKind::Sky {
            ray_end.place = ray.start + SKY_DISTANCE * ray.direction;
        }
        ray_end
    }

    /// Twin of `IsOutsideScene`: returns whether a point, relative to the eye, lies outside the bounds.
    fn is_outside_scene(&self, point: Vec3) -> bool {
        point.cmplt(self.bounds.min).any() || point.cmpgt(self.bounds.max).any()
    }

    /// Twin of `NearestSeeingCapture`: returns the index of the nearest capture that sees a point, which is relative to
    /// the eye. Bit k of `excluded` leaves capture k out.
    fn nearest_seeing_capture(&self, point: Vec3, excluded: u32) -> Option<usize> {
        let (mut nearest, mut least_squared) = (None, NEVER);
        for (capture, place) in self.places.iter().enumerate() {
            let from_capture = point - *place;
            let squared = dot(from_capture, from_capture);
            if excluded >> capture & 1 == 0 && squared < least_squared && self.capture_sees(capture, from_capture) {
                (nearest, least_squared) = (Some(capture), squared);
            }
        }
        nearest
    }

    /// Twin of `CaptureSees`: returns whether a capture sees a point, which is given relative to the capture's place.
    /// The point must lie beyond the near plane, and not behind the back of the block that the capture shows in its
    /// direction.
    fn capture_sees(&self, capture: usize, point: Vec3) -> bool {
        let face = cube_face(point);
        let image = &self.faces[6 * capture + face];
        let mut face_point = to_face(point, face);
        face_point.z = face_point.z.max(1e-6);
        let depth = self.face_depth(image, face_point.z);
        let block = image.block(face_position(image, face_point).1);
        depth < 1.0 && (block.front < block.back || depth >= block.back)
    }

    /// Twin of `FaceDepth`: returns the reversed depth, in a face, of a point at view-space z in metres.
    fn face_depth(&self, image: &Traversal, z: f32) -> f32 {
        self.face_unit / z - image.parameters.depth_offset
    }

    /// Twin of `FacePoint`: returns the point of a ray at its parameter s, in the face's view space, in metres.
    fn face_point(&self, image: &Traversal, ray: &Ray, s: f32) -> Vec3 {
        let depth = ray.depth + s * ray.rate.z;
        let position = ray.start + s * ray.rate.truncate();
        let z = self.face_unit / (depth + image.parameters.depth_offset).max(1e-12);
        image.parameters.view_ray(position) * z
    }

    /// Twin of `TraceFace`: follows a ray over one face, from the point `begin` along `direction`, both in the face's
    /// view space. Returns how the ray ends, its last point, and the outward axis of the side by which it leaves.
    /// `border_thickness` is the thickness of the block at the border of the face before, and becomes that of the block
    /// where the ray leaves this face.
    fn trace_face(
        &self,
        image: &Traversal,
        [begin, direction]: [Vec3; 2],
        border_thickness: &mut f32,
        ray_end: &mut CaptureRayEnd,
    ) -> (FollowEnd, Vec3, Vec3) {
        let (start, pixel) = face_position(image, begin);
        let depth = self.face_depth(image, begin.z);
        let side = image.parameters.size.x as f32;
        let ndc = Vec2::new(2.0, -2.0) * (start / side - 0.5);
        let change = direction.truncate() - ndc * direction.z;
        let change = if change == Vec2::ZERO { Vec2::new(1e-20, 0.0) } else { change };
        let change_z = -((depth + image.parameters.depth_offset) * direction.z);
        let ray = image.make_ray(start, pixel, depth, direction, change.extend(change_z));
        if depth.is_nan() || depth >= 1.0 {
            return (FollowEnd::Lost, begin, Vec3::ZERO);
        }
        let ahead = ray.ahead();
        let level = constants::FACE_LEVEL.min(image.parameters.top_level);
        let mut walk = Walk { pixel, level, entry: 0.0, entry_depth: depth, steps: 0 };
        let mut passes = false;
        ray_end.faces += 1;
        let end = loop {
            let mode = WalkMode::Followed { passes, border: image.parameters.size - 1 };
            image.advance(&ray, ahead, mode, &mut walk, |_| {});
            if walk.level >= 0 {
                break None;
            }
            // The ray is behind the front of a block. If it runs away from the surface and is still inside the block,
            // it leaves this surface and passes. It meets any other surface from in front or from behind.
            let block = image.block(walk.pixel);
            let along_normal = dot(direction, image.normal(walk.pixel));
            let in_front = walk.entry_depth >= block.front;
            passes = along_normal > 0.0 && walk.entry_depth >= block.back;
            if !passes {
                let is_lost = match (along_normal > 0.0, in_front) {
                    (true, _) => true,
                    (false, true) => false,
                    _ if walk.entry > 0.0 => image.is_behind(&ray, walk.entry_depth, walk.pixel, block, ahead),
                    _ => walk.entry_depth < block.back - *border_thickness,
                };
                let s = if is_lost { walk.entry } else { front_crossing(&ray, &walk, ahead, block.front) };
                let follow_end = if is_lost { FollowEnd::Lost } else { FollowEnd::Hit };
                break Some((follow_end, self.face_point(image, &ray, s), Vec3::ZERO));
            }
            walk.level = 0;
        };
        ray_end.steps += walk.steps;
        ray_end.is_exhausted |= walk.level >= 0 && walk.entry < ray.end;
        // A ray that met nothing ends at a side of the face, at the far plane or at the near plane.
        end.unwrap_or_else(|| {
            let far_corner = ray.ahead() * image.parameters.size;
            let side_s = (far_corner.as_vec2() - ray.start) * ray.inverse;
            let leaves_by_side = ray.end == side_s.x.min(side_s.y);
            let at_side = (ray.start + ray.end * ray.rate.truncate()).as_ivec2();
            let block = image.block(at_side.clamp(IVec2::ZERO, image.parameters.size - 1));
            *border_thickness = (block.front - block.back).max(0.0);
            let follow_end = match leaves_by_side {
                true => FollowEnd::On,
                false if ray.rate.z < 0.0 => FollowEnd::Sky,
                false => FollowEnd::Lost,
            };
            // Image y runs down, and view-space y up.
            let exit_side = if side_s.x <= side_s.y {
                Vec3::X * if ray.inverse.x > 0.0 { 1.0 } else { -1.0 }
            } else {
                Vec3::Y * if ray.inverse.y > 0.0 { -1.0 } else { 1.0 }
            };
            (follow_end, self.face_point(image, &ray, ray.end), exit_side)
        })
    }

    /// Twin of `TraceCapture`: follows a ray through a capture, from face to face, from the point `begin`. Returns how
    /// the ray ends, and its last point. Both points are relative to the capture's place, in world axes, in metres.
    fn trace_capture(
        &self,
        capture: usize,
        begin: Vec3,
        direction: Vec3,
        ray_end: &mut CaptureRayEnd,
    ) -> (FollowEnd, Vec3) {
        let (mut face, mut place, mut border_thickness) = (cube_face(begin), begin, 0.0);
        // A line crosses each of the six planes between faces at most once, so that it visits at most seven faces.
        for _ in 0..7 {
            let image = &self.faces[6 * capture + face];
            let face_ray = [place, direction].map(|v| to_face(v, face));
            let (follow_end, end, exit_side) = self.trace_face(image, face_ray, &mut border_thickness, ray_end);
            place = from_face(end, face);
            if follow_end != FollowEnd::On {
                return (follow_end, place);
            }
            face = cube_face(from_face(exit_side, face));
        }
        (FollowEnd::Lost, place)
    }
}

impl Traversal<'_> {
    /// Returns whether a ray that hit nothing left the view through the far plane (`MissCode`). If it did, it ends
    /// neither at a side of the screen nor behind its last pixel's block, and does not run towards the camera.
    fn ends_in_sky(&self, ray: &Ray) -> bool {
        let end_offset = (ray.end * ray.rate.truncate() + 0.5).floor().as_ivec2();
        let depth = ray.depth + ray.end * ray.rate.z;
        let block = self.block((ray.pixel + end_offset).clamp(IVec2::ZERO, self.parameters.size - 1));
        let far_corner = ray.ahead() * self.parameters.size;
        let side_s = ((far_corner - ray.pixel).as_vec2() - 0.5) * ray.inverse;
        let is_behind = block.front >= block.back && depth < block.back;
        !is_behind && ray.end != side_s.x.min(side_s.y) && ray.rate.z <= 0.0
    }
}

/// Twin of `ToFace`: rotates a vector from world axes to the view axes of a face (0 to 5).
fn to_face(v: Vec3, face: usize) -> Vec3 {
    match face {
        0 => Vec3::new(-v.z, v.y, v.x),
        1 => Vec3::new(v.z, v.y, -v.x),
        2 => Vec3::new(v.x, -v.z, v.y),
        3 => Vec3::new(v.x, v.z, -v.y),
        4 => v,
        _ => Vec3::new(-v.x, v.y, -v.z),
    }
}

/// Twin of `FromFace`: rotates a vector from the view axes of a face (0 to 5) to world axes.
fn from_face(v: Vec3, face: usize) -> Vec3 {
    match face {
        0 => Vec3::new(v.z, v.y, -v.x),
        1 => Vec3::new(-v.z, v.y, v.x),
        2 => Vec3::new(v.x, v.z, -v.y),
        3 => Vec3::new(v.x, -v.z, v.y),
        4 => v,
        _ => Vec3::new(-v.x, v.y, -v.z),
    }
}

/// Twin of `CubeFace`: returns the face (0 to 5, for +x −x +y −y +z −z) in which a direction lies.
fn cube_face(direction: Vec3) -> usize {
    let magnitude = direction.abs();
    let face_by_sign = |component: f32, face: usize| if component >= 0.0 { face } else { face + 1 };
    if magnitude.x >= magnitude.y && magnitude.x >= magnitude.z {
        face_by_sign(direction.x, 0)
    } else if magnitude.y >= magnitude.z {
        face_by_sign(direction.y, 2)
    } else {
        face_by_sign(direction.z, 4)
    }
}

/// Twin of `FacePosition`: returns the continuous pixel coordinates and the pixel of a point in a face's view space.
fn face_position(image: &Traversal, face_point: Vec3) -> (Vec2, IVec2) {
    let size = image.parameters.size;
    let side = size.x as f32;
    let ndc = face_point.truncate() / face_point.z;
    let position = ((ndc * Vec2::new(0.5, -0.5) + 0.5) * side).max(Vec2::ZERO).min(Vec2::splat(side));
    (position, position.as_ivec2().min(size - 1))
}
