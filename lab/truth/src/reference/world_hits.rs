//! Computes where the mirror rays of a G-buffer end in the world, and whether the screen shows these places. A method's
//! hits are compared with the result (docs/definitions.md, "World agreement").

use super::first_hits::{FirstHits, Receiver};
use super::surface::World;
use super::surface_color::SurfaceColors;
use super::world::RAY_START_M;
use glam::{DMat4, DVec2, DVec3};
use rayon::prelude::*;
use ssct_geometry::bvh::{TriangleHit, WorldRay};
pub use ssct_ground::math::constants::VISIBLE_WITHIN;
use ssct_scenes::GBufferData;

/// The end of a mirror ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WorldHit {
    /// The pixel does not reflect, so there is no ray.
    NotReflecting,
    /// The ray hit no triangle.
    Escaped,
    /// The ray hit a triangle.
    Hit {
        /// World position in metres.
        position: DVec3,
        /// Pixel coordinates of the hit point, which may be off screen; `None` behind the eye of a perspective camera.
        pixel: Option<DVec2>,
        /// View-space z in metres.
        view_z_m: f64,
        /// Length of the ray in metres.
        length_m: f64,
        /// Whether the pixel at these coordinates shows the hit point.
        visible: bool,
    },
}

impl WorldHit {
    /// Returns the pixel coordinates of a visible hit, where a method should hit; `None` if the method should miss.
    pub fn visible_at(&self) -> Option<DVec2> {
        match *self {
            Self::Hit { pixel, visible: true, .. } => pixel,
            _ => None,
        }
    }
}

/// Traces the mirror ray of each reflecting pixel of a G-buffer, and returns the end for each pixel, rows from the top.
/// The ray begins at the point that the pixel shows ([`FirstHits::shown`]) and is reflected at the pixel's own normal.
pub fn world_hits(world: &World, gbuffer: &GBufferData, first_hits: &FirstHits) -> Vec<WorldHit> {
    let screen = ShownPlaces::new(gbuffer, first_hits);
    let end = |receiver: &Option<Receiver>| match receiver {
        Some(receiver) => screen.end(world, receiver).0,
        None => WorldHit::NotReflecting,
    };
    first_hits.receivers.par_iter().map(end).collect()
}

/// Tests which places of the world the screen shows.
#[derive(Debug, Clone)]
pub(super) struct ShownPlaces<'a> {
    gbuffer: &'a GBufferData,
    colors: SurfaceColors<'a>,
    /// View-space z in metres of the surface that each pixel shows.
    view_z_m: &'a [f64],
    world_to_view: DMat4,
    view_to_clip: DMat4,
}

impl<'a> ShownPlaces<'a> {
    /// Prepares the tests for a G-buffer; `first_hits` are the first hits of the same G-buffer.
    pub(super) fn new(gbuffer: &'a GBufferData, first_hits: &'a FirstHits) -> Self {
        let world_to_view = gbuffer.camera.world_to_view.as_dmat4();
        let colors = SurfaceColors::new(gbuffer);
        Self { gbuffer, colors, view_z_m: &first_hits.view_z_m, world_to_view, view_to_clip: gbuffer.view_to_clip() }
    }

    /// Returns where the mirror ray of a receiver ends, and the triangle that the ray meets (`None` if the ray
    /// escapes).
    pub(super) fn end(&self, world: &World, receiver: &Receiver) -> (WorldHit, Option<TriangleHit>) {
        let direction = receiver.mirror();
        let ray = WorldRay { origin: receiver.position, direction, t_min: RAY_START_M, t_max: f64::INFINITY };
        let Some(hit) = world.closest(&ray) else { return (WorldHit::Escaped, None) };
        let position = ray.point_at(hit.t);
        let (pixel, view_z_m, visible) = self.place_on_screen(position);
        (WorldHit::Hit { position, pixel, view_z_m, length_m: hit.t, visible }, Some(hit))
    }

    /// Returns the pixel coordinates of a place (`None` behind the eye of a perspective camera), its view-space z in
    /// metres, and whether the pixel there shows the place.
    fn place_on_screen(&self, position: DVec3) -> (Option<DVec2>, f64, bool) {
        let view = self.world_to_view.transform_point3(position);
        let pixel = self.gbuffer.project(view, &self.view_to_clip).map(|place| place.truncate());
        let reach = self.gbuffer.camera.reach_m(view.z);
        let shows = |index: usize| (view.z - self.view_z_m[index]).abs() <= VISIBLE_WITHIN * reach + VISIBLE_WITHIN;
        (pixel, view.z, pixel.and_then(|place| self.index(place)).is_some_and(shows))
    }

    /// Returns the linear colour that the screen shows at the end of a ray; `None` if the screen does not show that
    /// place. `world_direction` is the ray's direction, for surfaces that show the environment.
    pub(super) fn color(&self, end: DVec3, world_direction: DVec3) -> Option<DVec3> {
        let (pixel, _, visible) = self.place_on_screen(end);
        let place = pixel.filter(|_| visible)?;
        Some(self.colors.shown(self.index(place)?, place.to_array(), world_direction, None))
    }

    /// Returns the index of the pixel at continuous pixel coordinates; `None` off screen.
    pub(super) fn index(&self, place: DVec2) -> Option<usize> {
        let size = DVec2::new(f64::from(self.gbuffer.width), f64::from(self.gbuffer.height));
        let is_inside = place.cmpge(DVec2::ZERO).all() && place.cmplt(size).all();
        is_inside.then(|| self.gbuffer.index(place.x as u32, place.y as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::pixel::tests::room;
    use crate::reference::surface::tests::rectangle;
    use crate::reference::testing;
    use glam::Vec3;
    use ssct_scenes::{Camera, Lens, Scene};

    /// Returns a scene and its G-buffer: a camera at the origin, 1 m above a mirror floor, before a wall at z = 4 m
    /// that stands on the floor. The wall's distances in the G-buffer are multiplied by a factor.
    fn gbuffer(wall_depth_factor: f32) -> (Scene, GBufferData) {
        let (scene, camera) = room(Vec::new());
        let world = World::new(&scene, &scene.materials);
        let mut data = testing::traced(&world, &camera, [40, 40]);
        let (to_clip, to_view) = (data.view_to_clip(), data.view_to_clip().inverse());
        for i in (0..data.depth.len()).filter(|i| !data.reflects(*i) && wall_depth_factor != 1.0).collect::<Vec<_>>() {
            let z = to_view.project_point3(DVec3::Z * f64::from(data.depth[i])).z * f64::from(wall_depth_factor);
            data.depth[i] = to_clip.project_point3(DVec3::Z * z).z as f32;
        }
        drop(world);
        (scene, data)
    }

    #[test]
    fn a_wall_is_hit_where_the_mirrored_camera_sees_it() {
        let (scene, data) = gbuffer(1.0);
        let world = World::new(&scene, &scene.materials);
        let hits = world_hits(&world, &data, &FirstHits::shown(&world, &data));
        let mut wall_hits = 0;
        for (index, hit) in hits.iter().enumerate() {
            let (x, y) = (index % 40, index / 40);
            // The image is square with a field of view of 90°, so that the ray of row y descends by (y + ½ − 20) / 20
            // with each metre of z.
            let descent = (y as f64 + 0.5 - 20.0) / 20.0;
            if descent * 4.0 <= 1.0 {
                assert_eq!(*hit, WorldHit::NotReflecting, "{x} {y}");
                continue;
            }
            // The camera ray hits the floor at z = 1 / descent. The mirrored ray rises equally steeply and hits the
            // wall at height −1 + (4 − z) · descent = 4 descent − 2, which is in row 20 − 20 (4 descent − 2) / 4.
            let WorldHit::Hit { position, pixel, view_z_m, length_m, visible } = *hit else {
                panic!("{x} {y}: {hit:?}")
            };
            let pixel = pixel.expect("in front");
            assert!((position.z - 4.0).abs() < 1e-4 && (view_z_m - 4.0).abs() < 1e-4);
            // The mirrored ray covers 4 − z in z from z = 1 / descent. Its slope in y is `descent`, and its slope in x
            // is the camera ray's.
            let side_slope = (x as f64 + 0.5 - 20.0) / 20.0;
            let expected = (4.0 - 1.0 / descent) * (1.0 + descent * descent + side_slope * side_slope).sqrt();
            assert!((length_m - expected).abs() < 1e-3, "{x} {y}: {length_m} {expected}");
            assert!((pixel.y - (20.0 - 5.0 * (4.0 * descent - 2.0))).abs() < 1e-3, "{x} {y}: {pixel}");
            assert!((pixel.x - (x as f64 + 0.5)).abs() < 1e-3, "{x} {y}: {pixel}");
            // The whole wall is on screen, down to its foot (row 25), and nothing hides it.
            assert!(visible, "{x} {y}");
            assert_eq!(hit.visible_at(), Some(pixel));
            wall_hits += 1;
        }
        assert_eq!(wall_hits, 15 * 40);
    }

    #[test]
    fn parallel_lines_of_sight_are_reflected_alike() {
        let (mut scene, _) = room(Vec::new());
        scene.meshes[0] = rectangle(Vec3::new(-9.0, -1.0, -9.0), 18.0 * Vec3::Z, 18.0 * Vec3::X, 0);
        // The camera looks down by 45°. A ray that meets the floor at z rises as steeply as it fell, and meets the wall
        // 4 − z above the floor.
        let camera = Camera::new(Vec3::ZERO, Vec3::new(0.0, -1.0, 1.0), Lens::orthographic(4.0, 0.0, 20.0), 1.0);
        let world = World::new(&scene, &scene.materials);
        let data = testing::traced(&world, &camera, [40, 40]);
        let shown = FirstHits::shown(&world, &data);
        let from_depth = FirstHits::from_gbuffer(&data);
        let mut reflecting_pixels = 0;
        for (i, hit) in world_hits(&world, &data, &shown).into_iter().enumerate() {
            let Some(receiver) = &shown.receivers[i] else { continue };
            // Pixels are 0.1 m wide; the pixels of a row meet the floor at the same z.
            let image_y_m = 2.0 - (f64::from(i as u32 / 40) + 0.5) * 0.1;
            let floor_z = 1.0 + 2_f64.sqrt() * image_y_m;
            let image_x_m = (f64::from(i as u32 % 40) + 0.5) * 0.1 - 2.0;
            let floor_point = DVec3::new(image_x_m, -1.0, floor_z);
            assert!(receiver.position.distance(floor_point) < 1e-5, "{i}: {} is not {floor_point}", receiver.position);
            assert!(from_depth.receivers[i].expect("it reflects").position.distance(floor_point) < 1e-5);
            let WorldHit::Hit { position, pixel, length_m, .. } = hit else { panic!("{i}: {hit:?}") };
            assert!(position.distance(DVec3::new(image_x_m, 3.0 - floor_z, 4.0)) < 1e-4, "{i}: {position}");
            assert!((length_m - 2_f64.sqrt() * (4.0 - floor_z)).abs() < 1e-4);
            // The mirrored ray stays in the pixel's column.
            assert!((pixel.expect("ahead").x - (f64::from(i as u32 % 40) + 0.5)).abs() < 1e-3, "{pixel:?}");
            reflecting_pixels += 1;
        }
        assert!(reflecting_pixels > 800, "{reflecting_pixels}");
    }

    #[test]
    fn a_hit_counts_only_within_two_per_cent_and_two_centimetres() {
        // At z = 4 the tolerance is 0.1 m; the wall's own pixels show the depth 4 · factor.
        for (factor, expected) in [(0.98, true), (1.02, true), (0.97, false), (1.03, false)] {
            let (scene, data) = gbuffer(factor);
            let world = World::new(&scene, &scene.materials);
            let hits = world_hits(&world, &data, &FirstHits::shown(&world, &data));
            let hit = hits[data.index(20, 38)];
            assert!(matches!(hit, WorldHit::Hit { visible, .. } if visible == expected), "{factor}: {hit:?}");
        }
    }

    #[test]
    fn without_a_wall_the_ray_escapes() {
        let (mut scene, data) = gbuffer(1.0);
        scene.meshes.pop();
        let world = World::new(&scene, &scene.materials);
        assert_eq!(world_hits(&world, &data, &FirstHits::shown(&world, &data))[data.index(3, 39)], WorldHit::Escaped);
    }
}
