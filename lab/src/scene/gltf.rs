//! Loads scenes from glTF 2.0, as `.gltf` with its files or as `.glb`.
//!
//! [`load`] reads a file into a [`Scene`]. The submodules are the stages: `data` finds buffers and images and reads
//! accessors, `geometry` makes triangles, `nodes` walks the tree of nodes for meshes, cameras and lights, `materials`
//! turns metallic-roughness into reflectivity and ϱ ([`material_terms`](super::material_terms)) and bakes the images of a
//! material.
//!
//! The crate `gltf` parses and checks the JSON; what its accessors point to is read and checked here.

mod data;
mod geometry;
mod materials;
mod nodes;

use super::{LoadOptions, Probe, Scene, bounded, viewpoint};
use crate::error::{Error, Result};
use data::Data;
use gltf::json::validation::Checked;
use gltf::{Document, Gltf, Semantic};
use std::path::Path;

/// The largest file that is read, in bytes: what the header of a `.glb` can say.
pub const MAX_FILE_BYTES: u64 = u32::MAX as u64;

/// The most triangles that a file may place in the world, each mesh counted as often as it stands there. While they are
/// sorted into meshes, a triangle takes 144 bytes.
pub const MAX_TRIANGLES: usize = 20_000_000;

/// The attribute of positions.
const POSITION: Checked<Semantic> = Checked::Valid(Semantic::Positions);

/// Extensions that are read.
const READ: [&str; 6] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Whether a path has the extension of a glTF file.
pub fn is_named(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gltf") || e.eq_ignore_ascii_case("glb"))
}

/// Loads a glTF file as a scene, named after the file.
///
/// - The file's default scene is loaded, else its first. Nodes are placed by their transforms; glTF is right-handed, so z
///   is negated. A mesh that several nodes place stands there several times.
/// - Reflectivity is the luminance of the reflection at normal incidence, from `KHR_materials_ior` and the metallic
///   factor; albedo is what a metal leaves of the base colour. Roughness becomes ϱ by the width of the lobe
///   ([`roughness_of_perceptual`](super::material_terms::roughness_of_perceptual)). Images of base colour,
///   metallic-roughness, normals and emission count; those of occlusion do not.
/// - Emission, and `KHR_materials_unlit`, are lit colour that no light changes; brighter than 1 counts as 1.
/// - `MASK` cuts holes at its cutoff; `BLEND` is cut at one half. Materials that are not double-sided are not seen
///   from behind.
/// - Cameras become views, lights become lights of one exposure: the brightest gives 1 at the scene's centre. Without a
///   camera the scene gets the default view, without a light the default light, and always one probe.
/// - Tangents come from the file or else from MikkTSpace. `KHR_texture_transform` is applied to the coordinates.
///
/// What is not supported adds one sentence to [`Scene::warnings`], however often it occurs.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`] for buffers that cannot, for what is not glTF 2.0, for extensions that the file
/// requires and this loader lacks, for accessors that leave their buffers, numbers that are not finite, files without a
/// triangle, more than [`MAX_TRIANGLES`] and files larger than [`MAX_FILE_BYTES`]. [`Error::Usage`] for options out of range.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    let mut scene = load_plain(path, options)?;
    if scene.views.is_empty() {
        scene.views = vec![viewpoint::default_view(&scene)];
    }
    if scene.lights.is_empty() {
        scene.lights = vec![viewpoint::default_light()];
    }
    scene.probes = vec![Probe::in_the_middle_of(scene.bounds())];
    Ok(scene)
}

/// Loads a scene as [`load`] does, with the views and lights of the file alone, and without a probe.
pub(super) fn load_plain(path: &Path, options: &LoadOptions) -> Result<Scene> {
    options.check()?;
    let bytes = bounded::read(path, "a glTF file", MAX_FILE_BYTES)?;
    let mut notes = Notes::new(path);
    let (document, blob) = parse(path, &bytes, &mut notes)?;
    drop(bytes);
    let data = Data::new(path, &document, blob)?;
    let name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let mut scene = Scene { name, ..Scene::default() };
    let used = nodes::place(&data, options.scale, &mut scene, &mut notes)?;
    materials::attach(&data, &used, options.texture_side, &mut scene, &mut notes)?;
    scene.lens = viewpoint::lens(scene.bounds());
    scene.warnings = notes.sentences;
    Ok(scene)
}

/// The checked document and the binary chunk.
fn parse(path: &Path, bytes: &[u8], notes: &mut Notes) -> Result<(Document, Option<Vec<u8>>)> {
    let malformed = |e: gltf::Error| Error::malformed(path, None, format!("is not glTF 2.0: {e}"));
    // The crate takes the header's length from what the file states as its own.
    if let [b'g', b'l', b'T', b'F', _, _, _, _, a, b, c, d, ..] = *bytes {
        let stated = u32::from_le_bytes([a, b, c, d]);
        if stated < 12 {
            let message =
                format!("is not glTF 2.0: it states a length of {stated} bytes, which its header alone exceeds");
            return Err(Error::malformed(path, None, message));
        }
    }
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(malformed)?;
    let mut json = document.into_json();
    if !json.asset.version.starts_with("2.") {
        let message = format!("is glTF {}; version 2 is supported", json.asset.version);
        return Err(Error::malformed(path, None, message));
    }
    let known = |name: &String| READ.contains(&name.as_str());
    if let Some(name) = json.extensions_required.iter().find(|name| !known(name)) {
        let message = format!("requires the extension {name}, which is not supported; {}", remedy(name));
        return Err(Error::malformed(path, None, message));
    }
    // What is read here, the crate need not know.
    json.extensions_required.clear();
    for name in json.extensions_used.iter().filter(|name| !known(name)) {
        notes.add(name, format!("the extension {name} is not supported and was ignored"));
    }
    if !json.animations.is_empty() {
        notes.add("animations", "animations are not played".to_owned());
    }
    // The crate's own check of positions reads the accessor before it knows that there is one.
    let positions = json.meshes.iter().flat_map(|m| &m.primitives).filter_map(|p| p.attributes.get(&POSITION));
    if positions.map(|index| index.value()).any(|index| index >= json.accessors.len()) {
        return Err(Error::malformed(path, None, "is not glTF 2.0: positions are in an accessor that is not there"));
    }
    Ok((Document::from_json(json).map_err(malformed)?, blob))
}

/// What whoever has a file with this extension can do.
fn remedy(extension: &str) -> &'static str {
    match extension {
        "KHR_draco_mesh_compression" | "EXT_meshopt_compression" => "export the meshes without compression",
        "KHR_texture_basisu" => "export the images as PNG or JPEG instead of KTX2",
        "EXT_texture_webp" | "EXT_texture_avif" | "MSFT_texture_dds" => "export the images as PNG or JPEG",
        _ => "export without it",
    }
}

/// The sentences about what is not supported, each once.
struct Notes {
    file: String,
    kinds: Vec<String>,
    sentences: Vec<String>,
}

impl Notes {
    fn new(path: &Path) -> Self {
        Self { file: path.display().to_string(), kinds: Vec::new(), sentences: Vec::new() }
    }

    /// Adds a sentence, unless there is one of this kind.
    fn add(&mut self, kind: &str, sentence: String) {
        if !self.kinds.iter().any(|k| k == kind) {
            self.kinds.push(kind.to_owned());
            self.sentences.push(format!("{}: {sentence}", self.file));
        }
    }
}
