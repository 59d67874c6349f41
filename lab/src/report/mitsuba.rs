//! Writes a scene, a camera and results of the world reference as files, so that Mitsuba 3 can check them (`scripts/mitsuba_compare.py`).
//! The thesis compares with Mitsuba, too (ch. 5).
//!
//! `scene.xml` with `meshes/*.ply` and `textures/*.png` is the scene as Mitsuba reads it, with the same coordinates.
//! Mitsuba takes these for right-handed coordinates. That changes no ray, and the sensor's matrix mirrors x to make up
//! for it. `truth.json` says what the arrays `*.npy` hold. Mitsuba doesn't know the environment, so here a surface that
//! shows the environment counts as a lit surface, in the reference as well.

use super::images::write_rgba_png;
use crate::study::names::json_text;
use glam::{DMat4, DVec3, Vec3};
use rayon::prelude::*;
use serde_json::{Value, json};
use ssct_geometry::bvh::{TriangleHit, WorldRay};
use ssct_ground::{Error, Result};
use ssct_scenes::inside::PathInFolder;
use ssct_scenes::{Camera, Encoding, Light, Material, Mesh, Scene, Surface};
use ssct_truth::reference::first_hits::{FirstHits, PrimaryRays};
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world::{RAY_START_M, WorldReference};
use std::fmt::Write as _;

/// The scene, the camera and the settings of an export.
pub struct Export<'a> {
    /// Geometry, images and lights.
    pub scene: &'a Scene,
    /// Materials in place of the scene's own.
    pub materials: &'a [Material],
    /// The camera that sees the scene.
    pub camera: Camera,
    /// Size in pixels.
    pub extent: [u32; 2],
    /// Samples of each glossy pixel of the reference.
    pub samples: u32,
    /// Seed of the reference.
    pub seed: u64,
}

/// Numbers of a finished export.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Exported {
    /// Number of triangles.
    pub triangles: usize,
    /// Number of reflecting pixels.
    pub receivers: usize,
    /// Overall standard error of the reference, linear colour.
    pub standard_error: f64,
}

/// Writes the scene, the camera and the results of the world reference into a folder.
///
/// # Errors
/// [`Usage`](ssct_ground::Error::Usage) for an orthographic camera, and errors of writing files.
pub fn export(folder: &PathInFolder, input: &Export) -> Result<Exported> {
    let fov_y_radians = input.camera.lens.fov_y_radians().ok_or_else(|| {
        let message = "scenes are exported for Mitsuba with perspectives alone, and this camera is orthographic";
        Error::Usage(message.into())
    })?;
    let materials: Vec<Material> = input.materials.iter().map(without_sky).collect();
    let world = World::new(input.scene, &materials);
    let first_hits = FirstHits::trace(&world, &input.camera, input.extent);
    // All rays of a pixel start at one point, which is exported, so that Mitsuba can trace from the same points.
    let reference = WorldReference::of_centres(&world, &first_hits, input.seed);
    let mut state = reference.start();
    reference.add(&mut state, input.samples);

    folder.join("scene.xml").write(scene_xml(input, fov_y_radians, &materials).as_bytes())?;
    for (i, mesh) in input.scene.meshes.iter().enumerate() {
        folder.join(mesh_file(i)).write(&encode_ply(mesh))?;
    }
    for (i, texture) in input.scene.textures.iter().enumerate() {
        write_rgba_png(folder.join(texture_file(i)), [texture.width, texture.height], &texture.rgba)?;
    }
    let arrays = Arrays(folder);
    arrays.write_primary(&world, input, &first_hits)?;
    let reflecting: Vec<usize> =
        (0..first_hits.receivers.len()).filter(|i| first_hits.receivers[*i].is_some()).collect();
    arrays.write_receivers(&world, &first_hits)?;
    // The vectors of the reflecting pixels alone, as numbers one after the other.
    let reflecting_values =
        |vectors: Vec<DVec3>| -> Vec<f64> { reflecting.iter().flat_map(|i| vectors[*i].to_array()).collect() };
    arrays.write_f64s("reflection_mean", 3, reflecting_values(state.means().collect()))?;
    arrays.write_f64s("reflection_error", 3, reflecting_values(state.standard_errors().collect()))?;
    arrays.write_i32s("receiver_pixel", reflecting.iter().map(|i| *i as i32).collect())?;
    arrays.write_tangents(&input.scene.meshes)?;
    let text = serde_json::to_string_pretty(&truth_json(input, &materials)).unwrap_or_else(|e| e.to_string());
    folder.join("truth.json").write(json_text(&text).as_bytes())?;
    Ok(Exported {
        triangles: input.scene.triangle_count(),
        receivers: reflecting.len(),
        standard_error: state.overall_standard_error(),
    })
}

/// Returns the material. If it shows the environment, it becomes that of a lit surface that does not reflect.
fn without_sky(material: &Material) -> Material {
    let mut material = material.clone();
    if material.surface == Surface::Sky {
        (material.surface, material.reflectivity) = (Surface::Lit, 0.0);
    }
    material
}

/// The file of the mesh with an index.
fn mesh_file(index: usize) -> String {
    format!("meshes/{index:04}.ply")
}

/// The file of the texture with an index.
fn texture_file(index: usize) -> String {
    format!("textures/{index:03}.png")
}

/// Returns the scene as Mitsuba 3 reads it, seen in perspective. Materials are diffuse and the light is a constant
/// environment, so that Mitsuba can render the scene; the comparison only intersects rays and reads the albedo.
fn scene_xml(input: &Export, fov_y_radians: f32, materials: &[Material]) -> String {
    let mirrored_x = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let to_world = input.camera.world_to_view.as_dmat4().inverse() * mirrored_x;
    let matrix: Vec<String> = to_world.transpose().to_cols_array().iter().map(f64::to_string).collect();
    let lens = input.camera.lens;
    let mut xml =
        String::from("<scene version=\"3.0.0\">\n  <integrator type=\"path\"/>\n  <emitter type=\"constant\"/>\n");
    // Writing to a String cannot fail.
    let _ = writeln!(
        xml,
        "  <sensor type=\"perspective\">\n    <transform name=\"to_world\"><matrix value=\"{}\"/></transform>\n    \
         <string name=\"fov_axis\" value=\"y\"/>\n    <float name=\"fov\" value=\"{}\"/>\n    \
         <float name=\"near_clip\" value=\"{}\"/>\n    <float name=\"far_clip\" value=\"{}\"/>\n    \
         <film type=\"hdrfilm\">\n      <integer name=\"width\" value=\"{}\"/>\n      \
         <integer name=\"height\" value=\"{}\"/>\n    </film>\n  </sensor>",
        matrix.join(" "),
        f64::from(fov_y_radians).to_degrees(),
        lens.near_m,
        lens.far_m,
        input.extent[0],
        input.extent[1],
    );
    for (i, material) in materials.iter().enumerate() {
        let albedo = match material.albedo_map {
            Some(map) => format!(
                "<texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"{}\"/></texture>",
                texture_file(map)
            ),
            None => "<rgb name=\"reflectance\" value=\"1, 1, 1\"/>".to_owned(),
        };
        let _ = writeln!(
            xml,
            "  <bsdf type=\"twosided\" id=\"material-{i}\"><bsdf type=\"diffuse\">{albedo}</bsdf></bsdf>"
        );
    }
    for (i, mesh) in input.scene.meshes.iter().enumerate().filter(|(_, m)| !m.indices.is_empty()) {
        let _ = writeln!(
            xml,
            "  <shape type=\"ply\" id=\"mesh-{i}\"><string name=\"filename\" value=\"{}\"/><ref id=\"material-{}\"/></shape>",
            mesh_file(i),
            mesh.material
        );
    }
    xml + "</scene>\n"
}

/// Returns a mesh as binary PLY: position, normal and texture coordinates of its vertices, and its triangles.
fn encode_ply(mesh: &Mesh) -> Vec<u8> {
    let triangles = mesh.indices.as_chunks::<3>().0;
    let properties: String =
        ["x", "y", "z", "nx", "ny", "nz", "u", "v"].map(|p| format!("property float {p}\n")).concat();
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n{properties}element face {}\n\
         property list uchar int vertex_index\nend_header\n",
        mesh.vertices.len(),
        triangles.len()
    )
    .into_bytes();
    for v in &mesh.vertices {
        bytes.extend(v.position.iter().chain(&v.normal).chain(&v.uv).flat_map(|c| c.to_le_bytes()));
    }
    for triangle in triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|i| i.to_le_bytes()));
    }
    bytes
}

/// Returns the content of `truth.json`: settings, lights, materials and textures.
fn truth_json(input: &Export, materials: &[Material]) -> Value {
    let light = |l: &Light| match *l {
        Light::Point { position, energy } => json!({"kind": "point", "at": position.to_array(), "energy": energy}),
        Light::Directional { direction, energy } => {
            json!({"kind": "directional", "along": direction.to_array(), "energy": energy})
        }
    };
    let material = |m: &Material| {
        json!({
            "name": m.name, "albedo": m.albedo.to_array(), "albedo_map": m.albedo_map, "normal_map": m.normal_map,
            "alpha_mask": m.alpha_mask, "normal_deviation": m.normal_deviation, "emission": m.emission,
            "single_sided": m.single_sided,
        })
    };
    let texture = |i: usize| {
        let srgb = input.scene.textures[i].encoding == Encoding::Srgb;
        json!({"file": texture_file(i), "srgb": srgb})
    };
    json!({
        "kind": "truth", "scene": input.scene.name,
        "width": input.extent[0], "height": input.extent[1],
        "ray_start_m": RAY_START_M, "samples": input.samples, "seed": input.seed,
        "lights": input.scene.lights.iter().map(light).collect::<Vec<_>>(),
        "materials": materials.iter().map(material).collect::<Vec<_>>(),
        "mesh_material": input.scene.meshes.iter().map(|m| m.material).collect::<Vec<_>>(),
        "textures": (0..input.scene.textures.len()).map(texture).collect::<Vec<_>>(),
    })
}

/// Writes arrays of numbers, each to a file of its own in this folder.
struct Arrays<'a>(&'a PathInFolder);

impl Arrays<'_> {
    /// Writes what the ray through the centre of each pixel hits: the ray's direction, the end of the ray
    /// ([`Arrays::write_ends`]), and the lit colour.
    fn write_primary(&self, world: &World, input: &Export, first_hits: &FirstHits) -> Result<()> {
        let rays = PrimaryRays::new(&input.camera, input.extent);
        let rays: Vec<WorldRay> = (0..first_hits.lit.len()).map(|i| rays.ray(i).0).collect();
        self.write_f64s("primary_direction", 3, rays.iter().flat_map(|r| r.direction.to_array()).collect())?;
        self.write_ends("primary", world, &rays)?;
        let lit = first_hits.lit.iter().flat_map(|c: &Vec3| c.as_dvec3().to_array());
        self.write_f64s("primary_lit", 3, lit.collect())
    }

    /// Writes the reflecting points in the order of their pixels, and the ends of their mirror rays.
    fn write_receivers(&self, world: &World, first_hits: &FirstHits) -> Result<()> {
        let points: Vec<_> = first_hits.receivers.iter().flatten().collect();
        // The numbers of the vectors that a function returns for the index of each point.
        let numbers = |vector: &dyn Fn(usize) -> DVec3| (0..points.len()).flat_map(|i| vector(i).to_array()).collect();
        self.write_f64s("receiver_position", 3, numbers(&|i| points[i].position))?;
        self.write_f64s("receiver_normal", 3, numbers(&|i| points[i].normal))?;
        self.write_f64s("receiver_geometric", 3, numbers(&|i| points[i].geometric_normal))?;
        self.write_f64s("receiver_incoming", 3, numbers(&|i| points[i].incoming))?;
        self.write_f64s("receiver_roughness", 1, points.iter().map(|point| point.roughness).collect())?;
        let rays: Vec<WorldRay> = points
            .iter()
            .map(|r| WorldRay { origin: r.position, direction: r.mirror(), t_min: RAY_START_M, t_max: f64::INFINITY })
            .collect();
        self.write_ends("mirror", world, &rays)
    }

    /// Writes the ends of rays under names that begin with `name`: mesh and triangle (−1 for none), and position (NaN
    /// for none).
    fn write_ends(&self, name: &str, world: &World, rays: &[WorldRay]) -> Result<()> {
        let hits: Vec<Option<TriangleHit>> = rays.par_iter().map(|ray| world.closest(ray)).collect();
        let triangles: Vec<_> = hits.iter().map(|h| h.as_ref().map(|h| world.triangle(h))).collect();
        self.write_i32s(&format!("{name}_mesh"), triangles.iter().map(|t| t.map_or(-1, |t| t.mesh as i32)).collect())?;
        self.write_i32s(
            &format!("{name}_triangle"),
            triangles.iter().map(|t| t.map_or(-1, |t| t.triangle as i32)).collect(),
        )?;
        let ends = hits.iter().zip(rays).flat_map(|(h, ray)| h.map_or(DVec3::NAN, |h| ray.point_at(h.t)).to_array());
        self.write_f64s(&format!("{name}_position"), 3, ends.collect())
    }

    /// Writes the tangents of all meshes' vertices, mesh after mesh, and the index of the first vertex of each mesh.
    fn write_tangents(&self, meshes: &[Mesh]) -> Result<()> {
        let tangents = meshes.iter().flat_map(|mesh| &mesh.vertices).flat_map(|vertex| vertex.tangent.map(f64::from));
        self.write_f64s("vertex_tangent", 4, tangents.collect())?;
        let first_vertices = meshes.iter().scan(0, |vertex_count, mesh| {
            let first = *vertex_count;
            *vertex_count += mesh.vertices.len() as i32;
            Some(first)
        });
        self.write_i32s("mesh_first_vertex", first_vertices.collect())
    }

    /// Writes an array with rows of `columns` numbers.
    fn write_f64s(&self, name: &str, columns: usize, values: Vec<f64>) -> Result<()> {
        let shape = if columns == 1 {
            format!("({},)", values.len())
        } else {
            format!("({}, {columns})", values.len() / columns)
        };
        self.write_array(name, "<f8", &shape, values.iter().flat_map(|v| v.to_le_bytes()))
    }

    /// Writes an array of whole numbers.
    fn write_i32s(&self, name: &str, values: Vec<i32>) -> Result<()> {
        self.write_array(name, "<i4", &format!("({},)", values.len()), values.iter().flat_map(|v| v.to_le_bytes()))
    }

    /// Writes a file of NumPy's format 1.0: magic, version, length of the header, the header, the numbers. `kind` and
    /// `shape` are as NumPy writes them, such as `<f8` and `(96, 3)`, and `content` has the bytes of the numbers.
    fn write_array(&self, name: &str, kind: &str, shape: &str, content: impl Iterator<Item = u8>) -> Result<()> {
        let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
        // The header is padded so that the numbers begin at a multiple of 64 bytes.
        let padding = 63 - (10 + header.len()) % 64;
        header.extend(std::iter::repeat_n(' ', padding));
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.into_bytes());
        bytes.extend(content);
        self.0.join(format!("{name}.npy")).write(&bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct_scenes::library;

    #[test]
    fn an_export_is_complete_and_its_arrays_begin_as_numpy_wants() {
        let scene = library::scene("rooms").expect("a built-in scene");
        let view = &scene.views[0];
        let camera = Camera::new(view.eye, view.look_at, scene.lens, 1.5);
        let folder = tempfile::tempdir().expect("a folder");
        let what = Export { scene: &scene, materials: &scene.materials, camera, extent: [12, 8], samples: 2, seed: 1 };
        let exported = export(&PathInFolder::folder(folder.path()), &what).expect("an export");
        assert_eq!(exported.triangles, scene.triangle_count());
        let read = |name: &str| std::fs::read(folder.path().join(name)).expect(name);

        let primary = read("primary_position.npy");
        assert!(primary.starts_with(b"\x93NUMPY\x01\x00"));
        let header = 10 + usize::from(u16::from_le_bytes([primary[8], primary[9]]));
        assert_eq!((header % 64, primary.len() - header), (0, 12 * 8 * 3 * 8));
        assert!(String::from_utf8_lossy(&primary[10..header]).contains("'shape': (96, 3)"));
        assert_eq!(read("receiver_pixel.npy").len() - 128, 4 * exported.receivers);

        let xml = String::from_utf8(read("scene.xml")).expect("text");
        assert_eq!(xml.matches("<shape").count(), scene.meshes.len());
        let mesh = &scene.meshes[0];
        let ply = read("meshes/0000.ply");
        let content = 32 * mesh.vertices.len() + 13 * mesh.indices.len() / 3;
        assert!(ply[..ply.len() - content].ends_with(b"end_header\n"));
        let truth: Value = serde_json::from_slice(&read("truth.json")).expect("JSON");
        assert_eq!(truth["textures"].as_array().map(Vec::len), Some(scene.textures.len()));
        assert!(scene.textures.iter().enumerate().all(|(i, _)| folder.path().join(texture_file(i)).exists()));
    }
}
