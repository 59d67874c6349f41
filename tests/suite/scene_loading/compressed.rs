//! Tests glTF with compressed content: meshes of meshopt and images of WebP. Other compressions are refused with the
//! command of a tool that makes the file readable.

use super::gltf::{Square, error, load, picture, pictured, scene, sentences, square};
use super::*;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};

/// The name of the meshopt extension before Khronos ratified it.
const EXT: &str = "EXT_meshopt_compression";
/// The ratified name of the meshopt extension.
const KHR: &str = "KHR_meshopt_compression";

/// Returns bytes as a data address.
fn data(bytes: &[u8]) -> Value {
    format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(bytes)).into()
}

/// Returns the square with all of its views stored by meshopt, under either name of the extension, as optimisers write
/// it: the buffer that the views name has no bytes.
fn compressed(name: &str, change: impl FnOnce(&mut Value)) -> Value {
    let plain = Square::new();
    let mut document = plain.document(json!({}));
    let mut encoded = Vec::new();
    for (index, view) in plain.views.iter().enumerate() {
        let number = |key: &str| view[key].as_u64().unwrap() as usize;
        let bytes = &plain.bytes[number("byteOffset")..][..number("byteLength")];
        let (mode, stride, stored) = match index {
            3 => {
                let indices: Vec<u32> = bytes.chunks(2).map(|b| u32::from(u16::from_le_bytes([b[0], b[1]]))).collect();
                ("TRIANGLES", 2, meshopt::encode_index_buffer(&indices, 4).unwrap())
            }
            2 => ("ATTRIBUTES", 8, meshopt::encode_vertex_buffer(bytemuck::cast_slice::<u8, [u8; 8]>(bytes)).unwrap()),
            _ => {
                ("ATTRIBUTES", 12, meshopt::encode_vertex_buffer(bytemuck::cast_slice::<u8, [u8; 12]>(bytes)).unwrap())
            }
        };
        document["bufferViews"][index]["extensions"] = json!({name: {
            "buffer": 1, "byteOffset": encoded.len(), "byteLength": stored.len(), "byteStride": stride,
            "count": bytes.len() / stride, "mode": mode,
        }});
        encoded.extend(stored);
    }
    let fallback = json!({"byteLength": plain.bytes.len(), "extensions": {name: {"fallback": true}}});
    document["buffers"] = json!([fallback, {"byteLength": encoded.len(), "uri": data(&encoded)}]);
    document["extensionsUsed"] = json!([name]);
    document["extensionsRequired"] = json!([name]);
    change(&mut document);
    document
}

/// The square in views of meshopt has the vertices and indices of the plain square, under both names of the extension.
#[test]
fn views_of_meshopt_hold_what_they_held_before() {
    let plain = scene(&square(json!({}), |_| ()));
    for name in [EXT, KHR] {
        let scene = scene(&compressed(name, |_| ()));
        assert_eq!(scene.meshes[0].vertices, plain.meshes[0].vertices, "{name}");
        assert_eq!(scene.meshes[0].indices, plain.meshes[0].indices, "{name}");
        assert_eq!(sentences(&scene), [""; 0]);
    }
}

/// Normals in octahedral filters of 8 and 16 bits and in exponential filters are decoded within the rounding of each
/// filter. Read without the filter, they are other directions.
#[test]
fn filters_of_meshopt_are_undone() {
    // Returns the square whose normals are stored with a filter: the component type of glTF, the bytes of an element,
    // and the compressed bytes.
    let filtered = |filter: &'static str, component: u32, stride: usize, stored: Vec<u8>| {
        compressed(EXT, |d| {
            d["buffers"][1]["uri"].take();
            let view = &mut d["bufferViews"][1];
            view["extensions"][EXT] = json!({
                "buffer": 2, "byteOffset": 0, "byteLength": stored.len(), "byteStride": stride, "count": 4,
                "mode": "ATTRIBUTES", "filter": filter,
            });
            view["byteLength"] = (4 * stride).into();
            view["byteStride"] = stride.into();
            d["accessors"][1]["componentType"] = component.into();
            d["accessors"][1]["normalized"] = (component != 5126).into();
            let mut buffers = compressed(EXT, |_| ())["buffers"].clone();
            buffers.as_array_mut().unwrap().push(json!({"byteLength": stored.len(), "uri": data(&stored)}));
            d["buffers"] = buffers;
        })
    };
    let normals = [[0.6_f32, 0.0, 0.8, 0.0]; 4];
    let bytes: Vec<[i8; 4]> = meshopt::encode_filter_oct(&normals, 8);
    let shorts: Vec<[i16; 4]> = meshopt::encode_filter_oct(&normals, 16);
    let floats: Vec<f32> = normals.iter().flat_map(|v| &v[..3]).copied().collect();
    let exponents: Vec<[u32; 3]> = meshopt::encode_filter_exp(
        bytemuck::cast_slice::<f32, [f32; 3]>(&floats),
        15,
        meshopt::EncodeExpMode::Separate,
    );
    for (document, bound) in [
        (filtered("OCTAHEDRAL", 5120, 4, meshopt::encode_vertex_buffer(&bytes).unwrap()), 0.02),
        (filtered("OCTAHEDRAL", 5122, 8, meshopt::encode_vertex_buffer(&shorts).unwrap()), 1e-3),
        (filtered("EXPONENTIAL", 5126, 12, meshopt::encode_vertex_buffer(&exponents).unwrap()), 1e-3),
    ] {
        let scene = scene(&document);
        // The file is right-handed.
        let distance = normal(&scene.meshes[0].vertices[0]).distance(Vec3::new(0.6, 0.0, -0.8));
        assert!(distance < bound, "{distance}");
    }
}

/// A view of meshopt with a wrong count, place, stride, mode or filter is refused with its number and the cause. The
/// decoder must not read past its bytes, nor allocate what a small view claims.
#[test]
fn damaged_views_of_meshopt_get_a_sentence() {
    let refusal =
        |change: fn(&mut Value)| error(&compressed(EXT, |d| change(&mut d["bufferViews"][0]["extensions"][EXT])));
    for (change, cause) in [
        ((|v| v["count"] = 5.into()) as fn(&mut Value), "its compressed bytes are damaged"),
        (|v| v["byteLength"] = 3.into(), "its compressed bytes are damaged"),
        (|v| v["byteOffset"] = 4000.into(), "its compressed bytes leave their buffer"),
        (|v| v["byteStride"] = 13.into(), "ATTRIBUTES with 4 elements of 13 bytes is no mode of meshopt"),
        (|v| v["mode"] = "POINTS".into(), "POINTS with 4 elements of 12 bytes is no mode of meshopt"),
        (|v| v["filter"] = "QUATERNION".into(), "the filter QUATERNION is none of meshopt for elements of 12 bytes"),
    ] {
        assert_eq!(refusal(change), format!("buffer view 0: {cause}"));
    }
    let claims = refusal(|v| v["count"] = (1_u64 << 40).into());
    assert!(claims.starts_with("buffer view 0: ") && claims.contains("cannot hold 1099511627776 elements"), "{claims}");
    let member = refusal(|v| v["count"] = "four".into());
    assert!(member.starts_with("buffer view 0: its compression is not one of meshopt"), "{member}");
}

/// Returns a picture as WebP, as an image of glTF.
fn webp(width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Value {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = image::RgbaImage::from_fn(width, height, |x, y| image::Rgba(texel(x, y)));
    image.write_to(&mut bytes, image::ImageFormat::WebP).unwrap();
    let uri = format!("data:image/webp;base64,{}", BASE64_STANDARD.encode(bytes.into_inner()));
    json!({"uri": uri, "mimeType": "image/webp"})
}

/// An image in lossless WebP has the texels of the PNG.
#[test]
fn images_may_be_webp() {
    let material = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}});
    let texel = |x: u32, y: u32| [x as u8 * 40, y as u8 * 80, 7, 255];
    let mut document = pictured(material.clone(), &[webp(4, 2, texel)]);
    document["textures"] = json!([{"extensions": {"EXT_texture_webp": {"source": 0}}}]);
    document["extensionsUsed"] = json!(["EXT_texture_webp"]);
    document["extensionsRequired"] = json!(["EXT_texture_webp"]);
    let png = scene(&pictured(material, &[picture(4, 2, texel)]));
    let webp = scene(&document);
    assert_eq!((&webp.textures[0].rgba, sentences(&webp)), (&png.textures[0].rgba, vec![]));
}

/// A large WebP image in few bytes is loaded. The bound that refuses huge images in small files must allow this, since
/// one colour compresses so well.
#[test]
fn a_webp_image_of_one_colour_may_be_large() {
    let material = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}});
    let scene = scene(&pictured(material, &[webp(2048, 1024, |_, _| [9, 8, 7, 255])]));
    assert_eq!((scene.textures[0].width, &scene.textures[0].rgba[..3]), (2048, &[9, 8, 7][..]), "{:?}", scene.warnings);
}

/// Required extensions that are not supported are refused with a command that converts the file.
#[test]
fn what_is_refused_says_which_command_makes_it_readable() {
    for (name, command) in [
        ("KHR_draco_mesh_compression", "`npx @gltf-transform/cli copy IN.glb OUT.glb`"),
        ("EXT_texture_avif", "`npx @gltf-transform/cli webp IN.glb OUT.glb`"),
        ("KHR_materials_pbrSpecularGlossiness", "`npx @gltf-transform/cli metalrough IN.glb OUT.glb`"),
    ] {
        let message = error(&square(json!({}), |d| d["extensionsRequired"] = json!([name])));
        assert!(
            message.starts_with(&format!("requires the extension {name}, ")) && message.contains(command),
            "{message}"
        );
    }
    // A mesh without other bytes is refused even if the file does not say that it needs the extension.
    let alone = error(&square(json!({}), |d| {
        d["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
        d["accessors"][0].as_object_mut().unwrap().remove("bufferView");
        d["meshes"][0]["primitives"][0]["extensions"] =
            json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {}}});
    }));
    assert!(alone.contains("meshes[0] has no bytes but those of KHR_draco_mesh_compression; `npx"), "{alone}");
    let older = scene(&square(json!({}), |d| d["extensionsUsed"] = json!(["KHR_materials_pbrSpecularGlossiness"])));
    assert!(
        sentences(&older)[0].contains("`npx @gltf-transform/cli metalrough IN.glb OUT.glb`"),
        "{:?}",
        older.warnings
    );
}

/// The member `extras` may be any value in any object, and changes nothing. A reader with a fixed type for it would
/// refuse the file.
#[test]
fn extras_may_be_any_value_of_any_object() {
    let plain = scene(&square(json!({}), |_| ()));
    for extras in [json!(7), json!("a text"), json!([1, 2]), json!(false), json!({"a": {"b": 1}})] {
        let document = square(json!({"extras": extras, "pbrMetallicRoughness": {"extras": extras}}), |d| {
            d["extras"] = extras.clone();
            for path in ["/asset", "/nodes/0", "/meshes/0", "/meshes/0/primitives/0", "/accessors/0", "/bufferViews/0"]
            {
                d.pointer_mut(path).unwrap()["extras"] = extras.clone();
            }
        });
        assert_eq!(scene(&document).meshes[0].vertices, plain.meshes[0].vertices, "{extras}");
    }
}

/// A value of a wrong type is refused with its path in the document and the type that belongs there. The parser's own
/// message names types of Rust and no path.
#[test]
fn wrong_types_are_said_in_the_words_of_gltf() {
    for (path, key, value, message) in [
        (
            "/materials/0/pbrMetallicRoughness",
            "roughnessFactor",
            json!("0.5"),
            "materials[0].pbrMetallicRoughness.roughnessFactor: a text where a number belongs",
        ),
        ("", "samplers", json!({}), "samplers: an object where a list belongs"),
        ("", "scene", json!("main"), "scene: a text where a whole number of at least 0 belongs"),
        ("/nodes/0", "mesh", json!(-1), "nodes[0].mesh: the number -1 where a whole number of at least 0 belongs"),
        ("/meshes/0", "primitives", json!(3), "meshes[0].primitives: the number 3 where a list belongs"),
        (
            "/nodes/0",
            "children",
            json!([0.5]),
            "nodes[0].children[0]: the number 0.5 where a whole number of at least 0 belongs",
        ),
        ("/materials/0", "doubleSided", json!("yes"), "materials[0].doubleSided: a text where true or false belongs"),
        (
            "/nodes/0",
            "translation",
            json!([1, 2]),
            "nodes[0].translation: a list of 2 where a list of 3 numbers belongs",
        ),
        (
            "/nodes/0",
            "extensions",
            json!({"KHR_lights_punctual": {"light": 3}}),
            "nodes[0].extensions.KHR_lights_punctual.light refers to what is not there",
        ),
    ] {
        let document =
            square(json!({"pbrMetallicRoughness": {}}), |d| d.pointer_mut(path).unwrap()[key] = value.clone());
        assert_eq!(error(&document), format!("is not glTF 2.0: {message}"), "{path} {key} {value}");
    }
    assert!(load(&square(json!({"emissiveTexture": {}}), |_| ())).is_err());
}

/// A roughness of 900 counts as 1 and a metalness of −0.5 as 0, with a sentence each.
#[test]
fn factors_out_of_range_are_named_and_clamped() {
    let scene =
        scene(&square(json!({"pbrMetallicRoughness": {"roughnessFactor": 900, "metallicFactor": -0.5}}), |_| ()));
    let warnings = sentences(&scene);
    assert_eq!(
        warnings[0],
        "materials[0].pbrMetallicRoughness.metallicFactor: -0.5 lies outside 0 to 1 and counts as 0"
    );
    assert_eq!(
        warnings[1],
        "materials[0].pbrMetallicRoughness.roughnessFactor: 900 lies outside 0 to 1 and counts as 1"
    );
    assert_eq!(scene.materials[0].roughness, 1.0);
}
