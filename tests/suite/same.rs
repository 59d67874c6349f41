//! Tests that images are equal everywhere: a G-buffer gives the same image, to the bit, in every run, on any number of
//! threads and in subgroups of any size. Lavapipe reads both from its process's environment, so that each configuration
//! is a process of its own.

use crate::common::{clutter, clutter_camera, expected_failures, gpu, repository, with_small_captures};
use sha2::{Digest, Sha256};
use ssct::gpu::frame::Mode;
use ssct::gpu::{DeviceQuery, Gpu, Pixels};
use ssct::methods::{METHODS, Setup, Wants};
use ssct_lab::stage::image::render;
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{View, gbuffer_file};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// Size of the image in pixels: odd sides, several tiles of the rasteriser and workgroups.
const EXTENT: [u32; 2] = [161, 97];

/// The environment variable by which [`child`] learns the file of its G-buffer.
const GBUFFER: &str = "SSCT_TEST_GBUFFER";

/// Returns a hash of the values of some images.
fn hash(images: &[&Pixels]) -> String {
    let mut hash = Sha256::new();
    images.iter().for_each(|p| hash.update(bytemuck::cast_slice::<_, u8>(&p.values)));
    hash.finalize().iter().take(8).map(|b| format!("{b:02x}")).collect()
}

/// Returns a hash of the images of every method, by the method's name. They are made from the G-buffer of a file, or
/// from a drawn scene if the method needs one.
fn image_hashes(gpu: &Gpu, file: &Path) -> BTreeMap<String, String> {
    let data = gbuffer_file::load(file).unwrap();
    let scene = clutter();
    let mut stage = Stage::new(gpu, &scene).unwrap();
    let materials = Globals { roughness: Some(0.2), ..Globals::default() }.materials(&scene, &View::default());
    let mut hashes = BTreeMap::new();
    for method in METHODS {
        let setup = with_small_captures(&Setup::new(EXTENT));
        let image_hash = if method.is_screen_space() {
            let image = gbuffer::reflect(gpu, &data, None, method, &setup).unwrap();
            hash(&[&image.reflection, &image.composite])
        } else {
            let camera = clutter_camera(EXTENT);
            let shot = Shot::new(&mut stage, method, &setup, Wants::REFLECTION, camera, materials.clone()).unwrap();
            let image = render(&mut stage, &shot, false).unwrap();
            hash(&[&image.reflection, &image.composite])
        };
        hashes.insert(method.name.to_owned(), image_hash);
    }
    hashes
}

/// Prints the subgroup size and the hashes of all methods, in a process of its own. The test below compares them with
/// those of other processes.
#[test]
#[ignore = "a process that the test beside it starts"]
fn child() {
    let file = std::env::var_os(GBUFFER).expect("a G-buffer");
    let gpu = Gpu::open(&DeviceQuery::default()).unwrap();
    println!("subgroup {}", gpu.subgroup_size());
    for (method, hash) in image_hashes(&gpu, Path::new(&file)) {
        println!("image {method} {hash}");
    }
}

/// Returns the hashes that a process with some environment variables finds, and its subgroup size, or `None` if the
/// driver crashed.
fn in_a_process(file: &Path, variables: &[(&str, &str)]) -> Option<(BTreeMap<String, String>, u32)> {
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "same::child", "--ignored", "--nocapture"])
        .env(GBUFFER, file)
        .envs(variables.iter().copied())
        .output()
        .unwrap();
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    // A panic of this program has a status; a crash of the driver ends in a signal.
    output.status.code()?;
    assert!(output.status.success(), "{variables:?}: {printed}{}", String::from_utf8_lossy(&output.stderr));
    let method_and_hash = |line: &str| {
        let (method, hash) = line.strip_prefix("image ")?.split_once(' ')?;
        Some((method.to_owned(), hash.to_owned()))
    };
    let hashes: BTreeMap<_, _> = printed.lines().filter_map(method_and_hash).collect();
    assert_eq!(hashes.len(), METHODS.len(), "{printed}");
    let subgroup = printed.lines().find_map(|l| l.strip_prefix("subgroup ")).unwrap().parse().unwrap();
    Some((hashes, subgroup))
}

/// The images of all methods have equal hashes in two runs of one process, with other numbers of threads, and with
/// smaller subgroups. A missing barrier or an order of atomics would change them.
#[test]
fn an_image_is_the_same_in_every_run_on_any_threads_and_subgroups() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("clutter.exr");
    let gpu = gpu();
    let scene = clutter();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let materials = Globals { roughness: Some(0.2), ..Globals::default() }.materials(&scene, &View::default());
    let shot =
        Shot::new(&mut stage, &METHODS[0], &Setup::new(EXTENT), Wants::REFLECTION, clutter_camera(EXTENT), materials)
            .unwrap();
    stage.run(&shot, Mode::Plain).unwrap();
    let data = gbuffer::read(&mut stage.context, &shot).unwrap();
    std::fs::write(&file, gbuffer_file::encode(&data, &file).unwrap()).unwrap();

    let here = image_hashes(&gpu, &file);
    assert_eq!(image_hashes(&gpu, &file), here, "twice in a process");
    // Mesa reads these variables and other drivers do not: the threads of the rasteriser (0: the caller's thread), and
    // the bits of its vectors, which decide the size of subgroups.
    let expected = expected_failures("threads", &gpu);
    for threads in ["0", "5"] {
        let (hashes, _) = in_a_process(&file, &[("LP_NUM_THREADS", threads)]).expect("no crash");
        for (method, hash) in &here {
            let is_known = expected.contains(&format!("{method} LP_NUM_THREADS={threads}"));
            assert!(is_known || hashes[method] == *hash, "{method}: another image on {threads} threads");
        }
    }
    match in_a_process(&file, &[("LP_NATIVE_VECTOR_WIDTH", "128")]) {
        Some((hashes, subgroup)) => {
            println!("subgroups of {} and {subgroup}", gpu.subgroup_size());
            assert_eq!(hashes, here, "subgroups of {subgroup}");
        }
        None => {
            let expected = expected_failures("subgroup", &gpu);
            assert!(expected.iter().any(|id| id == "LP_NATIVE_VECTOR_WIDTH=128"), "a crash that nobody expects");
            println!("only subgroups of {}: the driver crashes with others", gpu.subgroup_size());
        }
    }
}

/// No shader names an extension of subgroup operations. Without one, a shader cannot depend on the size of subgroups.
#[test]
fn no_shader_asks_for_subgroups() {
    let mut folders = vec![repository().join("shaders-glsl")];
    let mut read = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_none_or(|e| e != "md") {
                let text = std::fs::read_to_string(&path).unwrap();
                assert!(!text.contains("GL_KHR_shader_subgroup") && !text.contains("ARB_shader_ballot"), "{path:?}");
                read += 1;
            }
        }
    }
    assert!(read > 40, "{read} files");
}
