//! The contents of a scene (meshes, materials, lights, cameras and views) as plain data on the host.
//!
//! World space is left-handed, in metres, +y up (docs/definitions.md, "Spaces"). Callers make a [`Scene`] of what they have; the
//! laboratory (`lab/`) loads scenes from files and generates others.

pub mod camera;
pub mod capture;
pub mod gbuffer;
pub mod motion;
pub mod path;
pub mod placement;
pub mod planes;
pub mod projection;
pub mod proxies;
pub mod sky;
pub mod texture;
pub mod tree;

use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec3, Vec3};

pub use camera::{Camera, Lens, View};
pub use capture::Capture;
pub use gbuffer::GBufferData;
pub use motion::Motion;
pub use path::CameraPath;
pub use placement::Placement;
pub use projection::{FieldOfView, Projection, ProjectionKind};
pub use proxies::{AreaLight, AreaShape, Impostor, Probe};
pub use texture::{Encoding, Texture};

/// The greatest distance from the origin, along each axis, at which a file may place something, in metres.
/// Within it, products of two differences stay finite in f32.
pub const MAX_COORDINATE_M: f32 = 1e8;

/// A scene, ready to be uploaded or ray traced.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// The name that records and file names use.
    pub name: String,
    /// Triangle meshes; each has one material.
    pub meshes: Vec<Mesh>,
    /// Materials; [`Mesh::material`] is an index into this list.
    pub materials: Vec<Material>,
    /// Images; materials and impostors refer to them by index.
    pub textures: Vec<Texture>,
    /// Direct lights.
    pub lights: Vec<Light>,
    /// The places where cube maps are captured, with their proxy boxes; never empty in a loaded scene.
    pub probes: Vec<Probe>,
    /// Rectangles with images that replace objects of the scene in reflections.
    pub impostors: Vec<Impostor>,
    /// Lights with an extent, which only the method `area-light` sees.
    pub area_lights: Vec<AreaLight>,
    /// The places where cubes of images are captured, the most helpful first; empty unless a scene file names places or the
    /// laboratory's placement finds some. At most [`capture::MAX_CAPTURES`].
    pub captures: Vec<Capture>,
    /// The lens of every view that has none of its own.
    pub lens: Lens,
    /// Named views; never empty in a loaded scene. The first view is the default.
    pub views: Vec<View>,
    /// Named paths of the camera.
    pub paths: Vec<CameraPath>,
    /// Named motions of the meshes. [`Scene::meshes`] stand as they do before any motion begins.
    pub motions: Vec<Motion>,
    /// One sentence for each thing that was replaced or left out while the scene was loaded.
    pub warnings: Vec<String>,
    /// One sentence for each value that was chosen where the file has none, and for the brightness of its lights.
    pub notes: Vec<String>,
}

/// A vertex as the GPU reads it (binding 0 of `shaders-glsl/scene/gbuffer.vert`).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Vertex {
    /// World position in metres.
    pub position: [f32; 3],
    /// Unit normal in world space.
    pub normal: [f32; 3],
    /// Texture coordinates, which wrap; (0, 0) is the image's top left corner.
    pub uv: [f32; 2],
    /// Unit tangent along +u; w = ±1 so that bitangent = w · cross(normal, tangent) runs along the
    /// normal map's green axis (towards −v: up in the image).
    pub tangent: [f32; 4],
}

/// Indexed triangles of one material.
///
/// The winding agrees with the normals: (b − a) × (c − a) points to the side of the vertex normals. Both sides
/// are drawn, and on the back the normal is flipped, unless the material is single-sided.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// The name of the object or group, for labels.
    pub name: String,
    /// Vertices.
    pub vertices: Vec<Vertex>,
    /// Three indices per triangle.
    pub indices: Vec<u32>,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// Bounds of the vertices, for culling.
    pub bounds: Aabb,
}

impl Mesh {
    /// Moves the mesh by an offset in metres.
    pub fn translate(&mut self, offset: Vec3) {
        self.vertices.iter_mut().for_each(|v| v.position = (Vec3::from(v.position) + offset).to_array());
        self.bounds = Aabb::around(&self.vertices);
    }

    /// Moves the mesh by a placement.
    pub fn place(&mut self, placement: &Placement) {
        self.vertices.iter_mut().for_each(|v| placement.place_vertex(v));
        self.bounds = Aabb::around(&self.vertices);
    }
}

/// How a surface takes part in reflections.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Surface {
    /// Lit by the scene's lights; reflects according to its reflectivity.
    #[default]
    Lit,
    /// Shows the environment, like a window. Such a surface reflects nothing, but has depth, and rays can hit it.
    Sky,
}

/// A material. A map is multiplied by the factor of the same quantity; map indices refer to [`Scene::textures`].
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// The name that MTL and scene files use.
    pub name: String,
    /// Linear diffuse albedo, 0…1.
    pub albedo: Vec3,
    /// sRGB albedo image.
    pub albedo_map: Option<usize>,
    /// Tangent-space normal map, green up, linear.
    pub normal_map: Option<usize>,
    /// Alpha mask (red channel, linear): the surface has holes where the mask is below ½.
    pub alpha_mask: Option<usize>,
    /// Reflectivity, 0…1; a pixel reflects if its reflectivity is above 1e-4.
    pub reflectivity: f32,
    /// Reflectivity image (red channel, linear), a factor on [`Material::reflectivity`].
    pub reflectivity_map: Option<usize>,
    /// Roughness ϱ, 0…1; 0 is a mirror.
    pub roughness: f32,
    /// Roughness image (green channel, linear), a factor on [`Material::roughness`].
    pub roughness_map: Option<usize>,
    /// The share of the albedo, 0…1, that is emitted: it is as bright as under full light, whatever the lights are. The
    /// alpha channel of the albedo image is a factor on this share.
    pub emission: f32,
    /// Whether the surface is absent when it is seen from behind.
    pub single_sided: bool,
    /// Weight of the normal map, 0…1.
    pub normal_deviation: f32,
    /// How the surface takes part in reflections.
    pub surface: Surface,
}

impl Default for Material {
    /// The defaults of the author's program: a white mirror of reflectivity 1 without maps.
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
            roughness_map: None,
            emission: 0.0,
            single_sided: false,
            normal_deviation: 1.0,
            surface: Surface::Lit,
        }
    }
}

/// The changes that a scene file or a view makes to a material; `None` leaves the value as it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MaterialChange {
    /// Replaces the reflectivity and removes its map.
    pub reflectivity: Option<f32>,
    /// Replaces the roughness and removes its map.
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
            material.roughness_map = None;
        }
        if let Some(deviation) = self.normal_deviation {
            material.normal_deviation = deviation;
        }
    }
}

/// A direct light that casts no shadows.
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
    /// The light's contribution, ≥ 0, to the shading of a point with a unit normal. The sum over all lights is
    /// clamped to 1 (docs/definitions.md, "Surfaces").
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
    /// The box of all of space.
    pub const ALL: Self = Self { min: Vec3::MIN, max: Vec3::MAX };

    /// The box between its least and its greatest corner; `None` if they are not finite, or are in the wrong order.
    pub fn between([min, max]: [[f32; 3]; 2]) -> Option<Self> {
        let (min, max) = (Vec3::from(min), Vec3::from(max));
        (min.is_finite() && max.is_finite() && min.cmple(max).all()).then_some(Self { min, max })
    }

    /// The box around some vertices; empty for none.
    pub fn around(vertices: &[Vertex]) -> Self {
        vertices.iter().fold(Self::default(), |bounds, vertex| {
            let point = Vec3::from(vertex.position);
            Self { min: bounds.min.min(point), max: bounds.max.max(point) }
        })
    }

    /// The box around two boxes.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The box moved by an offset.
    pub fn moved(self, offset: Vec3) -> Self {
        Self { min: self.min + offset, max: self.max + offset }
    }

    /// A box around everything in this box after a placement has moved it.
    pub fn placed(self, placement: &Placement) -> Self {
        if placement.is_offset() || !self.min.cmple(self.max).all() {
            return self.moved(placement.offset);
        }
        // Each bit of a corner's number says whether the corner is at the greatest or the least value of one axis.
        let corner = |i: u32| Vec3::select(glam::BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), self.max, self.min);
        let corners = (0..8).map(|i| placement.place(corner(i)));
        corners.fold(Self::default(), |bounds, p| Self { min: bounds.min.min(p), max: bounds.max.max(p) })
    }

    /// Returns the box grown on every side by a share of its diagonal; [`Self::ALL`] for an empty box.
    pub fn grown(self, share: f32) -> Self {
        if !self.min.cmple(self.max).all() {
            return Self::ALL;
        }
        let margin = share * self.min.distance(self.max);
        Self { min: self.min - margin, max: self.max + margin }
    }
}

impl View {
    /// The view's camera for an image of a size in pixels, with the view's lens or the scene's.
    pub fn camera(&self, scene: &Scene, [width, height]: [u32; 2]) -> Camera {
        Camera::new(self.eye, self.look_at, self.lens.unwrap_or(scene.lens), width as f32 / height as f32)
    }
}

/// The parts of a scene that [`Scene::scale`] and [`Scene::translate`] change each in its own way.
struct PartsBesidePoints<'a> {
    paths: &'a mut [CameraPath],
    motions: &'a mut [Motion],
    probes: &'a mut [Probe],
    impostors: &'a mut [Impostor],
    area_lights: &'a mut [AreaLight],
    captures: &'a mut [Capture],
}

impl Scene {
    /// Bounds of all meshes.
    pub fn bounds(&self) -> Aabb {
        self.meshes.iter().fold(Aabb::default(), |bounds, mesh| bounds.union(mesh.bounds))
    }

    /// Scales all lengths about the origin: those of views, paths, lights, probes, impostors and captures, and the clip planes and
    /// heights of lenses. Energies of point lights scale as lengths squared.
    pub fn scale(&mut self, factor: f32) {
        let view_lenses = self.views.iter_mut().filter_map(|view| view.lens.as_mut());
        for lens in view_lenses.chain([&mut self.lens]) {
            *lens = lens.scaled(factor);
        }
        for light in &mut self.lights {
            if let Light::Point { energy, .. } = light {
                *energy *= factor * factor;
            }
        }
        let PartsBesidePoints { paths, motions, probes, impostors, area_lights, captures } =
            self.move_points(|p| p * factor);
        let matrix = DMat4::from_scale(DVec3::splat(factor.into()));
        motions.iter_mut().for_each(|m| m.transform(&matrix));
        paths.iter_mut().for_each(|p| p.scale(factor));
        probes.iter_mut().for_each(|p| p.scale(factor));
        impostors.iter_mut().for_each(|i| i.scale(factor));
        area_lights.iter_mut().for_each(|l| l.shape.scale(factor));
        captures.iter_mut().for_each(|c| c.scale(factor));
    }

    /// Moves everything that has a place by an offset in metres.
    pub fn translate(&mut self, offset: Vec3) {
        let PartsBesidePoints { paths, motions, probes, impostors, area_lights, captures } =
            self.move_points(|p| p + offset);
        let matrix = DMat4::from_translation(offset.as_dvec3());
        motions.iter_mut().for_each(|m| m.transform(&matrix));
        paths.iter_mut().for_each(|p| p.translate(offset));
        probes.iter_mut().for_each(|p| p.translate(offset));
        impostors.iter_mut().for_each(|i| i.centre += offset);
        area_lights.iter_mut().for_each(|l| l.shape.translate(offset));
        captures.iter_mut().for_each(|c| c.position += offset);
    }

    /// Moves the points of meshes, views and lights by the function `moved`, and returns the other parts that have
    /// places. Every field is named, so that a new field cannot be forgotten.
    fn move_points(&mut self, moved: impl Fn(Vec3) -> Vec3) -> PartsBesidePoints<'_> {
        let Self {
            name: _,
            meshes,
            materials: _,
            textures: _,
            lights,
            probes,
            impostors,
            area_lights,
            captures,
            lens: _,
            views,
            paths,
            motions,
            warnings: _,
            notes: _,
        } = self;
        for mesh in meshes {
            let Mesh { name: _, vertices, indices: _, material: _, bounds } = mesh;
            for vertex in vertices.iter_mut() {
                vertex.position = moved(vertex.position.into()).to_array();
            }
            *bounds = Aabb::around(vertices);
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
        PartsBesidePoints { paths, motions, probes, impostors, area_lights, captures }
    }

    /// The number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.meshes.iter().map(|m| m.indices.len() / 3).sum()
    }

    /// Finds a view by name.
    ///
    /// # Errors
    /// [`Usage`](crate::error::Error::Usage), which lists the scene's views, if no view has this name.
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

    /// The scene's materials with the changes that a view makes to them.
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
