//! First hits: the surface that each pixel of an image shows, and the point on it that reflects. First hits can be
//! traced through the pixels' centres, which needs no G-buffer and is therefore independent evidence. They can also be
//! taken from a G-buffer, so that a method and the reference differ in the reflection alone.

use super::surface::{SurfacePoint, World, sky_color};
use glam::{DMat4, DVec3, Vec3};
use rayon::prelude::*;
use ssct_geometry::bvh::WorldRay;
use ssct_scenes::{Camera, GBufferData, ProjectionKind};

/// Greatest error of a depth in a G-buffer, as a share of the distance, or of the height of an orthographic image. Most
/// devices round the position of a vertex to a 256th of a pixel, by at most half of this unit. The bound holds for
/// surfaces whose depth changes by up to four times itself from pixel to pixel, steeper than an image can show.
const STORED_DEPTH_ERROR: f64 = 1.0 / 128.0;

/// The first surfaces of an image; rows from the top, pixel (i, j) at `j · width + i`.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstHits {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Lit colour, linear; the environment where there is no surface.
    pub lit: Vec<Vec3>,
    /// View-space z in metres; infinite where there is no surface.
    pub view_z_m: Vec<f64>,
    /// The reflecting point of each pixel; `None` for a pixel that does not reflect (docs/definitions.md, "Surfaces").
    pub receivers: Vec<Option<Receiver>>,
}

/// A reflecting point in world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Receiver {
    /// Position in metres.
    pub position: DVec3,
    /// Unit direction from the camera to the point.
    pub incoming: DVec3,
    /// Unit shading normal.
    pub normal: DVec3,
    /// Unit normal of the triangle on the camera's side; equal to the shading normal if only a G-buffer is known.
    pub geometric_normal: DVec3,
    /// Roughness ϱ.
    pub roughness: f64,
    /// Reflectivity, above 1e-4.
    pub reflectivity: f64,
}

impl Receiver {
    /// Returns the point that a camera ray hits as a receiver; `None` if it does not reflect.
    pub fn hit_by(ray: &WorldRay, point: &SurfacePoint) -> Option<Self> {
        (point.reflectivity > f64::from(GBufferData::REFLECTS_ABOVE)).then_some(Self {
            position: point.position,
            incoming: ray.direction,
            normal: point.normal,
            geometric_normal: point.geometric_normal,
            roughness: point.roughness,
            reflectivity: point.reflectivity,
        })
    }

    /// Returns the unit mirror direction in world space.
    pub fn mirror(&self) -> DVec3 {
        self.incoming.reflect(self.normal).normalize()
    }

    /// Returns whether a direction leaves the surface: it must point above the plane of the shading normal and above
    /// that of the triangle. A direction that does not leave carries no light, but still counts as a sample
    /// (docs/definitions.md, "Surfaces").
    pub fn is_above(&self, direction: DVec3) -> bool {
        direction.dot(self.normal) > 0.0 && direction.dot(self.geometric_normal) > 0.0
    }
}

/// The camera's rays of sight through an image, from the near plane to the far plane.
#[derive(Debug, Clone, Copy)]
pub struct PrimaryRays {
    kind: ProjectionKind,
    clip_to_view: DMat4,
    view_to_world: DMat4,
    extent: [u32; 2],
    near_m: f64,
    far_m: f64,
}

impl PrimaryRays {
    /// Returns the rays of a camera for an image of `extent` (width, height) pixels.
    pub fn new(camera: &Camera, extent: [u32; 2]) -> Self {
        Self {
            kind: camera.kind(),
            clip_to_view: camera.view_to_clip_reversed().as_dmat4().inverse(),
            view_to_world: camera.world_to_view.as_dmat4().inverse(),
            extent,
            near_m: f64::from(camera.lens.near_m),
            far_m: f64::from(camera.lens.far_m),
        }
    }

    /// Returns the ray in world space through the centre of pixel `index`, and the view-space z by which it advances
    /// with each metre.
    pub fn ray(&self, index: usize) -> (WorldRay, f64) {
        self.ray_within(index, [0.5, 0.5])
    }

    /// Returns the ray in world space through a place within pixel `index`, and the view-space z by which it advances
    /// with each metre. The place is [u, v], 0 to 1 from the pixel's left and upper side.
    pub fn ray_within(&self, index: usize, [u, v]: [f64; 2]) -> (WorldRay, f64) {
        let [width, height] = self.extent.map(f64::from);
        let (x, y) = (index as u32 % self.extent[0], index as u32 / self.extent[0]);
        let (x, y) = (f64::from(x) + u, f64::from(y) + v);
        let ndc = DVec3::new(2.0 * x / width - 1.0, 1.0 - 2.0 * y / height, 0.5);
        let point = self.clip_to_view.project_point3(ndc);
        // Direction in view space, and the view-space origin of a parallel ray, which begins beside the eye.
        let (view_direction, view_origin) = match self.kind {
            ProjectionKind::Perspective => (point.normalize(), None),
            ProjectionKind::Orthographic => (DVec3::Z, Some(DVec3::new(point.x, point.y, 0.0))),
        };
        let direction = self.view_to_world.transform_vector3(view_direction).normalize();
        let eye = self.view_to_world.w_axis.truncate();
        let origin = view_origin.map_or(eye, |point| self.view_to_world.transform_point3(point));
        let z_per_metre = view_direction.z;
        (WorldRay { origin, direction, t_min: self.near_m / z_per_metre, t_max: self.far_m / z_per_metre }, z_per_metre)
    }

    /// Returns all numbers that the rays depend on, except the extent and the kind of projection, for a fingerprint.
    pub(super) fn numbers(&self) -> Vec<f64> {
        [&self.clip_to_view.to_cols_array()[..], &self.view_to_world.to_cols_array(), &[self.near_m, self.far_m]]
            .concat()
    }
}

impl FirstHits {
    /// Traces the camera's rays through the centres of `extent` (width, height) pixels against the world.
    pub fn trace(world: &World, camera: &Camera, extent: [u32; 2]) -> Self {
        let rays = PrimaryRays::new(camera, extent);
        let pixels = extent[0] as usize * extent[1] as usize;
        let traced: Vec<_> = (0..pixels)
            .into_par_iter()
            .map(|index| {
                let (ray, z_per_metre) = rays.ray(index);
                let Some(hit) = world.closest(&ray) else {
                    return (sky_color(ray.direction).as_vec3(), f64::INFINITY, None);
                };
                let point = world.point(&ray, &hit);
                (world.color(&ray, &point).as_vec3(), hit.t * z_per_metre, Receiver::hit_by(&ray, &point))
            })
            .collect();
        let mut first_hits = Self::empty(extent);
        for (lit, view_z_m, receiver) in traced {
            first_hits.lit.push(lit);
            first_hits.view_z_m.push(view_z_m);
            first_hits.receivers.push(receiver);
        }
        first_hits
    }

    /// Takes the first hits from a G-buffer: positions from its depth, with its normals and materials.
    pub fn from_gbuffer(gbuffer: &GBufferData) -> Self {
        let clip_to_view = gbuffer.view_to_clip().inverse();
        let view_to_world = gbuffer.camera.world_to_view.as_dmat4().inverse();
        let mut first_hits = Self::empty([gbuffer.width, gbuffer.height]);
        first_hits.lit.clone_from(&gbuffer.color);
        for (index, &depth) in gbuffer.depth.iter().enumerate() {
            let x = f64::from(index as u32 % gbuffer.width) + 0.5;
            let y = f64::from(index as u32 / gbuffer.width) + 0.5;
            let view = gbuffer.unproject(x, y, f64::from(depth), &clip_to_view);
            let sight = if gbuffer.camera.kind().is_orthographic() { DVec3::Z } else { view };
            let normal = view_to_world.transform_vector3(gbuffer.normal[index].as_dvec3()).normalize_or_zero();
            first_hits.view_z_m.push(if depth > 0.0 { view.z } else { f64::INFINITY });
            first_hits.receivers.push(gbuffer.reflects(index).then(|| Receiver {
                position: view_to_world.transform_point3(view),
                incoming: view_to_world.transform_vector3(sight).normalize(),
                normal,
                geometric_normal: normal,
                roughness: f64::from(gbuffer.roughness[index]),
                reflectivity: f64::from(gbuffer.reflectivity[index]),
            }));
        }
        first_hits
    }

    /// Takes the first hits from a G-buffer that shows a world, and moves the reflecting points to where the camera's
    /// rays meet the world. Their geometric normals become those of the triangles. The depths alone are too inexact on
    /// a device that rounds vertices to fractions of a pixel. At a grazing angle, points from these depths lie
    /// millimetres beside the surface, so that rays from there would meet the surface itself. A point stays in place if
    /// the world has no surface near it.
    pub fn shown(world: &World, gbuffer: &GBufferData) -> Self {
        Self::from_gbuffer(gbuffer).moved_to_surfaces(world, gbuffer)
    }

    /// Takes the first hits as [`Self::shown`] does, but only pixel `index` has a receiver.
    pub fn shown_at(world: &World, gbuffer: &GBufferData, index: usize) -> Self {
        let mut first_hits = Self::from_gbuffer(gbuffer);
        let receiver = first_hits.receivers.get(index).copied().flatten();
        first_hits.receivers.fill(None);
        if let Some(only_receiver) = first_hits.receivers.get_mut(index) {
            *only_receiver = receiver;
        }
        first_hits.moved_to_surfaces(world, gbuffer)
    }

    /// Moves receivers from the points that the G-buffer's depths give to the points where the camera's rays meet a
    /// world, if a surface is there within [`STORED_DEPTH_ERROR`].
    fn moved_to_surfaces(mut self, world: &World, gbuffer: &GBufferData) -> Self {
        let (kind, reach) = (gbuffer.camera.kind(), gbuffer.camera.reach_m(1.0));
        let eye = gbuffer.camera.world_to_view.as_dmat4().inverse().w_axis.truncate();
        self.receivers.par_iter_mut().flatten().for_each(|receiver| {
            let direction = receiver.incoming;
            let ray = match kind {
                ProjectionKind::Perspective => {
                    let distance = receiver.position.distance(eye);
                    let [t_min, t_max] =
                        [-STORED_DEPTH_ERROR, STORED_DEPTH_ERROR].map(|error| distance * (1.0 + error));
                    WorldRay { origin: eye, direction, t_min, t_max }
                }
                ProjectionKind::Orthographic => {
                    let error = STORED_DEPTH_ERROR * reach;
                    let origin = receiver.position - error * direction;
                    WorldRay { origin, direction, t_min: 0.0, t_max: 2.0 * error }
                }
            };
            if let Some(hit) = world.closest(&ray) {
                let point = world.point(&ray, &hit);
                (receiver.position, receiver.geometric_normal) = (point.position, point.geometric_normal);
            }
        });
        self
    }

    /// Returns first hits of an image of `extent` (width, height) pixels to which no pixel has been added yet.
    fn empty(extent: [u32; 2]) -> Self {
        let pixels = extent[0] as usize * extent[1] as usize;
        Self {
            width: extent[0],
            height: extent[1],
            lit: Vec::with_capacity(pixels),
            view_z_m: Vec::with_capacity(pixels),
            receivers: Vec::with_capacity(pixels),
        }
    }
}
