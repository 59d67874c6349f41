//! The work of loading a glTF file grows with the number of its cameras, primitives and materials, and not with the
//! square. The work is counted in bytes that are ever allocated, since a time depends on the machine as much as on the
//! loader.

use crate::common::folder::Folder;
use crate::is_alone;
use crate::memory::allocated;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};
use ssct_scenes::{LoadOptions, Scene, gltf};

/// Returns a document that draws a quad. The positions of its four corners stand in the accessor `repeats` times.
fn quad(repeats: usize) -> Value {
    let corners = [[0.0_f32, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]].concat().repeat(repeats);
    let mut bytes: Vec<u8> = [0_u16, 1, 2, 0, 2, 3].into_iter().flat_map(u16::to_le_bytes).collect();
    bytes.extend(corners.iter().flat_map(|v| v.to_le_bytes()));
    let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&bytes));
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 1}, "indices": 0, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"roughnessFactor": 0}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5123, "count": 6, "type": "SCALAR"},
            {"bufferView": 1, "componentType": 5126, "count": 4 * repeats, "type": "VEC3", "min": [0, 0, 0], "max": [2, 1, 0]},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 12},
            {"buffer": 0, "byteOffset": 12, "byteLength": bytes.len() - 12},
        ],
        "buffers": [{"byteLength": bytes.len(), "uri": uri}],
    })
}

/// Returns a document with `count` cameras. One is named "cam 2", and all others are named "cam", so that the loader
/// must number them.
fn cameras(count: usize) -> Value {
    let mut document = quad(1);
    document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]);
    let camera = json!({"camera": 0, "name": "cam", "translation": [0, 0, 4]});
    let numbered = json!({"camera": 0, "name": "cam 2", "translation": [0, 0, 4]});
    let nodes: Vec<Value> = [json!({"mesh": 0}), numbered].into_iter().chain(vec![camera; count - 1]).collect();
    document["scenes"] = json!([{"nodes": (0..nodes.len()).collect::<Vec<_>>()}]);
    document["nodes"] = nodes.into();
    document
}

/// Returns a document with `count` primitives, each of which draws the same two triangles. They share one accessor,
/// which has ten corners for each primitive.
fn primitives(count: usize) -> Value {
    let mut document = quad(10 * count / 4);
    let primitive = document["meshes"][0]["primitives"][0].clone();
    document["meshes"][0]["primitives"] = vec![primitive; count].into();
    document
}

/// Returns a document with `count` materials, each used by one primitive.
fn materials(count: usize) -> Value {
    let mut document = quad(1);
    let material = document["materials"][0].clone();
    document["materials"] = vec![material; count].into();
    let primitive = document["meshes"][0]["primitives"][0].clone();
    let primitive_of = |index: usize| {
        let mut primitive = primitive.clone();
        primitive["material"] = index.into();
        primitive
    };
    document["meshes"][0]["primitives"] = (0..count).map(primitive_of).collect();
    document
}

/// Loads a document. Returns its scene, and the number of bytes that were allocated meanwhile.
fn loaded(document: &Value) -> (Scene, usize) {
    let folder = Folder::new();
    folder.write("a.gltf", document.to_string());
    let before = allocated();
    let scene = gltf::load(&folder.path("a.gltf"), &LoadOptions::default()).expect("the document is valid");
    (scene, allocated() - before)
}

/// Four times as many things cost less than five times the allocated bytes. A loader that searches or copies all
/// earlier things for each new one would take the square.
#[test]
fn the_work_of_loading_grows_with_the_number_of_things() {
    if !is_alone() {
        return;
    }
    type Make = fn(usize) -> Value;
    for (what, document) in [("cameras", cameras as Make), ("primitives", primitives), ("materials", materials)] {
        // The first load allocates what a process allocates once.
        loaded(&document(8));
        let allocated_bytes = |count| {
            let (_, bytes) = loaded(&document(count));
            bytes
        };
        let [few, many] = [1000, 4000].map(allocated_bytes);
        println!("{what}: {few} bytes for 1000, {many} for 4000");
        assert!(many < 5 * few, "{what}: {few} bytes for 1000, {many} for 4000");
    }
}

/// All of 4000 cameras, primitives and materials are loaded, and the cameras get different names. The shortcuts that
/// keep the work linear must not merge two things into one.
#[test]
fn many_things_of_one_name_or_one_accessor_are_all_there() {
    if !is_alone() {
        return;
    }
    let (scene, _) = loaded(&cameras(4000));
    let names: std::collections::HashSet<&str> = scene.views.iter().map(|v| v.name.as_str()).collect();
    assert_eq!((scene.views.len(), names.len()), (4000, 4000));
    assert!(["cam", "cam 2", "cam 4000"].iter().all(|name| names.contains(name)), "numbers are given in turn");
    assert_eq!(loaded(&primitives(4000)).0.triangle_count(), 8000);
    assert_eq!(loaded(&materials(4000)).0.materials.len(), 4000);
}
