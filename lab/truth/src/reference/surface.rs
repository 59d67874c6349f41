//! The surface that a ray sees where it hits a triangle: the CPU version of `shaders-glsl/scene/gbuffer.frag` and
//! `lighting.frag`, in f64 and in world space.
//!
//! Texture images are sampled at their finest level, bilinearly and repeating, because a ray has no footprint. The
//! G-buffer filters the same images over the pixel, and stores albedo in 8 bits and normals in 16. There is no other
//! difference.

use glam::{DVec2, DVec3, DVec4, Vec3};
use ssct_geometry::bvh::{TriangleHit, WorldRay};
use ssct_geometry::texture::bilinear;
use ssct_geometry::triangles::Triangles;
use ssct_geometry::triangles::{TriangleRef, interpolate_uv};
use ssct_scenes::{Light, Material, Scene, Surface, Vertex, sky};

/// A scene with the materials of a view, prepared for ray tracing.
pub struct World<'a> {
    /// Geometry, images and lights.
    pub scene: &'a Scene,
    /// The materials that replace the scene's own, with the same indices.
    pub materials: &'a [Material],
    /// The hierarchy over all triangles.
    triangles: Triangles<'a>,
}

/// A point of a surface as seen by a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// World position in metres.
    pub position: DVec3,
    /// Unit normal of the triangle, on the side from which the ray comes.
    pub geometric_normal: DVec3,
    /// Unit shading normal, flipped on surfaces that are seen from behind.
    pub normal: DVec3,
    /// Linear albedo.
    pub albedo: DVec3,
    /// The share of the albedo that is emitted, 0…1.
    pub emission: f64,
    /// Reflectivity, 0…1; 0 for a surface that shows the sky.
    pub reflectivity: f64,
    /// Roughness ϱ.
    pub roughness: f64,
    /// Kind of the surface in reflections: lit, or showing the sky.
    pub surface: Surface,
}

impl<'a> World<'a> {
    /// Prepares a scene with the materials of a view: builds the hierarchy over all its triangles.
    pub fn new(scene: &'a Scene, materials: &'a [Material]) -> Self {
        Self { scene, materials, triangles: Triangles::new(scene, materials) }
    }

    /// Returns the closest hit of a ray; `None` if it escapes. The ray passes through a triangle where an alpha mask is
    /// below ½.
    pub fn closest(&self, ray: &WorldRay) -> Option<TriangleHit> {
        self.triangles.closest(ray)
    }

    /// Returns the mesh and the triangle of a hit.
    pub fn triangle(&self, hit: &TriangleHit) -> TriangleRef {
        self.triangles.origin(hit)
    }

    /// Returns the surface point of a ray's hit, with its material there.
    pub fn point(&self, ray: &WorldRay, hit: &TriangleHit) -> SurfacePoint {
        let (material, vertices) = self.triangles.surface(hit);
        let [a, b, c] = vertices.map(|v| Vec3::from(v.position).as_dvec3());
        let front_normal = (b - a).cross(c - a).normalize_or(-ray.direction);
        // 1 for a ray that comes from in front of the triangle, and −1, which flips the normals, for a ray from behind.
        let side = if front_normal.dot(ray.direction) <= 0.0 { 1.0 } else { -1.0 };
        let uv = interpolate_uv(&vertices, hit);
        let is_lit = material.surface == Surface::Lit;
        // The values of the maps, which are factors of the material's own values.
        let albedo = material.albedo_map.map_or(DVec4::ONE, |map| self.sample(map, uv));
        let reflectivity = material.reflectivity_map.map_or(1.0, |map| self.sample(map, uv).x);
        let roughness = material.roughness_map.map_or(1.0, |map| self.sample(map, uv).y);
        SurfacePoint {
            position: interpolate(&vertices, hit, |v| v.position),
            geometric_normal: side * front_normal,
            normal: side * self.normal(material, &vertices, hit, uv, front_normal),
            albedo: albedo.truncate() * material.albedo.as_dvec3(),
            emission: f64::from(material.emission) * albedo.w,
            reflectivity: if is_lit { f64::from(material.reflectivity) * reflectivity } else { 0.0 },
            roughness: f64::from(material.roughness) * roughness,
            surface: material.surface,
        }
    }

    /// Returns the linear colour that a ray sees at a point: the lit colour or, on sky surfaces, the environment in the
    /// ray's direction.
    pub fn color(&self, ray: &WorldRay, point: &SurfacePoint) -> DVec3 {
        match point.surface {
            Surface::Lit => lit_color(point, &self.scene.lights),
            Surface::Sky => sky_color(ray.direction),
        }
    }

    /// Returns the unit shading normal on the front of the triangle, computed as in `gbuffer.frag`. The unit normal
    /// of the triangle itself is used if the vertices have none.
    fn normal(
        &self,
        material: &Material,
        vertices: &[&Vertex; 3],
        hit: &TriangleHit,
        uv: DVec2,
        triangle_normal: DVec3,
    ) -> DVec3 {
        let vertex_normal = interpolate(vertices, hit, |v| v.normal).normalize_or(triangle_normal);
        let deviation = f64::from(material.normal_deviation);
        let Some(map) = material.normal_map.filter(|_| deviation > 0.0) else { return vertex_normal };
        let raw_tangent = interpolate(vertices, hit, |v| [v.tangent[0], v.tangent[1], v.tangent[2]]);
        let tangent = raw_tangent - vertex_normal * vertex_normal.dot(raw_tangent);
        if tangent.length() <= 1e-6 {
            return vertex_normal;
        }
        let tangent = tangent.normalize();
        let handedness: f64 = vertices.iter().zip(hit.barycentrics).map(|(v, w)| w * f64::from(v.tangent[3])).sum();
        let bitangent = handedness * vertex_normal.cross(tangent);
        let map_normal = self.sample(map, uv).truncate() * 2.0 - 1.0;
        let bumped_normal =
            (tangent * map_normal.x + bitangent * map_normal.y + vertex_normal * map_normal.z.max(1e-3)).normalize();
        vertex_normal.lerp(bumped_normal, deviation).normalize_or(vertex_normal)
    }

    /// Returns the linear value of a texture at texture coordinates.
    fn sample(&self, texture: usize, uv: DVec2) -> DVec4 {
        bilinear(&self.scene.textures[texture], uv)
    }
}

/// Returns the linear lit colour albedo · mix(mix(0.2, 1, min(Σ lights, 1)), 1, emission), without shadows
/// (docs/definitions.md, "Surfaces"; `lighting.frag`).
pub fn lit_color(point: &SurfacePoint, lights: &[Light]) -> DVec3 {
    let SurfacePoint { position, normal, albedo, emission, .. } = *point;
    let shading: f64 = lights
        .iter()
        .map(|light| match *light {
            Light::Point { position: light_position, energy } => {
                let to_light = light_position.as_dvec3() - position;
                let (distance, energy) = (to_light.length(), f64::from(energy));
                normal.dot(to_light / distance.max(1e-6)).max(0.0)
                    / (1.0 + distance / energy + distance * distance / energy)
            }
            Light::Directional { direction, energy } => {
                normal.dot(-direction.as_dvec3().normalize_or_zero()).max(0.0) * f64::from(energy)
            }
        })
        .sum();
    let lit = 0.2 + 0.8 * shading.min(1.0);
    albedo * (lit + (1.0 - lit) * emission)
}

/// Returns the linear colour of the environment in a world direction.
pub fn sky_color(direction: DVec3) -> DVec3 {
    sky::radiance(direction.as_vec3()).as_dvec3()
}

/// Returns an attribute at a hit, interpolated between the three vertices of the triangle.
fn interpolate(vertices: &[&Vertex; 3], hit: &TriangleHit, attribute: impl Fn(&Vertex) -> [f32; 3]) -> DVec3 {
    vertices.iter().zip(hit.barycentrics).map(|(v, weight)| weight * Vec3::from(attribute(v)).as_dvec3()).sum()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use ssct_ground::math::srgb_to_linear;
    use ssct_scenes::{Aabb, Encoding, Mesh, Texture};

    /// Returns a rectangle that the edges `u` and `v` span from a corner. Its front is the side to which u × v points.
    /// Texture coordinates are (0, 0) at the corner and (1, 1) at the opposite one.
    pub fn rectangle(corner: Vec3, u: Vec3, v: Vec3, material: usize) -> Mesh {
        let normal = u.cross(v).normalize();
        let vertex = |s: f32, t: f32| Vertex {
            position: (corner + s * u + t * v).to_array(),
            normal: normal.to_array(),
            uv: [s, t],
            tangent: u.normalize().extend(1.0).to_array(),
        };
        let vertices = vec![vertex(0.0, 0.0), vertex(1.0, 0.0), vertex(1.0, 1.0), vertex(0.0, 1.0)];
        let bounds = Aabb::around(&vertices);
        Mesh { name: "rectangle".into(), vertices, indices: vec![0, 1, 2, 0, 2, 3], material, bounds }
    }

    /// Returns a texture of this width from its bytes, four for each texel.
    pub fn texture(width: u32, rgba: Vec<u8>, encoding: Encoding) -> Texture {
        let height = rgba.len() as u32 / 4 / width;
        Texture { name: "test".into(), width, height, rgba, encoding }
    }

    /// Returns a ray along a direction of any length, whose hits count at any distance from 0 on.
    fn ray(origin: [f64; 3], direction: [f64; 3]) -> WorldRay {
        WorldRay {
            origin: DVec3::from(origin),
            direction: DVec3::from(direction).normalize(),
            t_min: 0.0,
            t_max: f64::INFINITY,
        }
    }

    /// Returns a scene of the unit square in the plane z = 1, with its front towards −z, and a wall behind it at z = 2.
    /// The square has the material `front_material`.
    fn two_walls(front_material: Material, textures: Vec<Texture>) -> Scene {
        Scene {
            meshes: vec![
                rectangle(Vec3::Z, Vec3::Y, Vec3::X, 0),
                rectangle(Vec3::new(-5.0, -5.0, 2.0), 10.0 * Vec3::Y, 10.0 * Vec3::X, 1),
            ],
            materials: vec![front_material, Material::default()],
            textures,
            ..Scene::default()
        }
    }

    #[test]
    fn a_ray_passes_through_the_holes_of_a_mask() {
        // u runs along +y, so that the mask has a hole below y = ½.
        let mask = texture(2, [vec![0; 4], vec![255; 4]].concat(), Encoding::Linear);
        let scene = two_walls(Material { alpha_mask: Some(0), ..Material::default() }, vec![mask]);
        let world = World::new(&scene, &scene.materials);
        let distance = |y: f64| world.closest(&ray([0.5, y, 0.0], [0.0, 0.0, 1.0])).map(|h| h.t);
        assert_eq!(distance(0.3), Some(2.0), "through the hole");
        assert_eq!(distance(0.7), Some(1.0));
        // Between the texel centres at ¼ and ¾ the mask is a ramp that is ½ in the middle.
        assert_eq!((distance(0.499), distance(0.501)), (Some(2.0), Some(1.0)));
        let opaque = vec![Material::default(); 2];
        let hit = World::new(&scene, &opaque).closest(&ray([0.5, 0.3, 0.0], [0.0, 0.0, 1.0]));
        assert_eq!(hit.map(|h| h.t), Some(1.0), "the view's materials must be used, not the scene's");
    }

    #[test]
    fn both_sides_are_seen_and_the_normal_faces_the_ray() {
        let scene = two_walls(Material::default(), vec![]);
        let world = World::new(&scene, &scene.materials);
        for (start_z, direction_z) in [(0.0, 1.0), (1.5, -1.0)] {
            let ray = ray([0.5, 0.5, start_z], [0.1, 0.0, direction_z]);
            let hit = world.closest(&ray).expect("a wall");
            assert_eq!(world.triangle(&hit).mesh, 0);
            let point = world.point(&ray, &hit);
            assert_eq!(point.normal, DVec3::new(0.0, 0.0, -direction_z));
            assert_eq!(point.geometric_normal, point.normal);
            assert!((point.position - ray.point_at(hit.t)).length() < 1e-12);
        }
    }

    #[test]
    fn images_are_bilinear_repeating_and_decoded() {
        let bytes = [[0, 0, 0, 255], [255, 188, 0, 255]].concat();
        let srgb = texture(2, bytes.clone(), Encoding::Srgb);
        let scene = two_walls(Material::default(), vec![srgb, texture(2, bytes, Encoding::Linear)]);
        let world = World::new(&scene, &scene.materials);
        let decoded_188 = f64::from(srgb_to_linear(188.0 / 255.0));
        // The texel centres are at ¼ and ¾; ½ is halfway between them, and 0 between the last and the first texel.
        for (u, share) in [(0.25, 0.0), (0.75, 1.0), (0.5, 0.5), (0.375, 0.25), (0.0, 0.5), (1.0, 0.5), (-3.25, 1.0)] {
            let uv = DVec2::new(u, 0.7);
            let expected = DVec4::new(share, share * decoded_188, 0.0, 1.0);
            assert!((world.sample(0, uv) - expected).length() < 1e-6, "{u}: {}", world.sample(0, uv));
            let raw = DVec4::new(share, share * 188.0 / 255.0, 0.0, 1.0);
            assert!((world.sample(1, uv) - raw).length() < 1e-12);
        }
    }

    #[test]
    fn a_normal_map_tilts_along_the_tangent_by_the_normal_deviation() {
        // The normal (0.6, 0, 0.8) as bytes, in every texel.
        let map = texture(1, vec![204, 128, 230, 255], Encoding::Linear);
        let material = |deviation| Material {
            normal_map: Some(0),
            normal_deviation: deviation,
            albedo: Vec3::new(0.5, 0.25, 1.0),
            ..Material::default()
        };
        let ray = ray([0.5, 0.5, 0.0], [0.0, 0.0, 1.0]);
        let normal = |deviation| {
            let scene = two_walls(material(deviation), vec![map.clone()]);
            let world = World::new(&scene, &scene.materials);
            let hit = world.closest(&ray).expect("a wall");
            assert_eq!(world.point(&ray, &hit).albedo, DVec3::new(0.5, 0.25, 1.0));
            world.point(&ray, &hit).normal
        };
        // The tangent is +y, and the front faces −z.
        assert_eq!(normal(0.0), DVec3::NEG_Z);
        assert!((normal(1.0) - DVec3::new(0.0, 0.6, -0.8)).length() < 0.01, "{}", normal(1.0));
        let half_tilted = DVec3::new(0.0, 0.3, -0.9).normalize();
        assert!((normal(0.5) - half_tilted).length() < 0.01);
    }

    #[test]
    fn lights_add_up_to_at_most_one_over_an_ambient_fifth() {
        let lit_with = |emission: f64, lights: &[Light]| {
            let point = SurfacePoint {
                position: DVec3::ZERO,
                geometric_normal: DVec3::Y,
                normal: DVec3::Y,
                albedo: DVec3::new(1.0, 0.5, 0.0),
                emission,
                reflectivity: 0.0,
                roughness: 0.0,
                surface: Surface::Lit,
            };
            lit_color(&point, lights).x
        };
        let lit = |lights: &[Light]| lit_with(0.0, lights);
        let lamp_at = |y: f32, energy: f32| Light::Point { position: Vec3::new(0.0, y, 0.0), energy };
        assert_eq!(lit(&[]), 0.2);
        // d = 2, e = 4: 1 / (1 + ½ + 1) = 0.4.
        assert!((lit(&[lamp_at(2.0, 4.0)]) - (0.2 + 0.8 * 0.4)).abs() < 1e-12);
        assert_eq!(lit(&[lamp_at(-2.0, 4.0)]), 0.2, "from below");
        let sun = Light::Directional { direction: Vec3::new(1.0, -1.0, 0.0), energy: 0.5 };
        assert!((lit(&[sun]) - (0.2 + 0.8 * 0.5 * 0.5_f64.sqrt())).abs() < 1e-7);
        assert_eq!(lit(&[sun, sun, sun, lamp_at(0.1, 100.0)]), 1.0);
        // Emitted light needs no lamp.
        assert!((lit_with(0.5, &[]) - 0.6).abs() < 1e-12 && lit_with(1.0, &[]) == 1.0);
    }

    #[test]
    fn a_window_shows_the_sky_and_reflects_nothing() {
        let scene = two_walls(Material { surface: Surface::Sky, ..Material::default() }, vec![]);
        let world = World::new(&scene, &scene.materials);
        let ray = ray([0.5, 0.5, 0.0], [0.1, 0.2, 1.0]);
        let point = world.point(&ray, &world.closest(&ray).expect("a window"));
        assert_eq!(point.reflectivity, 0.0);
        assert_eq!(world.color(&ray, &point), sky_color(ray.direction));
    }
}
