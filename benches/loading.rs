//! Measures how the time of loading grows with the size of a file. Each input comes in three sizes, each twice as large
//! as the one before, so the times should double, or grow a little more.

#![allow(clippy::expect_used, clippy::unwrap_used)]

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use ssct_scenes::obj::{ObjFile, ObjOptions};
use ssct_scenes::{LoadOptions, gltf, obj};
use std::fmt::Write;

/// Returns the text of an OBJ file with twenty faces, each a spiral of `corners` corners.
fn obj_of_spirals(corners: usize) -> String {
    let mut text = String::new();
    for face in 0..20 {
        let half = corners / 2;
        // Writes the line of corner n on a spiral arm that begins at a radius.
        let corner = |n: usize, radius: f64| {
            let angle = n as f64 * 0.2;
            let distance = radius + 0.3 * angle;
            format!("v {} {} {face}\n", distance * angle.cos(), distance * angle.sin())
        };
        // The outline goes out along one arm and back along the other.
        text.extend((0..half).map(|n| corner(n, 1.0)).chain((0..half).rev().map(|n| corner(n, 1.5))));
        text.push('f');
        for n in 0..2 * half {
            // Writing to a String cannot fail.
            let _ = write!(text, " {}", face * 2 * half + n + 1);
        }
        text.push('\n');
    }
    text
}

/// Returns the text of a glTF file with a triangle, and with `count` cameras of one name.
fn gltf_of_cameras(count: usize) -> String {
    let camera = r#"{"camera":0,"name":"cam","translation":[0,0,4]}"#;
    let nodes = vec![camera; count].join(",");
    let node_numbers: Vec<String> = (0..=count).map(|node| node.to_string()).collect();
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let data: String =
        corners.iter().flat_map(|coordinate| coordinate.to_le_bytes()).map(|byte| format!("%{byte:02X}")).collect();
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[{}]}}],"nodes":[{{"mesh":0}},{nodes}],
        "cameras":[{{"type":"perspective","perspective":{{"yfov":1,"znear":0.1}}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36,"uri":"data:,{data}"}}]}}"#,
        node_numbers.join(",")
    )
}

/// Times the loading of both kinds of files in three sizes each.
fn time_loading(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a folder");
    let write_file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("writes");
        path
    };
    let mut group = criterion.benchmark_group("loading");
    group.sample_size(10);
    for corners in [256, 512, 1024] {
        let files = [ObjFile::from(write_file("a.obj", &obj_of_spirals(corners)))];
        group.bench_function(BenchmarkId::new("concave faces", corners), |b| {
            b.iter(|| obj::load(&files, &ObjOptions::default()).expect("loads"));
        });
    }
    for count in [1000, 2000, 4000] {
        let path = write_file("a.gltf", &gltf_of_cameras(count));
        group.bench_function(BenchmarkId::new("cameras of one name", count), |b| {
            b.iter(|| gltf::load(&path, &LoadOptions::default()).expect("loads"));
        });
    }
}

criterion_group!(benches, time_loading);
criterion_main!(benches);
