//! Tests glTF files: geometry, materials, images, cameras and lights, sentences for lost features, and damaged files.

use super::*;
use base64::{Engine, prelude::BASE64_STANDARD};
use glam::Quat;
use proptest::prelude::*;
use serde_json::{Value, json};
use ssct_ground::Result;
use ssct_scenes::{Lens, Light, Material, Texture, gltf, material_terms::roughness_of_perceptual};

/// A square in the xy plane from (0, 0) to (2, 1), seen from +z, with (0, 0) of its texture at the upper left.
pub struct Square {
    /// The buffer.
    pub bytes: Vec<u8>,
    /// The views of the buffer, one for each accessor.
    pub views: Vec<Value>,
    pub accessors: Vec<Value>,
}

impl Square {
    /// Makes the four accessors 0 to 3: positions, normals, texture coordinates, indices.
    pub fn new() -> Self {
        let mut square = Self { bytes: Vec::new(), views: Vec::new(), accessors: Vec::new() };
        let position = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        square.floats("VEC3", &position.concat());
        square.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
        square.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        let indices: Vec<u8> = [0_u16, 1, 2, 0, 2, 3].into_iter().flat_map(u16::to_le_bytes).collect();
        square.accessor("SCALAR", 5123, 6, &indices);
        square
    }

    /// Adds an accessor of 32-bit floats, whose type `kind` is that of glTF.
    pub fn floats(&mut self, kind: &str, values: &[f32]) {
        let sizes = [("SCALAR", 1), ("VEC2", 2), ("VEC3", 3), ("VEC4", 4), ("MAT4", 16)];
        let (_, size) = sizes.iter().find(|(name, _)| *name == kind).unwrap();
        let count = values.len() / *size;
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(kind, 5126, count, &bytes);
    }

    /// Adds an accessor with its view: the type, the component type and the number of its elements, and its bytes. The
    /// component type is a number of glTF: 5120 and 5121 are bytes, 5122 and 5123 are 16 bits, 5126 is a float.
    pub fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) {
        self.accessors.push(json!({
            "bufferView": self.views.len(), "componentType": component, "count": count, "type": kind,
            "min": [0, 0, 0], "max": [2, 1, 0],
        }));
        self.views.push(json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()}));
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
    }

    /// Returns the document that draws the square with one material, which is smooth unless it says otherwise.
    pub fn document(&self, mut material: Value) -> Value {
        let pbr = &mut material["pbrMetallicRoughness"];
        pbr["roughnessFactor"] = pbr.get("roughnessFactor").cloned().unwrap_or(0.into());
        let data = BASE64_STANDARD.encode(&self.bytes);
        json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "name": "square"}],
            "meshes": [{"primitives": [{
                "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0,
            }]}],
            "materials": [material],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": self.bytes.len(), "uri": format!("data:application/octet-stream;base64,{data}")}],
        })
    }
}

/// Returns the square's document with a material, after a change.
pub fn square(material: Value, change: impl FnOnce(&mut Value)) -> Value {
    let mut document = Square::new().document(material);
    change(&mut document);
    document
}

/// Loads a document from a file of its own, a.gltf.
pub fn load(document: &Value) -> Result<Scene> {
    let folder = Folder::new(&[("a.gltf", &document.to_string())]);
    gltf::load(&folder.path("a.gltf"), &LoadOptions::default())
}

/// Loads a document, and checks that the scene is sound.
pub fn scene(document: &Value) -> Scene {
    let scene = load(document).unwrap();
    assert_sound(&scene);
    scene
}

/// Returns the warnings about a scene, without the name of the file.
pub fn sentences(scene: &Scene) -> Vec<&str> {
    scene.warnings.iter().map(|w| w.split_once("a.gltf: ").expect("the file's name").1).collect()
}

/// Returns the error of loading a document, without the name of the file.
pub fn error(document: &Value) -> String {
    load(document).unwrap_err().to_string().split_once("a.gltf: ").expect("the file's name").1.to_owned()
}

/// Returns a picture as an image of a document.
pub fn picture(width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Value {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = image::RgbaImage::from_fn(width, height, |x, y| image::Rgba(texel(x, y)));
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    json!({"uri": format!("data:image/png;base64,{}", BASE64_STANDARD.encode(bytes.into_inner()))})
}

/// Returns the square's document with a material and with images. Texture n of the document shows image n.
pub fn pictured(material: Value, images: &[Value]) -> Value {
    square(material, |document| {
        document["images"] = images.into();
        document["textures"] = (0..images.len()).map(|i| json!({"source": i})).collect();
    })
}

/// Returns the material that the scene of the square has for a material of glTF.
fn material(material: Value) -> Material {
    scene(&square(material, |_| ())).materials[0].clone()
}

/// Returns the RGBA bytes of a scene's texture in column `x` and row `y`. `map` is the index of the texture.
fn texel(scene: &Scene, map: Option<usize>, x: u32, y: u32) -> [u8; 4] {
    let Texture { width, rgba, .. } = &scene.textures[map.expect("a map")];
    std::array::from_fn(|channel| rgba[4 * (y * width + x) as usize + channel])
}

/// Returns whether two numbers differ by less than 1e-5.
pub fn close(a: f32, b: f32) -> bool {
    (a - b).abs() < 1e-5
}

/// A square seen from +z of its file is seen from −z of the scene, with its texture upright: both were right-handed.
#[test]
fn a_right_handed_square_faces_the_same_side() {
    let scene = scene(&square(json!({}), |_| ()));
    assert_eq!((scene.name.as_str(), scene.triangle_count(), scene.meshes.len()), ("a", 2, 1));
    assert_eq!(scene.meshes[0].name, "square");
    assert!(close(area(&scene), 2.0));
    for v in &scene.meshes[0].vertices {
        assert_eq!(normal(v), Vec3::NEG_Z);
        let [u, down] = v.uv;
        assert_eq!(position(v), Vec3::new(2.0 * u, 1.0 - down, 0.0));
        // u grows along +x, and the bitangent w · n × t runs up.
        let tangent = Vec3::from_slice(&v.tangent[..3]);
        assert_eq!(tangent, Vec3::X);
        assert_eq!(v.tangent[3] * normal(v).cross(tangent), Vec3::Y);
    }
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

/// Nodes turn, scale and mirror their meshes. A mirrored triangle has its corners in the other order.
#[test]
fn nodes_place_their_meshes_and_mirrored_ones_keep_their_front() {
    let turned = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2).to_array();
    let nodes = json!([
        {"children": [1, 2], "translation": [10, 0, 0], "scale": [2, 2, 2]},
        {"mesh": 0, "rotation": turned, "name": "turned"},
        {"mesh": 0, "matrix": [-1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 3, 1], "name": "mirrored"},
    ]);
    let scene = scene(&square(json!({}), |d| d["nodes"] = nodes));
    let mesh = |name: &str| scene.meshes.iter().find(|m| m.name == name).expect(name);
    // A quarter turn about y takes +x to −z and +z to +x; then z is negated.
    let turned_mesh = mesh("turned");
    assert!(turned_mesh.bounds.min.distance(Vec3::new(10.0, 0.0, 0.0)) < 1e-5, "{:?}", turned_mesh.bounds);
    assert!(turned_mesh.bounds.max.distance(Vec3::new(10.0, 2.0, 4.0)) < 1e-5, "{:?}", turned_mesh.bounds);
    assert!(turned_mesh.vertices.iter().all(|v| normal(v).distance(Vec3::X) < 1e-5));
    let mirrored = mesh("mirrored");
    assert_eq!((mirrored.bounds.min, mirrored.bounds.max), (Vec3::new(6.0, 0.0, -6.0), Vec3::new(10.0, 2.0, -6.0)));
    assert!(mirrored.vertices.iter().all(|v| normal(v) == Vec3::NEG_Z && v.tangent == [-1.0, 0.0, 0.0, 1.0]));
}

/// Tangents in the file and tangents made of texture coordinates are equal, also in a mirrored node.
#[test]
fn tangents_of_the_file_are_those_that_would_be_made() {
    for scale in [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]] {
        let placed = |d: &mut Value| d["nodes"][0]["scale"] = scale.into();
        let mut with_tangents = Square::new();
        with_tangents.floats("VEC4", &[1.0, 0.0, 0.0, 1.0].repeat(4));
        let mut document = with_tangents.document(json!({}));
        document["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = 4.into();
        placed(&mut document);
        let tangents = |scene: Scene| scene.meshes[0].vertices.iter().map(|v| v.tangent).collect::<Vec<_>>();
        let computed = tangents(scene(&square(json!({}), placed)));
        assert_eq!(tangents(scene(&document)), computed, "{scale:?}");
    }
}

/// Strips, fans, bytes as indices or positions, and primitives without indices or normals give the square.
#[test]
fn strips_fans_bytes_and_missing_indices_and_normals_are_read() {
    let primitive =
        |change: fn(&mut Value)| scene(&square(json!({}), |d| change(&mut d["meshes"][0]["primitives"][0])));
    let flat = primitive(|p| {
        p["attributes"].as_object_mut().unwrap().remove("NORMAL");
    });
    assert!(flat.meshes[0].vertices.iter().all(|v| normal(v) == Vec3::NEG_Z));
    let fan = primitive(|p| {
        p.as_object_mut().unwrap().remove("indices");
        p["mode"] = 6.into();
    });
    assert!(close(area(&fan), 2.0));
    let mut square = Square::new();
    square.accessor("SCALAR", 5121, 4, &[0, 1, 3, 2]);
    // Positions as normalised bytes: what KHR_mesh_quantization allows.
    square.accessor("VEC3", 5121, 4, &[0, 0, 0, 255, 0, 0, 255, 255, 0, 0, 255, 0]);
    let mut document = square.document(json!({}));
    document["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    document["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    document["accessors"][5]["normalized"] = true.into();
    let primitive = &mut document["meshes"][0]["primitives"][0];
    primitive["mode"] = 5.into();
    primitive["indices"] = 4.into();
    primitive["attributes"]["POSITION"] = 5.into();
    let strip = scene(&document);
    assert_eq!((area(&strip), strip.triangle_count()), (1.0, 2));
}

/// Base colour, metalness, roughness, index of refraction and the unlit material become the program's own terms.
#[test]
fn metallic_roughness_becomes_albedo_reflectivity_and_the_lobe() {
    let metal = material(json!({"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0, 1], "roughnessFactor": 0.25}}));
    assert_eq!(metal.albedo, Vec3::ZERO);
    assert!(close(metal.reflectivity, 0.2126 + 0.5 * 0.7152), "{}", metal.reflectivity);
    assert_eq!(metal.roughness, roughness_of_perceptual(0.25));
    let plastic = json!({"baseColorFactor": [1, 0.5, 0, 1], "metallicFactor": 0, "roughnessFactor": 0});
    let plastic = |extensions: Value| material(json!({"pbrMetallicRoughness": plastic, "extensions": extensions}));
    let usual = plastic(json!({}));
    assert_eq!((usual.albedo, usual.roughness, usual.emission), (Vec3::new(1.0, 0.5, 0.0), 0.0, 0.0));
    assert!(close(usual.reflectivity, 0.04));
    assert!(close(plastic(json!({"KHR_materials_ior": {"ior": 3}})).reflectivity, 0.25));
    // The index 0 stands for a surface that reflects everything.
    assert!(close(plastic(json!({"KHR_materials_ior": {"ior": 0}})).reflectivity, 1.0));
    let unlit = plastic(json!({"KHR_materials_unlit": {}}));
    assert_eq!((unlit.emission, unlit.reflectivity, unlit.albedo), (1.0, 0.0, Vec3::new(1.0, 0.5, 0.0)));
}

/// Emission, by a factor or an image, is added to the albedo, and its share is kept, since a texel has one colour.
#[test]
fn emission_adds_to_the_albedo_and_is_its_share() {
    let base = json!({"baseColorFactor": [0.25, 0.25, 0.25, 1], "metallicFactor": 0, "roughnessFactor": 0});
    let lamp = material(json!({"pbrMetallicRoughness": base, "emissiveFactor": [0.25, 0.25, 0.25],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 2}}}));
    assert!(lamp.albedo.abs_diff_eq(Vec3::splat(0.75), 1e-6) && close(lamp.emission, 2.0 / 3.0), "{lamp:?}");
    let image = picture(2, 1, |x, _| [if x == 0 { 255 } else { 0 }; 4]);
    let half = json!({"pbrMetallicRoughness": base, "emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}});
    let scene = scene(&pictured(half, &[image]));
    let map = scene.materials[0].albedo_map;
    assert_eq!((scene.materials[0].albedo, scene.materials[0].emission), (Vec3::ONE, 1.0));
    // The left texel emits 1 over an albedo of ¼, which is clamped; the right one is lit alone. 137 is the sRGB of ¼.
    assert_eq!(texel(&scene, map, 0, 0), [255, 255, 255, 204]);
    assert_eq!(texel(&scene, map, 1, 0), [137, 137, 137, 0]);
}

/// Images of two sizes become the program's maps texel by texel: smooth metal on the left, rough plastic right.
#[test]
fn images_are_baked_texel_by_texel() {
    let rough = picture(2, 1, |x, _| if x == 0 { [7, 51, 255, 255] } else { [7, 102, 0, 255] });
    let base = picture(2, 2, |_, _| [255, 255, 255, 255]);
    let textured = json!({"pbrMetallicRoughness": {
        "baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 1}, "roughnessFactor": 0.5,
    }});
    let scene = scene(&pictured(textured, &[base, rough]));
    let Material { albedo_map, reflectivity_map, roughness_map, .. } = scene.materials[0];
    assert_eq!((texel(&scene, albedo_map, 0, 0), texel(&scene, albedo_map, 1, 1)), ([0, 0, 0, 0], [255, 255, 255, 0]));
    assert_eq!((texel(&scene, reflectivity_map, 0, 1)[0], texel(&scene, reflectivity_map, 1, 0)[0]), (255, 10));
    let stored = |r: f32| (roughness_of_perceptual(r) * 255.0).round() as u8;
    assert_eq!(
        (texel(&scene, roughness_map, 0, 0)[1], texel(&scene, roughness_map, 1, 0)[1]),
        (stored(0.1), stored(0.2))
    );
    assert_eq!((scene.materials[0].roughness, scene.materials[0].reflectivity), (1.0, 1.0));
}

/// A mask has holes below its cutoff, blending becomes a mask with a warning, and opaque materials have none.
#[test]
fn masks_cut_at_their_cutoff_and_sides_are_kept() {
    let leaf = |mode: &str, cutoff: f32| {
        let image = picture(2, 1, |x, _| [255, 255, 255, if x == 0 { 100 } else { 60 }]);
        let pbr = json!({"baseColorTexture": {"index": 0}, "metallicFactor": 0});
        let mut leaf = json!({"pbrMetallicRoughness": pbr, "alphaMode": mode, "doubleSided": true});
        if mode == "MASK" {
            leaf["alphaCutoff"] = cutoff.into();
        }
        scene(&pictured(leaf, &[image]))
    };
    let holes = |scene: &Scene| [0, 1].map(|x| texel(scene, scene.materials[0].alpha_mask, x, 0)[0] < 128);
    assert_eq!(holes(&leaf("MASK", 0.3)), [false, true]);
    assert_eq!(holes(&leaf("MASK", 0.2)), [false, false]);
    // No alpha is below 0, so that there are no holes.
    assert!([0.0, -1.0].iter().all(|cutoff| leaf("MASK", *cutoff).materials[0].alpha_mask.is_none()));
    let blended = leaf("BLEND", 0.0);
    assert_eq!(holes(&blended), [true, true]);
    assert!(sentences(&blended)[0].starts_with("transparency is not supported"), "{:?}", blended.warnings);
    let opaque = leaf("OPAQUE", 0.0);
    assert!(opaque.materials[0].alpha_mask.is_none() && !opaque.materials[0].single_sided);
    assert!(material(json!({})).single_sided);
}

/// Cameras become views, and the energies of all lights are scaled so that the brightest one, in lux, becomes 1.
#[test]
fn cameras_become_views_and_lights_share_one_exposure() {
    let document = square(json!({}), |d| {
        d["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        d["cameras"] = json!([
            {"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.2, "zfar": 50}, "name": "front"},
            {"type": "orthographic", "orthographic": {"xmag": 4, "ymag": 2.5, "znear": 0, "zfar": 9}},
        ]);
        d["extensions"] = json!({"KHR_lights_punctual": {"lights": [
            {"type": "directional", "intensity": 8}, {"type": "point", "intensity": 64},
            {"type": "spot", "intensity": 1, "color": [1, 0, 0], "spot": {}},
        ]}});
        d["scenes"][0]["nodes"] = json!([0, 1, 2, 3, 4, 5, 6]);
        let lamp =
            |n: u32, z: f32| json!({"translation": [1, 0.5, z], "extensions": {"KHR_lights_punctual": {"light": n}}});
        let camera = json!({"camera": 0, "translation": [1, 0.5, 4]});
        d["nodes"] = json!([{"mesh": 0}, camera, camera, {"camera": 1}, lamp(0, 0.0), lamp(1, 4.0), lamp(2, 2.0)]);
    });
    let scene = scene(&document);
    let names: Vec<&str> = scene.views.iter().map(|v| v.name.as_str()).collect();
    assert_eq!(names, ["front", "front 2", "camera"]);
    let front = &scene.views[0];
    assert_eq!((front.eye, front.look_at), (Vec3::new(1.0, 0.5, -4.0), Vec3::new(1.0, 0.5, 0.0)));
    assert_eq!(front.lens.unwrap(), Lens::perspective(0.8, 0.2, 50.0));
    // ymag is half the height.
    assert_eq!(scene.views[2].lens, Some(Lens::orthographic(5.0, 0.0, 9.0)));
    // 8 lux from the sun, 64 / 4² = 4 from the point light, 0.2126 / 2² from the spot light.
    let [sun, point, spot] = scene.lights[..] else { panic!("{:?}", scene.lights) };
    assert_eq!(sun, Light::Directional { direction: Vec3::Z, energy: 1.0 });
    assert_eq!(point, Light::Point { position: Vec3::new(1.0, 0.5, -4.0), energy: 8.0 });
    assert!(matches!(spot, Light::Point { energy, .. } if close(energy, 0.2126 / 8.0)));
    let about: Vec<_> = sentences(&scene).iter().map(|s| s.split(' ').next().unwrap().to_owned()).collect();
    assert_eq!(about, ["coloured", "spot"], "{:?}", scene.warnings);
}

/// Each unsupported thing gets one sentence, however often it occurs, so that warnings stay few.
#[test]
fn what_is_not_supported_is_said_once() {
    let document = square(json!({"extensions": {"KHR_materials_clearcoat": {}}}), |d| {
        d["extensionsUsed"] = json!(["KHR_materials_clearcoat", "KHR_draco_mesh_compression"]);
        let mut second = d["meshes"][0]["primitives"][0].clone();
        second["targets"] = json!([{"POSITION": 0}]);
        let mut points = second.clone();
        points["mode"] = 0.into();
        d["meshes"][0]["primitives"] = json!([second, second, points, points]);
        d["textures"] = json!([{"extensions": {"KHR_texture_basisu": {"source": 0}}}]);
        d["materials"][0]["emissiveTexture"] = json!({"index": 0});
    });
    let scene = scene(&document);
    let expected = [
        "the extension KHR_materials_clearcoat is not supported and was ignored",
        "meshes are drawn from their uncompressed copies, since the extension KHR_draco_mesh_compression is not supported",
        "points and lines are not drawn",
        "images that are given neither as PNG nor as JPEG or WebP are not supported and were left out; export the images as \
         PNG, JPEG or WebP instead of KTX2",
    ];
    for sentence in expected {
        let times = sentences(&scene).iter().filter(|s| **s == sentence).count();
        assert_eq!(times, 1, "{sentence}: {:?}", scene.warnings);
    }
    assert_eq!(scene.triangle_count(), 4);
}

/// Each mistake in a document, a buffer or a binary header is refused with a sentence of its own.
#[test]
fn bad_files_get_a_sentence() {
    let bad = |change: fn(&mut Value)| error(&square(json!({}), change));
    let required = bad(|d| d["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]));
    let wanted = "requires the extension KHR_draco_mesh_compression, which is not supported; `npx @gltf-transform/cli copy IN.glb \
                  OUT.glb` writes the meshes without it";
    assert_eq!(required, wanted);
    assert_eq!(bad(|d| d["asset"]["version"] = "1.0".into()), "is glTF 1.0; version 2 is supported");
    assert_eq!(bad(|d| d["bufferViews"][0]["byteLength"] = 1000.into()), "buffer view 0 leaves its buffer");
    assert_eq!(bad(|d| d["accessors"][0]["count"] = 5.into()), "accessor 0 leaves its buffer view");
    assert_eq!(bad(|d| d["accessors"][0]["count"] = u64::MAX.into()), "accessor 0 leaves its buffer view");
    let few = bad(|d| d["accessors"][1]["count"] = 3.into());
    assert_eq!(few, "accessor 1 of NORMAL has 3 elements for 4 vertices");
    assert_eq!(bad(|d| d["accessors"][2]["type"] = "VEC3".into()), "accessor 2 of TEXCOORD_0 must have 2 components");
    assert_eq!(
        bad(|d| d["accessors"][3]["componentType"] = 5126.into()),
        "accessor 3 of indices must have unsigned integers"
    );
    assert_eq!(
        bad(|d| d["buffers"][0]["byteLength"] = 4000.into()),
        "buffer 0 has 140 bytes where the document states 4000"
    );
    assert_eq!(bad(|d| d["buffers"][0]["uri"] = "data:;base64,?".into()), "buffer 0 is not valid base64");
    assert_eq!(bad(|d| d["nodes"][0]["scale"] = json!([0, 0, 0])), "has no triangle with an area in its scene");
    let far = bad(|d| d["nodes"][0]["translation"] = json!([1e9, 0, 0]));
    assert_eq!(far, "mesh square: a vertex lies more than 1e8 m from the origin");
    assert_eq!(bad(|d| d["nodes"][0]["children"] = json!([0])), "node 0 has more than one parent, or is its own");
    let sparse = bad(|d| {
        let indices = json!({"bufferView": 3, "componentType": 5123});
        d["accessors"][0]["sparse"] = json!({"count": 9, "indices": indices, "values": {"bufferView": 0}});
    });
    assert_eq!(sparse, "accessor 0: its sparse elements leave their buffer view");
    let no_positions = bad(|d| d["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 9.into());
    assert_eq!(no_positions, "is not glTF 2.0: positions are in an accessor that is not there");
    assert!(bad(|d| d["nodes"][0]["mesh"] = 9.into()).starts_with("is not glTF 2.0: "));
    let no_file = load(&square(json!({}), |d| d["buffers"][0]["uri"] = "b.bin".into())).unwrap_err().to_string();
    assert!(no_file.contains("b.bin"), "{no_file}");
    let folder = Folder::new(&[("a.gltf", "{")]);
    folder.write("a.glb", &[&b"glTF"[..], &2_u32.to_le_bytes(), &3_u32.to_le_bytes(), &[0; 8]].concat());
    let short = gltf::load(&folder.path("a.glb"), &LoadOptions::default()).unwrap_err().to_string();
    assert!(short.ends_with("it states a length of 3 bytes, which its header alone exceeds"), "{short}");
    assert!(gltf::load(&folder.path("a.gltf"), &LoadOptions::default()).is_err());
    assert!(gltf::load(&folder.path("a.gltf"), &scaled(0.0)).is_err());
}

/// A missing image leaves the material's factor, and an image above the limit is filtered to a smaller size.
#[test]
fn missing_images_leave_the_factor_and_large_ones_become_smaller() {
    let pbr = json!({"baseColorTexture": {"index": 0}, "baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0});
    let material = json!({"pbrMetallicRoughness": pbr});
    let there = pictured(material.clone(), &[picture(8, 4, |x, _| if x < 4 { [0, 0, 0, 255] } else { [255; 4] })]);
    let missing = scene(&pictured(material, &[json!({"uri": "no%20image.png"})]));
    assert_eq!(sentences(&missing), ["image no image.png is missing; the material's factor takes its place"]);
    assert_eq!(texel(&missing, missing.materials[0].albedo_map, 0, 0), [255; 4]);
    let folder = Folder::new(&[("a.gltf", &there.to_string())]);
    let small = LoadOptions { texture_side: 2, ..LoadOptions::default() };
    let scene = gltf::load(&folder.path("a.gltf"), &small).unwrap();
    let texture = &scene.textures[0];
    assert_eq!((texture.width, texture.height), (2, 1));
    // The left texel covers four: a triangle filter gives 1 / 7 to the white beyond, and 106 is the sRGB of that.
    assert_eq!([texture.rgba[0], texture.rgba[4]], [106, 255 - 17]);
}

/// Returns a document and its buffer as a binary file.
pub fn binary(mut document: Value, bytes: &[u8]) -> Vec<u8> {
    document["buffers"] = json!([{"byteLength": bytes.len()}]);
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let chunk = |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes(), kind.as_slice(), bytes].concat();
    let chunks = [chunk(b"JSON", &text), chunk(b"BIN\0", bytes)].concat();
    let length = (12 + chunks.len()) as u32;
    [b"glTF".as_slice(), &2_u32.to_le_bytes(), &length.to_le_bytes(), &chunks].concat()
}

/// A binary file gives the scene of the text, and a scene file may place it beside an OBJ file and change its material.
#[test]
fn a_binary_file_is_the_same_scene_also_in_a_scene_file() {
    let plastic = json!({"pbrMetallicRoughness": {"metallicFactor": 0}, "name": "plastic"});
    let text = scene(&square(plastic.clone(), |_| ()));
    let folder = Folder::new(&[("a.obj", &format!("{SQUARE}f 1/1 2/2 3/3\n"))]);
    folder.write("b.glb", &binary(Square::new().document(plastic), &Square::new().bytes));
    let loaded = gltf::load(&folder.path("b.glb"), &LoadOptions::default()).unwrap();
    assert_eq!(loaded.meshes[0].vertices, text.meshes[0].vertices);
    assert_eq!(loaded.materials, text.materials);
    let file = "[[mesh]]\nfile = \"b.glb\"\n[[mesh]]\nfile = \"a.obj\"\n[material.plastic]\nroughness = 0.5\n";
    folder.write("c.scene.toml", file.as_bytes());
    let joined = ssct_scenes::scene_file::load(&folder.path("c.scene.toml"), &scaled(2.0)).unwrap();
    assert_sound(&joined);
    assert_eq!(joined.triangle_count(), 3);
    let gltf_mesh = joined.meshes.iter().find(|m| joined.materials[m.material].name == "plastic").expect("the square");
    assert_eq!((gltf_mesh.bounds.max, joined.materials[gltf_mesh.material].roughness), (Vec3::new(4.0, 2.0, 0.0), 0.5));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    /// A document and a binary file with random mutations are loaded soundly or refused, and never cause a panic.
    #[test]
    fn damaged_files_never_panic(text in super::mutations::mutations(), bytes in super::mutations::mutations()) {
        let image = picture(2, 2, |x, y| [x as u8 * 90, y as u8 * 90, 255, 255]);
        let pbr = json!({"baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}},
            "metallicRoughnessTexture": {"index": 0}});
        let material = json!({"pbrMetallicRoughness": pbr, "normalTexture": {"index": 0}, "alphaMode": "MASK",
            "emissiveFactor": [1, 0, 0]});
        let mut document = pictured(material, &[image]);
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 64}]}});
        document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.2}}]);
        document["nodes"][0]["camera"] = 0.into();
        document["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
        let folder = Folder::new(&[]);
        folder.write("a.gltf", &super::mutations::mutate(&document.to_string(), &text));
        let whole = binary(document, &Square::new().bytes);
        folder.write("a.glb", &super::mutations::mutate_bytes(&whole, &bytes));
        for name in ["a.gltf", "a.glb"] {
            if let Ok(scene) = gltf::load(&folder.path(name), &LoadOptions::default()) {
                assert_sound(&scene);
            }
        }
    }
}
