//! Traces paths of light from area lights to diffuse surfaces, and from one surface to the next, for images like the
//! thesis's figure 2.4, which shows such light beside direct light alone. Surfaces cast shadows here, and light from
//! other surfaces replaces the constant ambient part. No method and no other reference has this light
//! (docs/definitions.md, "Surfaces").
//!
//! A path begins in a pixel. At each surface, a point is chosen on the lights, evenly over their areas. Its light is
//! added if nothing blocks it. Then the path goes on in a cosine-distributed direction. Every surface is treated as
//! diffuse, whatever its material reflects.

use super::first_hits::PrimaryRays;
use super::lobe::lobe_direction;
use super::surface::{SurfacePoint, World};
use super::world::RAY_START_M;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use ssct_geometry::bvh::WorldRay;
use ssct_ground::math::random::Stream;
use ssct_scenes::{AreaLight, AreaShape, Camera};
use std::f64::consts::PI;

/// Count of random numbers that place the begin of a path in the pixel.
const FIRST_NUMBERS: u64 = 2;
/// Count of random numbers that a path uses at each surface: three for a point of a light, and two for a direction.
const NUMBERS_OF_A_SURFACE: u64 = 5;
/// Count of random numbers that are reserved for a path: far more than it uses. Since the count does not depend on the
/// number of bounces, direct light is the same for each.
const NUMBERS_OF_A_PATH: u64 = 1 << 12;
/// Exponent of the Phong lobe around the normal that equals the cosine distribution.
const COSINE_EXPONENT: f64 = 1.0;
/// Share of a shadow ray's length, at its end, that is not traced, since the light itself may be hit there.
const UNTRACED_AT_LIGHT: f64 = 1e-6;

/// A rectangle that emits light on one side, in world space.
struct Panel {
    centre: DVec3,
    /// Vector from the centre to the middle of a side.
    half_u: DVec3,
    /// Vector from the centre to the middle of an adjacent side; the rectangle shines along half_u × half_v.
    half_v: DVec3,
    /// Area in m².
    area: f64,
    radiance: DVec3,
}

/// Computes the light of a world by paths.
pub struct Paths<'a> {
    world: &'a World<'a>,
    panels: Vec<Panel>,
    /// Number of times that surfaces pass light on; 0 is direct light alone.
    bounces: u32,
    seed: u64,
}

impl<'a> Paths<'a> {
    /// Prepares paths for the rectangular area lights of a world's scene; `None` if it has none. Light that surfaces
    /// pass on up to `bounces` times is included. Another seed gives an independent result.
    pub fn new(world: &'a World<'a>, bounces: u32, seed: u64) -> Option<Self> {
        let panels: Vec<_> = world.scene.area_lights.iter().filter_map(Panel::from_light).collect();
        (!panels.is_empty()).then_some(Self { world, panels, bounces, seed })
    }

    /// Returns the linear image of a camera with `extent` (width, height) pixels, rows from the top. A pixel is the
    /// mean over `paths` paths. Apart from the arguments, the image depends on the seed alone, and not on threads.
    pub fn image(&self, camera: &Camera, extent: [u32; 2], paths: u32) -> Vec<Vec3> {
        let rays = PrimaryRays::new(camera, extent);
        let pixel = |index: usize| {
            let stream = Stream::new(self.seed, index as u64);
            let path = |path_index: u32| {
                // Random number `k` of this path.
                let random_number = |k: u64| stream.uniform(NUMBERS_OF_A_PATH * u64::from(path_index) + k);
                let (ray, _) = rays.ray_within(index, [random_number(0), random_number(1)]);
                self.path(ray, &random_number)
            };
            ((0..paths).map(path).sum::<DVec3>() / f64::from(paths.max(1))).as_vec3()
        };
        (0..extent[0] as usize * extent[1] as usize).into_par_iter().map(pixel).collect()
    }

    /// Returns the radiance along a ray from the camera, by one path. `random_number(k)` is number k of the path.
    fn path(&self, mut ray: WorldRay, random_number: &impl Fn(u64) -> f64) -> DVec3 {
        // The sum of the light, and the throughput: the share of light at the current surface that reaches the camera.
        let (mut light, mut throughput) = (DVec3::ZERO, DVec3::ONE);
        for bounce in 0..=u64::from(self.bounces) {
            // Index of the first random number of this surface.
            let first_number = FIRST_NUMBERS + NUMBERS_OF_A_SURFACE * bounce;
            // A ray that leaves the scene brings no light, since the area lights are the only light.
            let Some(hit) = self.world.closest(&ray) else { return light };
            let point = self.world.point(&ray, &hit);
            if point.emission > 0.0 {
                // A lamp shows its colour to the camera. The light that it sends to another surface is added at that
                // surface, where a point of the lights is chosen.
                return if bounce == 0 { point.albedo } else { light };
            }
            throughput *= point.albedo;
            light += throughput * self.light_from_a_panel(&point, [0, 1, 2].map(|k| random_number(first_number + k)));
            let direction =
                lobe_direction(point.normal, COSINE_EXPONENT, [3, 4].map(|k| random_number(first_number + k)));
            ray = WorldRay { origin: point.position, direction, t_min: RAY_START_M, t_max: f64::INFINITY };
        }
        light
    }

    /// Returns the radiance of a diffuse surface, divided by its albedo, that comes from one random point of the
    /// lights. The three random numbers (0 to 1) choose the panel and the place on it.
    fn light_from_a_panel(&self, point: &SurfacePoint, [panel_choice, u, v]: [f64; 3]) -> DVec3 {
        let total_area: f64 = self.panels.iter().map(|panel| panel.area).sum();
        // A panel is chosen with a probability in proportion to its area.
        let mut area_left = panel_choice * total_area;
        let chosen = self.panels.iter().find(|panel| {
            area_left -= panel.area;
            area_left < 0.0
        });
        let Some(panel) = chosen.or(self.panels.last()) else { return DVec3::ZERO };
        let position = panel.centre + (2.0 * u - 1.0) * panel.half_u + (2.0 * v - 1.0) * panel.half_v;
        let to_light = position - point.position;
        let (length, direction) = (to_light.length(), to_light.normalize_or_zero());
        // Cosines at the light and at the surface.
        let light_cosine = panel.half_u.cross(panel.half_v).normalize_or_zero().dot(-direction).max(0.0);
        let surface_cosine = point.normal.dot(direction).max(0.0);
        if light_cosine * surface_cosine <= 0.0 || point.geometric_normal.dot(direction) <= 0.0 {
            return DVec3::ZERO;
        }
        let t_max = length * (1.0 - UNTRACED_AT_LIGHT);
        let shadow_ray = WorldRay { origin: point.position, direction, t_min: RAY_START_M, t_max };
        if self.world.closest(&shadow_ray).is_some() {
            return DVec3::ZERO;
        }
        // A diffuse surface reflects albedo / π, and the point was chosen with the density 1 / `total_area`.
        panel.radiance * (light_cosine * surface_cosine * total_area / (PI * length * length))
    }
}

impl Panel {
    /// Returns the rectangle of an area light; `None` for a light of another shape.
    fn from_light(light: &AreaLight) -> Option<Self> {
        let AreaShape::Rectangle { centre, half_u, half_v } = light.shape else { return None };
        let [centre, half_u, half_v, radiance] = [centre, half_u, half_v, light.radiance].map(|v| v.as_dvec3());
        Some(Self { centre, half_u, half_v, area: 4.0 * half_u.cross(half_v).length(), radiance })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::surface::tests::rectangle;
    use ssct_scenes::{FieldOfView, Lens, Material, Mesh, Scene, Vertex};

    /// Returns a light of 0.2 m × 0.2 m around a place, which shines downwards.
    fn lamp(centre: Vec3) -> AreaLight {
        let (half_u, half_v) = (0.1 * Vec3::X, 0.1 * Vec3::Z);
        AreaLight { shape: AreaShape::Rectangle { centre, half_u, half_v }, radiance: Vec3::new(10.0, 20.0, 0.0) }
    }

    /// Returns a grey material with the given albedo.
    fn grey(albedo: f32) -> Material {
        Material { albedo: Vec3::splat(albedo), ..Material::default() }
    }

    /// Returns the mean colour of the image of a camera at `eye` that looks down with a narrow field of view.
    fn seen_below(scene: &Scene, eye: Vec3, bounces: u32, paths: u32) -> Vec3 {
        let world = World::new(scene, &scene.materials);
        let lens = Lens { opening: FieldOfView::Angle(0.02), near_m: 0.01, ..Lens::default() };
        let camera = Camera::new(eye, eye - Vec3::Y + 0.001 * Vec3::X, lens, 1.0);
        let image = Paths::new(&world, bounces, 1).expect("a light").image(&camera, [4, 4], paths);
        image.iter().sum::<Vec3>() / 16.0
    }

    #[test]
    fn a_small_lamp_lights_what_is_below_it_by_the_square_of_the_distance() {
        let floor = rectangle(Vec3::new(-5.0, 0.0, -5.0), 10.0 * Vec3::Z, 10.0 * Vec3::X, 0);
        let mut scene = Scene {
            meshes: vec![floor],
            materials: vec![grey(0.5)],
            area_lights: vec![lamp(Vec3::new(0.0, 2.0, 0.0))],
            ..Scene::default()
        };
        // Radiance of the floor below the lamp: albedo / π · radiance · area / distance².
        let expected = 0.5 / std::f32::consts::PI * 10.0 * 0.04 / 4.0;
        let radiance = seen_below(&scene, Vec3::new(0.0, 1.0, 0.0), 0, 64);
        assert!((radiance.x / expected - 1.0).abs() < 0.01 && (radiance.y / expected - 2.0).abs() < 0.02, "{radiance}");
        assert_eq!(radiance.z, 0.0);
        // A plane floor does not light itself.
        assert_eq!(seen_below(&scene, Vec3::new(0.0, 1.0, 0.0), 3, 64), radiance);
        // A rectangle between lamp and floor casts a shadow.
        scene.meshes.push(rectangle(Vec3::new(-1.0, 1.5, -1.0), 2.0 * Vec3::Z, 2.0 * Vec3::X, 0));
        assert_eq!(seen_below(&scene, Vec3::new(0.0, 1.0, 0.0), 0, 64), Vec3::ZERO);
    }

    /// Returns a sphere around the origin with a radius of one metre.
    fn sphere() -> Mesh {
        let mut mesh = rectangle(Vec3::ZERO, Vec3::X, Vec3::Y, 0);
        let (columns, rows) = (96_u32, 48_u32);
        let vertex = |column: u32, row: u32| {
            let (phi, theta) = (
                std::f32::consts::TAU * column as f32 / columns as f32,
                std::f32::consts::PI * row as f32 / rows as f32,
            );
            let position = Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
            Vertex { position: position.to_array(), normal: position.to_array(), ..mesh.vertices[0] }
        };
        let vertices: Vec<_> = (0..=rows)
            .flat_map(|row| (0..=columns).map(move |column| (column, row)))
            .map(|(column, row)| vertex(column, row))
            .collect();
        let cell = |(column, row): (u32, u32)| {
            let (upper_left, lower_left) = (row * (columns + 1) + column, (row + 1) * (columns + 1) + column);
            [upper_left, upper_left + 1, lower_left, upper_left + 1, lower_left + 1, lower_left]
        };
        mesh.indices = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))).flat_map(cell).collect();
        mesh.vertices = vertices;
        mesh
    }

    #[test]
    fn in_a_sphere_each_bounce_adds_the_albedo_s_power_of_an_even_light() {
        let scene = Scene {
            meshes: vec![sphere()],
            materials: vec![grey(0.6)],
            area_lights: vec![lamp(Vec3::new(0.0, 0.3, 0.0))],
            ..Scene::default()
        };
        let red_after = |bounces| seen_below(&scene, Vec3::new(0.5, 0.0, 0.2), bounces, 4096).x;
        let direct = red_after(0);
        // The lamp's flux is spread evenly over the sphere; each surface multiplies it by the albedo, and radiance is
        // flux over π.
        let even_light = std::f32::consts::PI * 10.0 * 0.04 / (4.0 * std::f32::consts::PI) / std::f32::consts::PI;
        for bounces in [1, 2, 4] {
            let expected: f32 = (1..=bounces).map(|n| even_light * 0.6_f32.powi(n + 1)).sum();
            let indirect = red_after(bounces as u32) - direct;
            assert!((indirect / expected - 1.0).abs() < 0.05, "{bounces} bounces: {indirect} instead of {expected}");
        }
    }

    #[test]
    fn without_a_rectangular_light_there_are_no_paths() {
        let scene = Scene::default();
        assert!(Paths::new(&World::new(&scene, &[]), 1, 1).is_none());
    }
}
