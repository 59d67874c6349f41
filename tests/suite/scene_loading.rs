//! Tests loading scenes: every quirk of OBJ, MTL, glTF and scene files that is promised to be handled, every error with
//! its sentence, the large shared scenes if they are present, and mutated files.

mod allowed;
mod compressed;
mod coordinates;
mod errors;
mod exporters;
mod extensions;
mod far_away;
mod geometry;
mod gltf;
mod lenient;
mod lights;
mod materials;
mod motions;
mod mutations;
mod scene_files;
mod shared_scenes;
mod textures;

use glam::{Vec2, Vec3};
use ssct_geometry::texture::MAX_EXTENT;
use ssct_scenes::obj::{Handedness, ObjFile, ObjOptions};
use ssct_scenes::{LoadOptions, Material, Mesh, Scene, Vertex, obj};
use std::path::PathBuf;
use tempfile::TempDir;

/// A temporary folder with files.
struct Folder(TempDir);

impl Folder {
    /// Makes a folder with files, each a name and a text.
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (name, text) in files {
            folder.write(name, text.as_bytes());
        }
        folder
    }

    /// Returns the path of a file in the folder.
    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file, and makes the folders in which it lies.
    fn write(&self, name: &str, bytes: &[u8]) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }

    /// Writes a picture in the format that the ending of its name says.
    fn image(&self, name: &str, width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 4]) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        image::RgbaImage::from_fn(width, height, |x, y| image::Rgba(texel(x, y))).save(path).unwrap();
    }

    /// Loads `a.obj` with its coordinates unchanged: as a left-handed file.
    fn scene(&self) -> Scene {
        self.load("a.obj", &LEFT).unwrap()
    }

    /// Loads an OBJ file of the folder.
    fn load(&self, name: &str, options: &ObjOptions) -> ssct_ground::Result<Scene> {
        obj::load(&[ObjFile::from(self.path(name))], options)
    }

    /// Returns the error of loading `a.obj`, without the path of the folder.
    fn error(&self) -> String {
        self.without_folder(&self.load("a.obj", &LEFT).unwrap_err().to_string())
    }

    /// Returns a text without the path of the folder.
    fn without_folder(&self, text: &str) -> String {
        text.replace(&format!("{}/", self.0.path().display()), "")
    }

    /// Returns the warnings about a scene, without the path of the folder.
    fn warnings(&self, scene: &Scene) -> Vec<String> {
        scene.warnings.iter().map(|w| self.without_folder(w)).collect()
    }
}

/// Options for left-handed coordinates that are not scaled.
const LEFT: ObjOptions = ObjOptions { handedness: Handedness::Left, load: scaled(1.0) };

/// Returns options that multiply coordinates by a factor and change nothing else.
const fn scaled(scale: f32) -> LoadOptions {
    LoadOptions { scale, texture_side: MAX_EXTENT }
}

/// A unit square in the xy plane, its normal along +z by winding, textured upright.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";

/// Makes a folder with `a.obj`: the square's vertices, and then other lines such as faces.
fn square(rest: &str) -> Folder {
    Folder::new(&[("a.obj", &format!("{SQUARE}{rest}"))])
}

/// Returns the position of a vertex.
fn position(vertex: &Vertex) -> Vec3 {
    vertex.position.into()
}

/// Returns the normal of a vertex.
fn normal(vertex: &Vertex) -> Vec3 {
    vertex.normal.into()
}

/// Returns the three vertices of each triangle.
fn triangles(mesh: &Mesh) -> impl Iterator<Item = [Vertex; 3]> + '_ {
    mesh.indices.chunks_exact(3).map(|t| [0, 1, 2].map(|i| mesh.vertices[t[i] as usize]))
}

/// Returns the sum of the areas of all triangles.
fn area(scene: &Scene) -> f32 {
    let cross = |[a, b, c]: [Vertex; 3]| (position(&b) - position(&a)).cross(position(&c) - position(&a));
    scene.meshes.iter().flat_map(triangles).map(|t| 0.5 * cross(t).length()).sum()
}

/// Checks the properties that every loaded scene has, whatever its files are like: finite vertices, unit normals,
/// tangents at right angles, indices within their lists, and a winding that fits the normals.
fn assert_sound(scene: &Scene) {
    assert!(!scene.views.is_empty() && !scene.lights.is_empty());
    for mesh in &scene.meshes {
        assert!(mesh.material < scene.materials.len() && !mesh.indices.is_empty());
        for vertex in &mesh.vertices {
            let tangent = Vec3::from_slice(&vertex.tangent[..3]);
            assert!(position(vertex).is_finite() && Vec2::from(vertex.uv).is_finite());
            assert!((normal(vertex).length() - 1.0).abs() < 1e-4, "{vertex:?}");
            assert!((tangent.length() - 1.0).abs() < 1e-3, "{vertex:?}");
            assert!(tangent.dot(normal(vertex)).abs() < 1e-3, "{vertex:?}");
            assert_eq!(vertex.tangent[3].abs(), 1.0);
            assert!(position(vertex).cmpge(mesh.bounds.min).all() && position(vertex).cmple(mesh.bounds.max).all());
        }
        for [a, b, c] in triangles(mesh) {
            let edge = |v: &Vertex| (position(v) - position(&a)).as_dvec3();
            let cross = edge(&b).cross(edge(&c));
            // Smooth normals may lean behind their face, but must not point to its back.
            let normal_sum = (normal(&a) + normal(&b) + normal(&c)).as_dvec3();
            let least_dot = -(0.5 * normal_sum.length() + 1e-4) * cross.length();
            assert!(cross.dot(normal_sum) >= least_dot, "the winding disagrees with the normals: {a:?} {b:?} {c:?}");
        }
    }
    for material in &scene.materials {
        let Material { albedo_map, normal_map, alpha_mask, reflectivity_map, roughness_map, .. } = *material;
        let maps = [albedo_map, normal_map, alpha_mask, reflectivity_map, roughness_map];
        assert!(maps.into_iter().flatten().all(|i| i < scene.textures.len()));
        let shares = [material.reflectivity, material.roughness, material.emission];
        assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)), "{material:?}");
    }
}
