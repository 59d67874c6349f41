//! The loaders as functions of bytes, for fuzzing. Each function returns true if the bytes were loaded. It panics if an
//! error names no file, or if loaded data are invalid.

use exr::meta::MetaData;
use glam::Vec3;
use ssct_geometry::{pattern, texture};
use ssct_ground::{Error, Result};
use ssct_lab::custom;
use ssct_lab::report::{library, run_folder};
use ssct_lab::study::engine;
use ssct_lab::study::error::ErrorRecord;
use ssct_lab::study::merge::{ResultKind, merge};
use ssct_lab::study::precision::PrecisionRecord;
use ssct_lab::study::timing::TimeRow;
use ssct_scenes::gbuffer_map::GBufferMap;
use ssct_scenes::{Camera, CameraPath, Encoding, FieldOfView, GBufferData, Lens, LoadOptions, Scene, Surface};
use ssct_scenes::{gbuffer_file, gltf, obj, path, scene_file};
use std::cell::OnceCell;
use std::path::Path;
use tempfile::TempDir;

/// Loads an input, and returns true if that succeeded.
pub type Entry = fn(&[u8]) -> bool;

/// Every entry with its name, which is also the name of its fuzz target and of its folder of inputs.
pub const ENTRIES: [(&str, Entry); 10] = [
    ("obj", obj),
    ("gltf", gltf),
    ("texture", texture),
    ("gbuffer", gbuffer),
    ("gbuffer_map", gbuffer_map),
    ("scene", scene),
    ("camera_path", camera_path),
    ("method", method),
    ("includes", includes),
    ("run", run),
];

/// Loads an OBJ file. The input is this file, a byte 0 and the MTL file `a.mtl`. The folder also has the images
/// `x.png`, which can be a normal map, and `y.tga`.
pub fn obj(data: &[u8]) -> bool {
    let mut parts = data.splitn(2, |byte| *byte == 0);
    let (obj_text, mtl_text) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
    // Inputs that name a generated image are skipped, since generating it takes half a second and does not test the
    // loader.
    if String::from_utf8_lossy(mtl_text).lines().any(|line| pattern::named(line).is_some()) {
        return false;
    }
    in_folder(|folder| {
        write(folder, "a.obj", obj_text);
        write(folder, "a.mtl", mtl_text);
        check_result(obj::load(&[folder.join("a.obj").into()], &obj::ObjOptions::default()), assert_sound_scene)
    })
}

/// Loads a glTF file, which may be text or binary. The folder also has the buffer `b.bin`, and the images `x.png` and
/// `y.tga`.
pub fn gltf(data: &[u8]) -> bool {
    let name = if data.starts_with(b"glTF") { "a.glb" } else { "a.gltf" };
    in_folder(|folder| {
        write(folder, name, data);
        check_result(gltf::load(&folder.join(name), &LoadOptions::default()), assert_sound_scene)
    })
}

/// Loads a scene file. The folder also has `m.obj` with the materials `m` and `n`, and the images `x.png` and `y.tga`.
pub fn scene(data: &[u8]) -> bool {
    in_folder(|folder| {
        write(folder, "a.scene.toml", data);
        check_result(scene_file::load(&folder.join("a.scene.toml"), &LoadOptions::default()), assert_sound_scene)
    })
}

/// Loads a file of a camera path.
pub fn camera_path(data: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(data) else { return false };
    check_result(path::parse(text, Path::new("a.toml")), assert_sound_path)
}

/// Loads an image, and converts it for a use: as it is, as a mask, as a reflectivity map or as a normal map. The first
/// byte of the input chooses the use (bits 2 and 3) and the extension of the file's name (bits 0 and 1). The extension
/// decides the format if the content does not. The upper four bits give the tilt of a normal map.
pub fn texture(data: &[u8]) -> bool {
    let Some((&choice, bytes)) = data.split_first() else { return false };
    let name = ["a.tga", "a.png", "a.jpg", "a.bmp"][usize::from(choice & 3)];
    let decoded = texture::from_bytes(bytes, Path::new(name), Encoding::Srgb);
    check_result(decoded, |image| {
        assert!(image.width > 0 && image.height > 0);
        let converted = match choice >> 2 & 3 {
            0 => image.clone(),
            1 => texture::into_mask(image.clone()),
            2 => texture::into_reflectivity(image.clone()),
            _ => texture::into_normal_map(image.clone(), f32::from(choice >> 4) - 8.0),
        };
        assert_eq!((converted.width, converted.height), (image.width, image.height));
        assert_eq!(converted.rgba.len() as u64, 4 * u64::from(image.width) * u64::from(image.height));
    })
}

/// Loads a G-buffer from an OpenEXR file.
pub fn gbuffer(data: &[u8]) -> bool {
    check_result(gbuffer_file::decode(data, Path::new("a.exr")), assert_sound_gbuffer)
}

/// Loads a G-buffer by a map. The input is the map, a byte 0 and the main file `a.exr`. Without the byte 0, the main
/// file is [`frame`]. The folder also has `x.png`, which has the size of [`frame`], and `m.exr`, which is [`frame`].
pub fn gbuffer_map(data: &[u8]) -> bool {
    /// Greatest width and height in pixels. Larger images take more memory than an input may take.
    const SIDE: usize = 256;
    let mut parts = data.splitn(2, |byte| *byte == 0);
    let (text, image) = (parts.next().unwrap_or_default(), parts.next());
    let Ok(text) = std::str::from_utf8(text) else { return false };
    let headers = image.and_then(|image| MetaData::read_from_buffered(image, false).ok());
    let is_large =
        |meta: MetaData| meta.headers.iter().any(|header| header.layer_size.0 > SIDE || header.layer_size.1 > SIDE);
    if headers.is_some_and(is_large) {
        return false;
    }
    in_folder(|folder| {
        write(folder, "a.exr", &image.map_or_else(frame, <[u8]>::to_vec));
        let gbuffer = GBufferMap::parse(text, Path::new("a.toml")).and_then(|map| map.read(&folder.join("a.exr")));
        check_result(gbuffer, assert_sound_gbuffer)
    })
}

/// Checks a method from a folder. The input is its manifest, a byte 0, its shader `a.frag`, another byte 0 and its
/// shader `a.comp`. The shaders are compiled, reflected and compared with the manifest, but not run.
pub fn method(data: &[u8]) -> bool {
    let mut parts = data.splitn(3, |byte| *byte == 0);
    let [manifest, fragment, compute] = [(); 3].map(|()| parts.next().unwrap_or_default());
    in_folder(|folder| {
        write(folder, custom::MANIFEST, manifest);
        write(folder, "a.frag", fragment);
        write(folder, "a.comp", compute);
        match custom::check(folder) {
            // A manifest may name any file as a shader, and the error then names this file.
            Err(Error::Io { .. }) => false,
            result => check_result(result, |()| ()),
        }
    })
}

/// Checks a method of one fragment shader. The input is the shader `a.frag` and the files `b.glsl` and `c.glsl`, each
/// after a byte 0. All three files may include `b.glsl` and `c.glsl`.
pub fn includes(data: &[u8]) -> bool {
    const MANIFEST: &str = "name = \"a\"\nsummary = \"a\"\n[image.result]\nformat = \"rgba16f\"\n[[pass]]\nname = \"one\"\n\
        shader = \"a.frag\"\ntargets = [\"result\"]\n[output]\nreflection = \"result\"\n";
    let mut parts = data.splitn(3, |byte| *byte == 0);
    let files = [(); 3].map(|()| parts.next().unwrap_or_default());
    in_folder(|folder| {
        write(folder, custom::MANIFEST, MANIFEST.as_bytes());
        for (name, text) in ["a.frag", "b.glsl", "c.glsl"].into_iter().zip(files) {
            write(folder, name, text);
        }
        // An include may name any file, and the error then names this file, so that the error is not checked.
        custom::check(folder).is_ok()
    })
}

/// Reads the folder of a run. The input is its list of cells, a byte 0, its journal, another byte 0 and its records.
/// The function reads the folder as `ssct merge` and `ssct index` do, and as a run of three studies: error, precision
/// and time.
pub fn run(data: &[u8]) -> bool {
    let mut parts = data.splitn(3, |byte| *byte == 0);
    let files = [(); 3].map(|()| parts.next().unwrap_or_default());
    in_folder(|folder| {
        let folder = folder.join("run");
        std::fs::create_dir_all(&folder).expect("a folder");
        for (name, text) in ["cells.json", "journal.jsonl", "error.json"].into_iter().zip(files) {
            write(&folder, name, text);
        }
        let found = library::scan(&folder).expect("the folder can be read");
        assert!(found.runs.len() + found.unreadable.len() + found.without_records.len() <= 1);
        let input = match run_folder::read(&folder) {
            Ok(input) => input,
            Err(error) => {
                let is_malformed =
                    matches!(error, ssct_lab::error::Error::Ssct(ssct::Error::File(Error::Malformed { .. })));
                assert!(is_malformed && error.to_string().contains("run"), "{error}");
                return false;
            }
        };
        // The journal is of one study at most, so that a check may refuse it, but must not panic.
        let is_sound = engine::check::<ErrorRecord>(&input).is_ok();
        let _ = (engine::check::<PrecisionRecord>(&input), engine::check::<TimeRow>(&input));
        let rows = engine::rows::<ErrorRecord>(&input.cells, &input.journal);
        assert!(!is_sound || rows.iter().all(|row| row.head.width > 0 && row.head.height > 0));
        let kind = ResultKind { read: |_, result, journal| journal.value(&result.key).cloned(), is_time: |_| false };
        // Merging fails if two results of a cell differ in their figures.
        let Ok(merged) = merge(&[input], kind) else { return false };
        assert!(merged.results.len() <= merged.lines.len() * merged.cells.cells.len().max(1));
        is_sound && !rows.is_empty()
    })
}

/// Panics unless a G-buffer has a valid depth, normal, colour, roughness and reflectivity for each pixel, and a valid
/// camera.
fn assert_sound_gbuffer(gbuffer: &GBufferData) {
    let GBufferData { depth, normal, color, roughness, reflectivity, surface, .. } = gbuffer;
    let pixels = gbuffer.width as usize * gbuffer.height as usize;
    assert!(pixels > 0);
    assert_eq!([depth.len(), normal.len(), color.len(), roughness.len(), reflectivity.len()], [pixels; 5]);
    assert_eq!(surface.len(), pixels);
    let in_unit_range = |values: &[f32]| values.iter().all(|value| (0.0..=1.0).contains(value));
    assert!(in_unit_range(depth) && in_unit_range(roughness) && in_unit_range(reflectivity));
    assert!(color.iter().all(|c| c.is_finite() && c.min_element() >= 0.0));
    assert!(normal.iter().all(|n| n.is_finite()));
    assert_sound_camera(&gbuffer.camera);
}

/// Returns an OpenEXR file with a G-buffer of 4×4 pixels in the program's own conventions.
pub fn frame() -> Vec<u8> {
    let pixels = 16;
    let gbuffer = GBufferData {
        width: 4,
        height: 4,
        camera: Camera::new(Vec3::ONE, Vec3::ZERO, Lens::perspective(1.2, 0.25, 50.0), 1.0),
        depth: (0..pixels).map(|i| i as f32 / 16.0).collect(),
        normal: vec![Vec3::new(0.0, 0.6, -0.8); pixels],
        reflectivity: vec![0.25; pixels],
        roughness: vec![0.1; pixels],
        color: (0..pixels).map(|i| Vec3::splat(i as f32 / 7.0)).collect(),
        surface: vec![Surface::Lit; pixels],
    };
    gbuffer_file::encode(&gbuffer, Path::new("a.exr")).expect("encodes")
}

/// Checks the result of a loader. Returns true if it is a value, which `assert_sound` checks, and false if it is an
/// error. Panics if the error names none of the files that an input can have.
fn check_result<T>(result: Result<T>, assert_sound: impl Fn(&T)) -> bool {
    match result {
        Ok(value) => {
            assert_sound(&value);
            true
        }
        Err(error) => {
            assert!(matches!(error, Error::Malformed { .. } | Error::Io { .. }), "{error}");
            let text = error.to_string();
            assert!(
                ["a.", "m.", "b.bin", "x.png", "y.tga", custom::MANIFEST].iter().any(|name| text.contains(name)),
                "{text}"
            );
            false
        }
    }
}

/// Panics unless all indices of a scene are in range, and all its numbers are finite and in their ranges.
fn assert_sound_scene(scene: &Scene) {
    assert!(!scene.views.is_empty() && !scene.lights.is_empty() && !scene.probes.is_empty());
    for mesh in &scene.meshes {
        assert!(mesh.material < scene.materials.len() && !mesh.indices.is_empty());
        assert!(mesh.indices.iter().all(|i| (*i as usize) < mesh.vertices.len()));
        for vertex in &mesh.vertices {
            let numbers = [&vertex.position[..], &vertex.normal, &vertex.uv, &vertex.tangent].concat();
            assert!(numbers.iter().all(|number| number.is_finite()), "{vertex:?}");
            assert!((Vec3::from(vertex.normal).length() - 1.0).abs() < 1e-3, "{vertex:?}");
        }
    }
    for material in &scene.materials {
        let maps = [material.albedo_map, material.normal_map, material.alpha_mask, material.reflectivity_map];
        let maps = maps.into_iter().chain([material.roughness_map]);
        assert!(maps.flatten().all(|i| i < scene.textures.len()));
        let factors = [material.reflectivity, material.roughness, material.normal_deviation];
        assert!(
            factors.iter().all(|factor| (0.0..=1.0).contains(factor)) && material.albedo.is_finite(),
            "{material:?}"
        );
    }
    assert!(scene.impostors.iter().all(|i| i.texture < scene.textures.len()));
    for view in &scene.views {
        assert_sound_camera(&Camera::new(view.eye, view.look_at, view.lens.unwrap_or(scene.lens), 1.5));
    }
    for capture in &scene.captures {
        assert!(capture.position.is_finite() && capture.near_m > 0.0 && capture.near_m.is_finite(), "{capture:?}");
        assert_eq!(capture.resolution, scene.captures[0].resolution);
    }
    scene.paths.iter().for_each(assert_sound_path);
}

/// Panics unless a path has finite places, and is read back as the same path after it was written.
fn assert_sound_path(path: &CameraPath) {
    for step in 0..=8 {
        let (eye, look_at) = path.eye_and_look_at(step as f32 / 8.0);
        assert!(eye.is_finite() && look_at.is_finite(), "{step}: {eye} {look_at}");
    }
    let read_back = path::parse(&path::to_toml(path), Path::new("a.toml"));
    assert_eq!(&read_back.expect("what is written can be read"), path);
}

/// Panics unless the field of view and the planes of a camera are in range, and its matrices are finite.
fn assert_sound_camera(camera: &Camera) {
    let Lens { near_m, far_m, .. } = camera.lens;
    let has_valid_opening = match camera.lens.opening {
        FieldOfView::Angle(fov) => fov > 0.0 && near_m > 0.0,
        FieldOfView::Height(height) => height > 0.0 && near_m >= 0.0,
    };
    assert!(has_valid_opening && far_m > near_m && far_m.is_finite());
    assert!(camera.world_to_view.is_finite(), "{camera:?}");
    assert!(camera.view_to_clip_reversed().is_finite(), "{camera:?}");
}

/// A small OBJ file with every kind of statement that the loader reads.
pub const OBJ: &[u8] = b"mtllib a.mtl\ng left\nusemtl m\ns 1\nv 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nv -1 0.5 2\n\
    vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nvn 0.6 0 0.8\nf 1/1/1 2/2/2 3/3/1 4/1/2\nf 1 2 5\nf -1 -2 -3 -4 -5\n\
    usemtl n\ns off\nf 1//1 3//2 5//1 \\\n 2//2\n";

/// The materials of [`OBJ`].
pub const MTL: &[u8] = b"newmtl m\nKd 0.5 0.5 0.5\nKs 1 1 1\nNs 10\nmap_Kd x.png\nbump -bm 0.5 x.png\nmap_d y.tga\n\
    newmtl n\nPr 0.5\nmap_Ks -s 1 1 y.tga\nd 1\n";

/// Returns the buffer of a square for glTF files: positions, normals, texture coordinates and indices, in bytes.
pub fn square() -> Vec<u8> {
    let positions = [0.0_f32, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 1.0, 0.0, 0.0, 1.0, 0.0];
    let normals = [0.0_f32, 0.0, 1.0].repeat(4);
    let uvs = [0.0_f32, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
    let floats = positions.iter().chain(&normals).chain(&uvs).flat_map(|number| number.to_le_bytes());
    floats.chain([0_u16, 1, 2, 0, 2, 3].into_iter().flat_map(u16::to_le_bytes)).collect()
}

thread_local! {
    static FOLDER: OnceCell<TempDir> = const { OnceCell::new() };
}

/// Calls `run` with a temporary folder of the thread, which lies in memory if the system supports that. The folder has
/// the images and the files that an input may name.
fn in_folder(run: impl FnOnce(&Path) -> bool) -> bool {
    FOLDER.with(|cell| {
        let folder = cell.get_or_init(|| {
            let memory = Path::new("/dev/shm");
            let created = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
            let folder = created.expect("a folder");
            let texel = |x: u32, y: u32| image::Rgb([x as u8 * 40 + 60, y as u8 * 40 + 60, 240]);
            for name in ["x.png", "y.tga"] {
                image::RgbImage::from_fn(4, 4, texel).save(folder.path().join(name)).expect("an image");
            }
            let object = String::from_utf8_lossy(OBJ).replace("a.mtl", "m.mtl");
            write(folder.path(), "m.obj", object.as_bytes());
            write(folder.path(), "m.mtl", MTL);
            write(folder.path(), "b.bin", &square());
            write(folder.path(), "m.exr", &frame());
            folder
        });
        run(folder.path())
    })
}

/// Writes a file into a folder.
fn write(folder: &Path, name: &str, bytes: &[u8]) {
    std::fs::write(folder.join(name), bytes).expect("a file");
}
