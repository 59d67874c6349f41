//! Tests files that glTF 2.0 allows, and files that other programs write and that have one obvious reading. They load,
//! with a warning where a file breaks the specification.

use super::gltf::{Square, binary, close, error, picture, pictured, scene, sentences, square};
use super::*;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};
use ssct_scenes::{Light, gltf};

/// Checks that the scene is the unchanged square: sides of 2 by 1 in the xy plane.
fn assert_is_square(scene: &Scene) {
    assert!(close(area(scene), 2.0) && scene.triangle_count() == 2, "{}", area(scene));
    let bounds = scene.bounds();
    assert!(
        bounds.min.distance(Vec3::ZERO) < 1e-5 && bounds.max.distance(Vec3::new(2.0, 1.0, 0.0)) < 1e-5,
        "{bounds:?}"
    );
}

/// Checks that the square with a change loads as the square does, with exactly these warnings.
fn assert_loads_as_square(warnings: &[&str], change: impl FnOnce(&mut Value)) {
    let scene = scene(&square(json!({}), change));
    assert_is_square(&scene);
    assert_eq!(sentences(&scene), warnings);
}

/// Attributes whose names begin with `_` are the application's own; other unknown names get a sentence. A strict reader
/// would refuse files that the specification allows.
#[test]
fn attributes_of_applications_are_passed_over() {
    let add = |name: &'static str| move |d: &mut Value| d["meshes"][0]["primitives"][0]["attributes"][name] = 2.into();
    assert_loads_as_square(&[], add("_WARMTH"));
    assert_loads_as_square(&[], add("_"));
    assert_loads_as_square(&["the attribute WARMTH of a mesh is not one of glTF and was ignored"], add("WARMTH"));
    assert_loads_as_square(
        &["the attribute TEXCOORD_x of a mesh is not one of glTF and was ignored"],
        add("TEXCOORD_x"),
    );
    assert_loads_as_square(&[], |d| {
        add("_A")(d);
        add("_B")(d);
    });
}

/// An animation with an unknown target, too few values or no content is left out with a sentence, and the scene loads,
/// since it needs no animation to be drawn.
#[test]
fn animations_that_cannot_be_played_are_passed_over() {
    for (target, warning) in [
        (json!({"path": "scale"}), None),
        (
            json!({"node": 0, "path": "pointer"}),
            Some("animation 0 was left out: its channel 0 changes what is not one of glTF"),
        ),
        (
            json!({"node": 0, "path": "scale"}),
            Some("animation 0 was left out: its channel 0 does not have as many values as its key frames need"),
        ),
        (json!({}), Some("animation 0 is not one of glTF and was left out")),
    ] {
        assert_loads_as_square(warning.as_slice(), |d| {
            d["animations"] =
                json!([{"samplers": [{"input": 3, "output": 0}], "channels": [{"sampler": 0, "target": target}]}]);
        });
    }
    assert_loads_as_square(&[], |d| d["animations"] = json!([]));
}

/// An accessor without bytes has zeros, as glTF says. Too large a count is refused, since such an accessor allocates
/// memory that no file has to hold.
#[test]
fn accessors_without_a_view_are_zeros() {
    assert_loads_as_square(&[], |d| {
        d["accessors"][2].as_object_mut().unwrap().remove("bufferView");
    });
    let zeros = scene(&square(json!({}), |d| {
        d["accessors"][2].as_object_mut().unwrap().remove("bufferView");
    }));
    assert!(zeros.meshes[0].vertices.iter().all(|v| v.uv == [0.0, 0.0]));
    // All positions at one place have no area.
    let no_area = error(&square(json!({}), |d| {
        d["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    }));
    assert_eq!(no_area, "has no triangle with an area in its scene");
    let claims = error(&square(json!({}), |d| {
        let accessor = d["accessors"][3].as_object_mut().unwrap();
        accessor.remove("bufferView");
        accessor.insert("count".into(), 4_000_000_000_u64.into());
    }));
    assert_eq!(claims, "accessor 3 has 4000000000 elements without bytes, more than 1048576");
}

/// A sparse accessor replaces the elements that its indices name, over bytes or over zeros.
#[test]
fn sparse_accessors_change_some_elements() {
    let sparse_scene = |has_base: bool| {
        let mut square = Square::new();
        // Elements 2 and 1, in this order, of the positions: the right side is moved to x = 4.
        square.accessor("SCALAR", 5121, 2, &[2, 1]);
        square.floats("VEC3", &[4.0, 1.0, 0.0, 4.0, 0.0, 0.0]);
        let mut document = square.document(json!({}));
        let indices = json!({"bufferView": 4, "componentType": 5121});
        let position = &mut document["accessors"][0];
        position["sparse"] = json!({"count": 2, "indices": indices, "values": {"bufferView": 5}});
        if !has_base {
            position.as_object_mut().unwrap().remove("bufferView");
        }
        scene(&document)
    };
    assert_eq!((area(&sparse_scene(true)), sparse_scene(true).bounds().max.x), (4.0, 4.0));
    // Without a view, the others are at the origin: one of the two triangles is left.
    assert_eq!((area(&sparse_scene(false)), sparse_scene(false).triangle_count()), (2.0, 1));
}

/// A further scene without nodes, and a file without scenes, load; if the shown scene has no nodes, the file is
/// refused.
#[test]
fn scenes_without_nodes_are_allowed() {
    assert_loads_as_square(&[], |d| d["scenes"] = json!([{"nodes": [0]}, {"name": "empty"}]));
    assert_loads_as_square(&[], |d| d["scenes"] = json!([{"nodes": [0]}, {"nodes": []}]));
    assert_loads_as_square(&[], |d| {
        d.as_object_mut().unwrap().remove("scenes");
        d.as_object_mut().unwrap().remove("scene");
    });
    let shown = error(&square(json!({}), |d| d["scenes"] = json!([{"name": "empty"}])));
    assert_eq!(shown, "has no triangle with an area in its scene");
}

/// Whole numbers that are written as floats, nulls, strides of 0 and missing bounds have their obvious reading.
#[test]
fn numbers_nulls_and_distances_are_read_as_they_are_meant() {
    assert_loads_as_square(&[], |d| {
        for accessor in d["accessors"].as_array_mut().unwrap() {
            accessor["count"] = (accessor["count"].as_u64().unwrap() as f64).into();
            accessor["componentType"] = (accessor["componentType"].as_u64().unwrap() as f64).into();
        }
        d["buffers"][0]["byteLength"] = 140.0.into();
        d["nodes"][0]["mesh"] = 0.0.into();
        d["scene"] = 0.0.into();
    });
    assert_loads_as_square(&[], |d| {
        d["nodes"][0]["camera"] = Value::Null;
        d["nodes"][0]["children"] = Value::Null;
        d["materials"][0]["name"] = Value::Null;
        d["skins"] = Value::Null;
        d["meshes"][0]["primitives"][0]["targets"] = Value::Null;
    });
    assert_loads_as_square(&[], |d| d["bufferViews"][0]["byteStride"] = 0.into());
    assert_loads_as_square(&[], |d| d["bufferViews"][0]["target"] = 1.into());
    assert_loads_as_square(&[], |d| d["asset"]["version"] = 2.0.into());
    assert_loads_as_square(&["positions lack their bounds (min and max), which were computed"], |d| {
        d["accessors"][0].as_object_mut().unwrap().remove("min");
    });
    assert_loads_as_square(&["positions lack their bounds (min and max), which were computed"], |d| {
        d["accessors"][0]["max"] = json!(["a", 1]);
    });
    let half = error(&square(json!({}), |d| d["accessors"][0]["count"] = 3.5.into()));
    assert!(half.starts_with("is not glTF 2.0: ") && half.contains("3.5"), "{half}");
}

/// An unknown mode of wrapping textures is read as repetition, with a warning.
#[test]
fn unknown_ways_of_repeating_are_plain() {
    // Returns the number of warnings for a mode of wrapping, in which 10497 is repetition.
    let warning_count = |wrap: u32| {
        let mut document = pictured(
            json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}),
            &[picture(1, 1, |_, _| [9; 4])],
        );
        document["samplers"] = json!([{"wrapS": wrap, "wrapT": 10497, "minFilter": 3, "magFilter": 4}]);
        document["textures"][0]["sampler"] = 0.into();
        scene(&document).warnings.len()
    };
    assert_eq!((warning_count(10497), warning_count(7)), (0, 1));
}

/// Data addresses in base64 or percent codes, with any case, line breaks and missing padding are read; broken ones are
/// refused. Each of these forms occurs in files of some exporter.
#[test]
fn data_addresses_are_read_as_rfc_2397_says() {
    let bytes = Square::new().bytes;
    let base64 = BASE64_STANDARD.encode(&bytes);
    let percent: String = bytes.iter().map(|b| format!("%{b:02X}")).collect();
    let in_lines = base64.as_bytes().chunks(64).map(|c| String::from_utf8_lossy(c)).collect::<Vec<_>>().join("\r\n");
    for uri in [
        format!("data:application/octet-stream,{percent}"),
        format!("data:,{percent}"),
        format!("data:application/octet-stream;base64,{}", base64.replace('=', "%3D").replace('/', "%2f")),
        format!("DATA:application/octet-stream;BASE64,{base64}"),
        format!("Data:;base64,{}", base64.trim_end_matches('=')),
        format!("data:application/gltf-buffer;charset=utf-8;base64,{base64}"),
        format!("data:;base64,{in_lines}"),
    ] {
        assert_loads_as_square(&[], |d| d["buffers"][0]["uri"] = uri.into());
    }
    for uri in ["data:", "data:;base64", "data:;base64,", "data:;base64,!!!!", "DATA:x,"] {
        let message = error(&square(json!({}), |d| d["buffers"][0]["uri"] = uri.into()));
        assert_eq!(message, "buffer 0 is not valid base64", "{uri}");
    }
    let mut image = picture(1, 1, |_, _| [0, 255, 0, 255]);
    let encoded = image["uri"].as_str().unwrap().replace("data:image/png", "DATA:image/PNG").replace('+', "%2B");
    image["uri"] = encoded.into();
    let green = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}});
    let scene = scene(&pictured(green, &[image]));
    assert_eq!((scene.warnings.len(), &scene.textures[0].rgba[..]), (0, &[0, 255, 0, 255][..]));
}

/// Network addresses, folders and devices are refused as buffers or images: a scene of somebody else must open no
/// connection and no device. A file name with a percent sign is found as it is written.
#[test]
fn addresses_that_are_no_files_are_refused() {
    let refusal = |uri: &str| error(&square(json!({}), |d| d["buffers"][0]["uri"] = uri.into()));
    let network = refusal("https://example.org/a.bin");
    assert_eq!(network, "buffer 0 is at an address of the kind https:, which is not read");
    assert!(refusal("file:///etc/passwd").contains("of the kind file:"));
    for folder in [".", "..", "/dev"] {
        assert!(
            refusal(folder).contains("is no file; a buffer is read from a regular file alone"),
            "{folder}: {}",
            refusal(folder)
        );
    }
    if std::path::Path::new("/dev/zero").exists() {
        for device in ["/dev/zero", "../../../../../../dev/zero", "..%2f..%2f..%2f..%2f..%2fdev/zero"] {
            assert!(refusal(device).contains("is no file"), "{device}: {}", refusal(device));
        }
    }
    let long = refusal(&"x".repeat(3000));
    assert!(long.len() < 8000, "{}", long.len());
    let image = json!({"uri": "https://example.org/a.png"});
    let remote = scene(&pictured(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}), &[image]));
    assert!(sentences(&remote)[0].contains("of the kind https:"), "{:?}", remote.warnings);
    // The file has the name with its percent sign, which is no code here.
    let folder = Folder::new(&[]);
    folder.write("100%41.bin", &Square::new().bytes);
    let document = square(json!({}), |d| d["buffers"][0]["uri"] = "100%41.bin".into());
    folder.write("a.gltf", document.to_string().as_bytes());
    assert_is_square(&gltf::load(&folder.path("a.gltf"), &LoadOptions::default()).unwrap());
}

/// Returns the square with a skin of two joints. Every vertex has the two weights; the joints are nodes of their own.
fn skinned(weights: [f32; 2], change: impl FnOnce(&mut Value)) -> Value {
    let mut square = Square::new();
    square.accessor("VEC4", 5121, 4, &[0, 1, 0, 0].repeat(4));
    square.floats("VEC4", &[weights[0], weights[1], 0.0, 0.0].repeat(4));
    let matrix = |scale: f32, shift: f32| {
        let mut columns = [0.0; 16];
        (columns[0], columns[5], columns[10], columns[15], columns[12]) = (scale, scale, scale, 1.0, shift);
        columns
    };
    square.floats("MAT4", &[matrix(1.0, 0.0), matrix(1.0, -10.0)].concat());
    let mut document = square.document(json!({}));
    let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (4.into(), 5.into());
    document["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": 6}]);
    document["nodes"] = json!([
        {"mesh": 0, "skin": 0, "translation": [0, 50, 0]},
        {"name": "first", "translation": [0, 0, 0]},
        {"name": "second", "translation": [10, 0, 0]},
    ]);
    document["scenes"] = json!([{"nodes": [0, 1, 2]}]);
    change(&mut document);
    document
}

/// A mesh with a skin stands where its joints place it, and not where its own node does, as glTF demands.
#[test]
fn skins_are_placed_by_their_joints() {
    let placed = |weights, change: fn(&mut Value)| scene(&skinned(weights, change));
    // The node of the mesh is at (0, 50, 0), and moves nothing. Both joints stand where they were bound.
    for weights in [[1.0, 0.0], [0.0, 1.0], [0.5, 0.5], [3.0, 1.0], [0.0, 0.0], [f32::NAN, 1.0]] {
        let scene = placed(weights, |_| ());
        assert_is_square(&scene);
        assert_eq!(scene.warnings.len(), 0, "{:?}", scene.warnings);
    }
    // A joint that moved takes its share along.
    let moved = |d: &mut Value| d["nodes"][2]["translation"] = json!([14, 0, 0]);
    assert_eq!(placed([0.0, 1.0], moved).bounds().min.x, 4.0);
    assert_eq!(placed([0.5, 0.5], moved).bounds().min.x, 2.0);
    assert_eq!(placed([1.0, 0.0], moved).bounds().min.x, 0.0);
    // A node above scales everything by 100, and the joint scales by 0.01.
    let scaled = |d: &mut Value| {
        d["nodes"] = json!([{"mesh": 0, "skin": 0}, {"scale": [0.01, 0.01, 0.01]}, {}, {"children": [0, 1, 2], "scale": [100, 100, 100]}]);
        d["scenes"] = json!([{"nodes": [3]}]);
    };
    assert_is_square(&placed([1.0, 0.0], scaled));
    // The joints are no nodes of the shown scene.
    assert_is_square(&placed([0.5, 0.5], |d| d["scenes"] = json!([{"nodes": [0]}])));
    // Without matrices, joints are taken as they stand.
    let plain = placed([0.0, 1.0], |d| {
        d["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    });
    assert_eq!(plain.bounds().min.x, 10.0);
}

/// A skin with too few joints or matrices, or with a wrong accessor, is refused with its name.
#[test]
fn skins_that_cannot_be_are_named() {
    let message = |change: fn(&mut Value)| error(&skinned([1.0, 0.0], change));
    assert_eq!(
        message(|d| d["skins"][0]["joints"] = json!([1])),
        "mesh mesh 0: vertex 0 has joint 1, and the skin has 1 joints"
    );
    assert_eq!(
        message(|d| d["skins"][0]["joints"] = json!([1, 2, 0])),
        "skin 0 has fewer inverse bind matrices than its 3 joints"
    );
    assert_eq!(
        message(|d| d["skins"][0]["inverseBindMatrices"] = 5.into()),
        "accessor 5 of inverse bind matrices must have 4x4 floats"
    );
}

/// A morph target moves positions by its weight; the weights of the node override those of the mesh.
#[test]
fn morph_targets_count_by_their_weights() {
    let morphed = |mesh: Value, node: Value| {
        let mut square = Square::new();
        square.floats("VEC3", &[0.0, 0.0, 3.0].repeat(4));
        let mut document = square.document(json!({}));
        document["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 4}, {"NORMAL": 1}]);
        document["meshes"][0]["weights"] = mesh;
        document["nodes"][0]["weights"] = node;
        let scene = scene(&document);
        assert_eq!(scene.warnings.len(), 0, "{:?}", scene.warnings);
        scene.bounds().min.z
    };
    assert_eq!(morphed(Value::Null, Value::Null), 0.0);
    assert_eq!(morphed(json!([0.5, 0]), Value::Null), -1.5);
    assert_eq!(morphed(json!([0.5, 0]), json!([1, 0])), -3.0, "the node's weights go before the mesh's");
    assert_eq!(morphed(json!([0, 1]), Value::Null), 0.0);
}

/// A scene that is loaded at an eighth of its size has all lengths scaled: bounds, views, planes, and energies of point
/// lights as squares of lengths. A length that is forgotten shows in no other test.
#[test]
fn the_scale_is_of_every_length() {
    let document = square(json!({}), |d| {
        d["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        d["cameras"] = json!([
            {"type": "perspective", "perspective": {"yfov": 1, "znear": 1, "zfar": 100}},
            {"type": "perspective", "perspective": {"yfov": 1, "znear": 0.5}},
        ]);
        d["extensions"] = json!({"KHR_lights_punctual": {"lights": [
            {"type": "point", "intensity": 64, "range": 20}, {"type": "directional", "intensity": 2},
        ]}});
        let lamp = |n: u32| json!({"translation": [1, 0.5, 4], "extensions": {"KHR_lights_punctual": {"light": n}}});
        d["nodes"] = json!([{"mesh": 0}, {"camera": 0, "translation": [0, 0, 4]}, {"camera": 1}, lamp(0), lamp(1)]);
        d["scenes"] = json!([{"nodes": [0, 1, 2, 3, 4]}]);
    });
    let folder = Folder::new(&[("a.gltf", &document.to_string())]);
    let loaded = |scale: f32| gltf::load(&folder.path("a.gltf"), &scaled(scale)).unwrap();
    let (whole, small) = (loaded(1.0), loaded(0.125));
    assert_eq!(small.bounds().max, 0.125 * whole.bounds().max);
    for (view, small_view) in whole.views.iter().zip(&small.views) {
        let (lens, small_lens) = (view.lens.unwrap(), small_view.lens.unwrap());
        assert_eq!((0.125 * view.eye, 0.125 * view.look_at), (small_view.eye, small_view.look_at));
        assert_eq!([0.125 * lens.near_m, 0.125 * lens.far_m], [small_lens.near_m, small_lens.far_m]);
    }
    let [Light::Point { energy: lamp, .. }, Light::Directional { energy: sun, .. }] = whole.lights[..] else {
        panic!("{:?}", whole.lights)
    };
    let [Light::Point { energy: dim_lamp, .. }, Light::Directional { energy: same_sun, .. }] = small.lights[..] else {
        panic!("{:?}", small.lights)
    };
    assert!(close(lamp / 64.0, dim_lamp) && close(sun, same_sun), "lamps scale by the square: {lamp} {dim_lamp}");
    assert_eq!(sentences(&whole), ["ranges of lights are not supported; lights reach as far as they fade"]);
}

/// Old glTF, other JSON, empty, truncated and wide texts, and damaged binary files each get a sentence of their own.
#[test]
fn files_of_other_kinds_are_told_apart() {
    let message_of = |name: &str, bytes: &[u8]| {
        let folder = Folder::new(&[]);
        folder.write(name, bytes);
        let error = gltf::load(&folder.path(name), &LoadOptions::default()).unwrap_err().to_string();
        folder.without_folder(&error).split_once(": ").unwrap().1.to_owned()
    };
    let text = |text: &str| message_of("a.gltf", text.as_bytes());
    let old = r#"{"asset": {"version": "1.0"}, "scenes": {"s": {"nodes": []}}, "nodes": {}}"#;
    assert_eq!(text(old), "is glTF 1.0; version 2 is supported");
    assert_eq!(text(r#"{"nodes": {}, "meshes": {}}"#), "is glTF 1.0; version 2 is supported");
    assert_eq!(text(r#"{"asset": {"version": 1.0}}"#), "is glTF 1.0; version 2 is supported");
    assert_eq!(text(r#"{"asset": {}}"#), "is not glTF 2.0: it has no asset with a version");
    assert_eq!(text("[]"), "is not glTF 2.0: its JSON is no object");
    assert_eq!(text(" \n"), "is empty");
    assert_eq!(text("{\n\"asset\": {\n\"ver"), "is a truncated glTF file: its JSON ends too early, in line 3");
    assert!(text("v 0 0 0").starts_with("is not JSON, as glTF must be: "), "{}", text("v 0 0 0"));
    let whole = square(json!({}), |_| ()).to_string();
    let wide: Vec<u8> = whole.encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_eq!(message_of("a.gltf", &wide), "is UTF-16 text; save it as UTF-8");
    assert!(message_of("a.gltf", b"{\"a\": \"\xe9\"}").starts_with("is not UTF-8 text, as glTF must be"));

    let glb = binary(Square::new().document(json!({})), &Square::new().bytes);
    assert_eq!(message_of("a.glb", &glb[..6]), "is a truncated .glb: it ends within its header, after 6 bytes");
    let half = message_of("a.glb", &glb[..glb.len() / 2]);
    assert_eq!(half, format!("is a truncated .glb: it has {} bytes and states {}", glb.len() / 2, glb.len()));
    let old = [&b"glTF"[..], &1_u32.to_le_bytes(), &20_u32.to_le_bytes(), &[0; 8]].concat();
    assert_eq!(message_of("a.glb", &old), "is glTF 1.0; version 2 is supported");
    let mut long_chunk = glb.clone();
    long_chunk[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(message_of("a.glb", &long_chunk).starts_with("is a truncated .glb: a chunk states 4294967295 bytes, and "));
}

/// A file that begins with a byte order mark, and a binary file with unknown chunks, load as the square.
#[test]
fn byte_order_marks_and_unknown_chunks_are_skipped() {
    let marked = format!("\u{feff}{}", square(json!({}), |_| ()));
    let folder = Folder::new(&[("a.gltf", &marked)]);
    assert_is_square(&gltf::load(&folder.path("a.gltf"), &LoadOptions::default()).unwrap());
    // A chunk of another kind before the binary one, and one behind it.
    let glb = binary(Square::new().document(json!({})), &Square::new().bytes);
    let json_end = 20 + u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let other = [&4_u32.to_le_bytes()[..], b"XTRA", b"abcd"].concat();
    let mut with_chunks = [&glb[..json_end], &other, &glb[json_end..], &other].concat();
    let length = (with_chunks.len() as u32).to_le_bytes();
    with_chunks[8..12].copy_from_slice(&length);
    folder.write("a.glb", &with_chunks);
    assert_is_square(&gltf::load(&folder.path("a.glb"), &LoadOptions::default()).unwrap());
}

/// A primitive without positions is left out with a sentence, and the other primitives are drawn.
#[test]
fn primitives_without_positions_are_not_drawn() {
    assert_loads_as_square(&["primitives without positions are not drawn"], |d| {
        let whole = d["meshes"][0]["primitives"][0].clone();
        let mut without_positions = whole.clone();
        without_positions["attributes"].as_object_mut().unwrap().remove("POSITION");
        d["meshes"][0]["primitives"] = json!([whole, without_positions]);
    });
}

/// Returns the square's document in which one accessor has other floats, of the type `kind` of glTF.
fn with_floats(accessor: usize, kind: &str, floats: &[f32]) -> Value {
    let mut square = Square::new();
    square.floats(kind, floats);
    let mut document = square.document(json!({}));
    document["accessors"][accessor] = document["accessors"][4].clone();
    document
}

/// Normals and texture coordinates of NaN or infinity are replaced with a sentence; a position of NaN is refused if a
/// triangle has it.
#[test]
fn values_that_are_no_numbers_have_a_reading_unless_they_are_places() {
    let nan = f32::NAN;
    let scene = super::gltf::scene(&with_floats(
        1,
        "VEC3",
        &[[nan, 0.0, 1.0], [0.0, f32::INFINITY, 0.0], [0.0; 3], [0.0, 0.0, 1.0]].concat(),
    ));
    assert_is_square(&scene);
    assert_eq!(sentences(&scene), ["normals that are not finite became those of their triangles"]);
    assert!(scene.meshes[0].vertices.iter().all(|v| normal(v) == Vec3::NEG_Z));
    let scene = super::gltf::scene(&with_floats(2, "VEC2", &[nan, 0.0, 1.0, 1.0, f32::INFINITY, 0.0, 0.0, 0.0]));
    assert_eq!(sentences(&scene), ["texture coordinates that are not finite count as 0"]);
    let place =
        error(&with_floats(0, "VEC3", &[[nan, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]].concat()));
    assert_eq!(place, "mesh square: the position of vertex 0 is not a number");
    // A vertex that no triangle uses may have any values.
    let mut unused = with_floats(0, "VEC3", &[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [nan; 3]].concat());
    unused["accessors"][3]["count"] = 3.into();
    assert_eq!(super::gltf::scene(&unused).triangle_count(), 1);
}

/// Normals that lean 8 degrees behind their face stay, and normals that point to the back are turned with a sentence.
#[test]
fn normals_of_an_author_stay_unless_they_point_to_the_back() {
    // Eight degrees behind the face, as seen from its front at +z of the file.
    let leaning = super::gltf::scene(&with_floats(1, "VEC3", &[0.0, 0.99, -0.14].repeat(4)));
    assert_eq!(sentences(&leaning), [""; 0]);
    let kept = Vec3::new(0.0, 0.99, 0.14).normalize();
    assert!(leaning.meshes[0].vertices.iter().all(|v| normal(v).distance(kept) < 1e-6), "z is negated, nothing else");
    let turned = super::gltf::scene(&with_floats(1, "VEC3", &[0.0, 0.0, -1.0].repeat(4)));
    assert_eq!(sentences(&turned), ["normals that point to the back of their triangles were turned to its front"]);
    assert!(turned.meshes[0].vertices.iter().all(|v| normal(v) == Vec3::NEG_Z));
}
