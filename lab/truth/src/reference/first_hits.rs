//! The surface that each pixel of an image sees first, and the point on it that reflects. First hits can be traced through the
//! pixels' centres, which needs no G-buffer and is therefore independent evidence. First hits can also be taken from a
//! G-buffer, which leaves the reflection as the only difference between a method and the reference.

use super::surface::{SurfacePoint, World, sky_color};
use glam::{DMat4, DVec3, Vec3};
use rayon::prelude::*;
use ssct_geometry::bvh::{TriangleHit, WorldRay};
use ssct_scenes::{Camera, GBufferData, ProjectionKind};

/// Greatest error of a depth in a G-buffer, as a share of the distance, or of the height of an orthographic image. Most devices
/// round the position of a vertex to a 256th of a pixel, by at most half of this unit. The bound holds for surfaces whose depth
/// changes by up to four times itself from pixel to pixel, which is steeper than an image can show.
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
    /// The points that reflect; `None` for pixels that do not (docs/definitions.md, "Surfaces").
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
    /// The point that a camera ray hits; `None` if it does not reflect.
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

    /// The unit mirror direction.
    pub fn mirror(&self) -> DVec3 {
        self.incoming.reflect(self.normal).normalize()
    }

    /// Whether a direction leaves the surface: it must be above the planes of both the shading normal and the
    /// triangle. A direction that does not leave carries no light, but still counts as a sample (docs/definitions.md,
    /// "Surfaces").
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
    /// The rays of a camera for an image of `extent` pixels.
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

    /// The ray through the centre of pixel `index`, and the view-space z that it advances per metre.
    pub fn ray(&self, index: usize) -> (WorldRay, f64) {
        self.ray_within(index, [0.5, 0.5])
    }

    /// The ray through a place within the pixel (0 to 1 from its left and from its upper side), and the view-space z
    /// that the ray advances per metre.
    pub fn ray_within(&self, index: usize, [u, v]: [f64; 2]) -> (WorldRay, f64) {
        let [width, height] = self.extent.map(f64::from);
        let (x, y) = (index as u32 % self.extent[0], index as u32 / self.extent[0]);
        let (x, y) = (f64::from(x) + u, f64::from(y) + v);
        let ndc = DVec3::new(2.0 * x / width - 1.0, 1.0 - 2.0 * y / height, 0.5);
        let point = self.clip_to_view.project_point3(ndc);
        // A ray begins at the eye, or, for parallel rays, beside it.
        let (along, beside) = match self.kind {
            ProjectionKind::Perspective => (point.normalize(), None),
            ProjectionKind::Orthographic => (DVec3::Z, Some(DVec3::new(point.x, point.y, 0.0))),
        };
        let direction = self.view_to_world.transform_vector3(along).normalize();
        let origin = beside.map_or(self.view_to_world.w_axis.truncate(), |b| self.view_to_world.transform_point3(b));
        (WorldRay { origin, direction, t_min: self.near_m / along.z, t_max: self.far_m / along.z }, along.z)
    }

    /// Everything, except the extent, that the rays depend on.
    pub(super) fn numbers(&self) -> Vec<f64> {
        [&self.clip_to_view.to_cols_array()[..], &self.view_to_world.to_cols_array(), &[self.near_m, self.far_m]]
            .concat()
    }
}

impl FirstHits {
    /// Traces the rays through the pixels' centres.
    pub fn trace(world: &World, camera: &Camera, extent: [u32; 2]) -> Self {
        let rays = PrimaryRays::new(camera, extent);
        let pixels = extent[0] as usize * extent[1] as usize;
        let seen: Vec<_> = (0..pixels)
            .into_par_iter()
            .map(|index| {
                let (ray, z_per_metre) = rays.ray(index);
                match world.closest(&ray) {
                    Some(hit) => Self::seen(world, &ray, &hit, z_per_metre),
                    None => (sky_color(ray.direction).as_vec3(), f64::INFINITY, None),
                }
            })
            .collect();
        let mut all = Self::empty(extent);
        for (lit, view_z_m, receiver) in seen {
            all.lit.push(lit);
            all.view_z_m.push(view_z_m);
            all.receivers.push(receiver);
        }
        all
    }

    /// The lit colour, the view-space z and the receiver of the point that a camera ray hits.
    fn seen(world: &World, ray: &WorldRay, hit: &TriangleHit, z_per_metre: f64) -> (Vec3, f64, Option<Receiver>) {
        let point = world.point(ray, hit);
        (world.color(ray, &point).as_vec3(), hit.t * z_per_metre, Receiver::hit_by(ray, &point))
    }

    /// Takes the pixels of a G-buffer: positions from its depth, with its normals and materials.
    pub fn from_gbuffer(gbuffer: &GBufferData) -> Self {
        let clip_to_view = gbuffer.view_to_clip().inverse();
        let view_to_world = gbuffer.camera.world_to_view.as_dmat4().inverse();
        let mut all = Self::empty([gbuffer.width, gbuffer.height]);
        all.lit.clone_from(&gbuffer.color);
        for (index, &depth) in gbuffer.depth.iter().enumerate() {
            let x = f64::from(index as u32 % gbuffer.width) + 0.5;
            let y = f64::from(index as u32 / gbuffer.width) + 0.5;
            let view = gbuffer.unproject(x, y, f64::from(depth), &clip_to_view);
            let sight = if gbuffer.camera.kind().is_orthographic() { DVec3::Z } else { view };
            let normal = view_to_world.transform_vector3(gbuffer.normal[index].as_dvec3()).normalize_or_zero();
            all.view_z_m.push(if depth > 0.0 { view.z } else { f64::INFINITY });
            all.receivers.push(gbuffer.reflects(index).then(|| Receiver {
                position: view_to_world.transform_point3(view),
                incoming: view_to_world.transform_vector3(sight).normalize(),
                normal,
                geometric_normal: normal,
                roughness: f64::from(gbuffer.roughness[index]),
                reflectivity: f64::from(gbuffer.reflectivity[index]),
            }));
        }
        all
    }

    /// Takes the pixels of a G-buffer that shows a world, with the points where the camera's rays meet the world, and the
    /// triangles' planes there, below which no light leads. The depths alone are too inexact on a device that rounds vertices
    /// to fractions of a pixel. At a grazing angle, points from these depths lie millimetres beside the surface, so
    /// that rays from there would meet the surface itself. A point stays in place if the world has no surface near it.
    pub fn shown(world: &World, gbuffer: &GBufferData) -> Self {
        Self::from_gbuffer(gbuffer).onto(world, gbuffer)
    }

    /// Takes one pixel as [`Self::shown`] does; all other pixels have no receivers.
    pub fn shown_at(world: &World, gbuffer: &GBufferData, index: usize) -> Self {
        let mut alone = Self::from_gbuffer(gbuffer);
        let receiver = alone.receivers.get(index).copied().flatten();
        alone.receivers.fill(None);
        if let Some(place) = alone.receivers.get_mut(index) {
            *place = receiver;
        }
        alone.onto(world, gbuffer)
    }

    /// Moves receivers from the points given by the G-buffer's depths to the points where the camera's rays meet a world.
    fn onto(self, world: &World, gbuffer: &GBufferData) -> Self {
        let mut all = self;
        let (kind, reach) = (gbuffer.camera.kind(), gbuffer.camera.reach_m(1.0));
        let eye = gbuffer.camera.world_to_view.as_dmat4().inverse().w_axis.truncate();
        all.receivers.par_iter_mut().flatten().for_each(|receiver| {
            let direction = receiver.incoming;
            let ray = match kind {
                ProjectionKind::Perspective => {
                    let stored = receiver.position.distance(eye);
                    let [t_min, t_max] = [-STORED_DEPTH_ERROR, STORED_DEPTH_ERROR].map(|error| stored * (1.0 + error));
                    WorldRay { origin: eye, direction, t_min, t_max }
                }
                ProjectionKind::Orthographic => {
                    let error = STORED_DEPTH_ERROR * reach;
                    WorldRay {
                        origin: receiver.position - error * direction,
                        direction,
                        t_min: 0.0,
                        t_max: 2.0 * error,
                    }
                }
            };
            if let Some(hit) = world.closest(&ray) {
                let point = world.point(&ray, &hit);
                (receiver.position, receiver.geometric_normal) = (point.position, point.geometric_normal);
            }
        });
        all
    }

    /// An image without pixels yet, with room for those of `extent`.
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
