//! What is rendered: meshes, materials, lights, cameras and views, as plain data on the host.
//!
//! World space is left-handed, in metres, +y up (DEFINITIONS, "Spaces"). A scene comes from a
//! scene file ([`scene_file`]), from OBJ files ([`obj`]) or from the built-in library
//! ([`library`]); all three give the same [`Scene`].

mod bounded;
pub mod camera;
pub mod gbuffer;
pub mod gbuffer_file;
pub mod library;
pub mod obj;
pub mod path;
pub mod pattern;
pub mod planes;
pub mod proxies;
pub mod scene_file;
pub mod sky;
pub mod texture;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

pub use camera::{Camera, Lens, View};
pub use gbuffer::GBufferData;
pub use path::CameraPath;
pub use proxies::{AreaLight, AreaShape, Impostor, Probe};
pub use texture::{Encoding, Texture};

/// The farthest coordinate from the origin that a file may place something at, in metres: products of two
/// differences stay in f32.
pub const MAX_COORDINATE_M: f32 = 1e8;

/// A scene, ready to be uploaded or ray traced.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// What records and file names call it.
    pub name: String,
    /// Triangle meshes, each of one material.
    pub meshes: Vec<Mesh>,
    /// Materials, by index from [`Mesh::material`].
    pub materials: Vec<Material>,
    /// Images, by index from the materials.
    pub textures: Vec<Texture>,
    /// Direct lights.
    pub lights: Vec<Light>,
    /// Where cube maps are captured, with their proxy boxes; never empty in a loaded scene.
    pub probes: Vec<Probe>,
    /// Rectangles that stand in reflections for things of the scene.
    pub impostors: Vec<Impostor>,
    /// Lights with an extent, which only the method `area-light` sees.
    pub area_lights: Vec<AreaLight>,
    /// The lens of every view that does not say otherwise.
    pub lens: Lens,
    /// Named views; never empty. The first is the default.
    pub views: Vec<View>,
    /// Named paths of the camera.
    pub paths: Vec<CameraPath>,
    /// One sentence for each thing that had to be replaced or left out on loading.
    pub warnings: Vec<String>,
}

/// A vertex as the GPU reads it (binding 0 of `shaders-glsl/scene/gbuffer.vert`).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Vertex {
    /// World position in metres.
    pub position: [f32; 3],
    /// Unit normal in world space.
    pub normal: [f32; 3],
    /// Texture coordinates, (0, 0) at the image's top left, wrapping.
    pub uv: [f32; 2],
    /// Unit tangent along +u; w = ±1 so that bitangent = w · cross(normal, tangent) runs along the
    /// normal map's green axis (towards −v: up in the image).
    pub tangent: [f32; 4],
}

/// Indexed triangles of one material.
///
/// The winding agrees with the normals: (b − a) × (c − a) points to the side of the vertex
/// normals. Both sides are drawn; from behind, the normal is turned round.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// Object or group name, for labels.
    pub name: String,
    /// Vertices.
    pub vertices: Vec<Vertex>,
    /// Three indices a triangle.
    pub indices: Vec<u32>,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// Bounds of the vertices, for culling.
    pub bounds: Aabb,
}

/// What a surface is to the reflections.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Surface {
    /// Lit; reflects as far as its reflectivity says.
    #[default]
    Lit,
    /// Shows the environment and reflects nothing, but has depth and can be hit (a window).
    Sky,
}

/// A material. Maps multiply their factors; an index points into [`Scene::textures`].
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// The name in MTL and scene files.
    pub name: String,
    /// Linear diffuse albedo, 0…1.
    pub albedo: Vec3,
    /// sRGB albedo image.
    pub albedo_map: Option<usize>,
    /// Tangent-space normal map, green up, linear.
    pub normal_map: Option<usize>,
    /// Alpha mask (red channel, linear): below ½ the surface is not there.
    pub alpha_mask: Option<usize>,
    /// Reflectivity, 0…1; a pixel reflects above 1e-4.
    pub reflectivity: f32,
    /// Reflectivity image (red channel, linear), times [`Material::reflectivity`].
    pub reflectivity_map: Option<usize>,
    /// Roughness ϱ, 0…1; 0 is a mirror.
    pub roughness: f32,
    /// How far the normal map counts, 0…1.
    pub normal_deviation: f32,
    /// What the surface is to the reflections.
    pub surface: Surface,
}

impl Default for Material {
    /// White, without maps, reflectivity 1, a mirror: the author's program's defaults.
    fn default() -> Self {
        Self {
            name: String::new(),
            albedo: Vec3::ONE,
            albedo_map: None,
            normal_map: None,
            alpha_mask: None,
            reflectivity: 1.0,
            reflectivity_map: None,
            roughness: 0.0,
            normal_deviation: 1.0,
            surface: Surface::Lit,
        }
    }
}

/// What a scene file or a view says of a material by its name; `None` leaves it as it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MaterialChange {
    /// Replaces the reflectivity, and its map.
    pub reflectivity: Option<f32>,
    /// Replaces the roughness.
    pub roughness: Option<f32>,
    /// Replaces the normal deviation.
    pub normal_deviation: Option<f32>,
}

impl MaterialChange {
    /// Applies the change to a material.
    pub fn apply(&self, material: &mut Material) {
        if let Some(reflectivity) = self.reflectivity {
            material.reflectivity = reflectivity;
            material.reflectivity_map = None;
        }
        if let Some(roughness) = self.roughness {
            material.roughness = roughness;
        }
        if let Some(deviation) = self.normal_deviation {
            material.normal_deviation = deviation;
        }
    }
}

/// A direct light without shadow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// A point light with the author's attenuation 1 / (1 + d/e + d²/e), d in metres.
    Point {
        /// World position.
        position: Vec3,
        /// Energy e > 0.
        energy: f32,
    },
    /// Parallel light.
    Directional {
        /// The direction that the light travels; unit length.
        direction: Vec3,
        /// Factor on max(0, N·L).
        energy: f32,
    },
}

impl Light {
    /// What the light adds to the shading of a point with a unit normal, ≥ 0; the sum over the lights
    /// is cut off at 1 (DEFINITIONS, "Surfaces").
    pub fn shading(&self, position: Vec3, normal: Vec3) -> f32 {
        match *self {
            Self::Point { position: light, energy } => {
                let to_light = light - position;
                let d = to_light.length();
                normal.dot(to_light.normalize_or_zero()).max(0.0) / (1.0 + d / energy + d * d / energy)
            }
            Self::Directional { direction, energy } => normal.dot(-direction).max(0.0) * energy,
        }
    }
}

/// An axis-aligned box. The default is empty (min > max).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Least corner.
    pub min: Vec3,
    /// Greatest corner.
    pub max: Vec3,
}

impl Default for Aabb {
    fn default() -> Self {
        Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY }
    }
}

impl Aabb {
    /// The box around some vertices; empty for none.
    pub fn of(vertices: &[Vertex]) -> Self {
        vertices.iter().fold(Self::default(), |b, v| {
            let p = Vec3::from(v.position);
            Self { min: b.min.min(p), max: b.max.max(p) }
        })
    }

    /// The box around two boxes.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }
}

/// What of a scene scales and moves by rules of its own.
struct Extended<'a> {
    paths: &'a mut [CameraPath],
    probes: &'a mut [Probe],
    impostors: &'a mut [Impostor],
    area_lights: &'a mut [AreaLight],
}

impl Scene {
    /// Bounds of all meshes.
    pub fn bounds(&self) -> Aabb {
        self.meshes.iter().fold(Aabb::default(), |b, m| b.union(m.bounds))
    }

    /// Scales all coordinates about the origin: those of views, paths, lights, probes and impostors too. Lenses and
    /// energies stay.
    pub fn scale(&mut self, factor: f32) {
        let Extended { paths, probes, impostors, area_lights } = self.move_points(|p| p * factor);
        paths.iter_mut().for_each(|p| p.scale(factor));
        probes.iter_mut().for_each(|p| p.scale(factor));
        impostors.iter_mut().for_each(|i| i.scale(factor));
        area_lights.iter_mut().for_each(|l| l.shape.scale(factor));
    }

    /// Moves everything that has a place.
    pub fn translate(&mut self, offset: Vec3) {
        let Extended { paths, probes, impostors, area_lights } = self.move_points(|p| p + offset);
        paths.iter_mut().for_each(|p| p.translate(offset));
        probes.iter_mut().for_each(|p| p.translate(offset));
        impostors.iter_mut().for_each(|i| i.centre += offset);
        area_lights.iter_mut().for_each(|l| l.shape.translate(offset));
    }

    /// Moves what has a place and no extent; gives what has an extent to the caller. Every field is named, so that a
    /// new one cannot be forgotten.
    fn move_points(&mut self, moved: impl Fn(Vec3) -> Vec3) -> Extended<'_> {
        let Self {
            name: _,
            meshes,
            materials: _,
            textures: _,
            lights,
            probes,
            impostors,
            area_lights,
            lens: _,
            views,
            paths,
            warnings: _,
        } = self;
        for mesh in meshes {
            let Mesh { name: _, vertices, indices: _, material: _, bounds } = mesh;
            for v in vertices.iter_mut() {
                v.position = moved(v.position.into()).to_array();
            }
            *bounds = Aabb::of(vertices);
        }
        for View { name: _, eye, look_at, lens: _, materials: _ } in views {
            (*eye, *look_at) = (moved(*eye), moved(*look_at));
        }
        for light in lights {
            match light {
                Light::Point { position, energy: _ } => *position = moved(*position),
                Light::Directional { direction: _, energy: _ } => {}
            }
        }
        Extended { paths, probes, impostors, area_lights }
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.meshes.iter().map(|m| m.indices.len() / 3).sum()
    }

    /// The view of a name, or an error that lists the names there are.
    pub fn view(&self, name: &str) -> crate::error::Result<&View> {
        self.views.iter().find(|v| v.name == name).ok_or_else(|| {
            let names: Vec<_> = self.views.iter().map(|v| v.name.as_str()).collect();
            crate::error::Error::Usage(format!(
                "scene {} has no view {name:?}; it has: {}",
                self.name,
                names.join(", ")
            ))
        })
    }

    /// The materials as a view shows them.
    pub fn materials_in(&self, view: &View) -> Vec<Material> {
        let mut materials = self.materials.clone();
        for (name, change) in &view.materials {
            for material in materials.iter_mut().filter(|m| m.name == *name) {
                change.apply(material);
            }
        }
        materials
    }
}
