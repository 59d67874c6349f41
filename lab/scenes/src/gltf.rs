//! Loads scenes from glTF 2.0, as `.gltf` with its files or as `.glb`.
//!
//! [`load`] reads a file into a [`Scene`]. The submodules do the work: `data` finds buffers and images and reads accessors,
//! `geometry` makes triangles, `nodes` walks the tree of nodes for meshes, cameras, lights and motions. `materials` turns
//! metallic-roughness into reflectivity and ϱ ([`material_terms`](super::material_terms)) and bakes the images of a material.
//!
//! The crate `gltf` parses and checks the JSON; this module reads and checks the data that its accessors point to.

mod compression;
mod data;
mod document;
mod geometry;
mod materials;
mod nodes;
mod typed;
mod vertices;

use super::{LoadOptions, Probe, Scene};
use data::Data;
use glam::DVec3;
use ssct_geometry::{bounded, viewpoint};
use ssct_ground::Result;
use std::collections::HashSet;
use std::path::Path;

/// Greatest size of a file that is read, in bytes, which is the greatest that the header of a `.glb` can state.
pub const MAX_FILE_BYTES: u64 = u32::MAX as u64;

/// Greatest number of triangles that a file may place in the world, counting each mesh as often as nodes place it. While
/// triangles are sorted into meshes, each takes 144 bytes.
pub const MAX_TRIANGLES: usize = 20_000_000;

/// Extensions that are read.
const READ: [&str; 12] = [
    nodes::INSTANCING,
    compression::NAMES[0],
    document::WEBP,
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    compression::NAMES[1],
    nodes::VISIBILITY,
    "KHR_texture_transform",
];

/// Whether a path has the extension of a glTF file.
pub fn is_named(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gltf") || e.eq_ignore_ascii_case("glb"))
}

/// Loads a glTF file as a scene, named after the file.
///
/// - The file's default scene is loaded, else its first. Nodes are placed by their transforms; glTF is right-handed, so z is
///   negated. A mesh that several nodes place is in the scene several times, and so are the copies of
///   `EXT_mesh_gpu_instancing`. Nodes that `KHR_node_visibility` hides are left out.
/// - Reflectivity is the luminance of the reflection at normal incidence, from `KHR_materials_ior`, `KHR_materials_specular`
///   and the metallic factor; albedo is the base colour times 1 − metalness. Roughness becomes ϱ by the width of the lobe
///   ([`roughness_of_perceptual`](super::material_terms::roughness_of_perceptual)). Images of base colour, metallic-roughness,
///   normals and emission are used; images of occlusion are not.
/// - Emission, and `KHR_materials_unlit`, are lit colour that no light changes; brighter than 1 counts as 1.
/// - `MASK` cuts holes at its cutoff; `BLEND` is cut at one half. Materials that are not double-sided are not seen
///   from behind.
/// - Cameras become views, lights become lights of one exposure: the brightest gives 1 at the scene's centre. Without a
///   camera the scene gets the default view, without a light the default light, and always one probe.
/// - Animations of nodes become motions ([`Scene::motions`]); at rest, the scene is placed by the transforms of its nodes.
///   Animations of skins and of morph targets are not played.
/// - Tangents come from the file or else from MikkTSpace. `KHR_texture_transform` is applied to the coordinates.
///
/// Lights and cameras that were chosen for a file without them, and the exposure of its lights, are noted in [`Scene::notes`].
///
/// Each unsupported feature adds one sentence to [`Scene::warnings`], however often it occurs.
///
/// # Errors
/// [`Error::Io`](ssct_ground::Error::Io) if the file cannot be read. [`Error::Malformed`](ssct_ground::Error::Malformed) for
/// buffers that cannot be read, for files that are not glTF 2.0, and for extensions that the file requires and this loader
/// lacks. [`Error::Malformed`](ssct_ground::Error::Malformed) also for accessors that leave their buffers, positions that are
/// not finite, files without a triangle, more than [`MAX_TRIANGLES`] and files larger than [`MAX_FILE_BYTES`].
/// [`Error::Usage`](ssct_ground::Error::Usage) for options out of range.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    let mut scene = load_plain(path, options, None)?;
    if let Some(chosen) = chosen(&scene) {
        scene.notes.push(format!("{}: {chosen}", path.display()));
    }
    if scene.views.is_empty() {
        scene.views = vec![viewpoint::default_view(&scene)];
    }
    if scene.lights.is_empty() {
        scene.lights = vec![viewpoint::default_light()];
    }
    scene.probes = vec![Probe::in_the_middle_of(scene.bounds())];
    Ok(scene)
}

/// Says which lights and views a file without lights or cameras will get; `None` for a file with both.
fn chosen(scene: &Scene) -> Option<String> {
    let light = "one directional light shines from above";
    let view = "the view shows all of the scene";
    match (scene.lights.is_empty(), scene.views.is_empty()) {
        (true, true) => Some(format!("it has neither lights nor cameras; {light}, and {view}")),
        (true, false) => Some(format!("it has no lights; {light}")),
        (false, true) => Some(format!("it has no cameras; {view}")),
        (false, false) => None,
    }
}

/// Loads a scene as [`load`] does, with the views and lights of the file alone, and without a probe. `origin` is subtracted
/// from every place, in metres; without it, a scene that is too far from the origin for its size is moved to its centre.
pub(super) fn load_plain(path: &Path, options: &LoadOptions, origin: Option<DVec3>) -> Result<Scene> {
    options.check()?;
    let bytes = bounded::read(path, "a glTF file", MAX_FILE_BYTES)?;
    let mut notes = Notes::new(path);
    let (document, animations, blob) = document::read(path, &bytes, &mut notes)?;
    drop(bytes);
    let data = Data::new(path, &document, blob)?;
    let name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let mut scene = Scene { name, ..Scene::default() };
    let used = nodes::place((&data, &animations), (options.scale, origin), &mut scene, &mut notes)?;
    materials::attach(&data, &used, options.texture_side, &mut scene, &mut notes);
    scene.lens = viewpoint::lens(scene.bounds());
    scene.warnings = notes.sentences;
    Ok(scene)
}

/// The sentences about unsupported features, each once.
#[derive(Clone)]
struct Notes {
    /// The path of the file, as every sentence begins.
    file: String,
    /// The kinds of sentences that were added.
    kinds: HashSet<String>,
    sentences: Vec<String>,
}

impl Notes {
    /// No sentences yet about the file at `path`.
    fn new(path: &Path) -> Self {
        Self { file: path.display().to_string(), kinds: HashSet::new(), sentences: Vec::new() }
    }

    /// A sentence about the file, with the path of the file before it.
    fn about(&self, sentence: &str) -> String {
        format!("{}: {sentence}", self.file)
    }

    /// Adds a sentence, unless one of its kind was added before.
    fn add(&mut self, kind: &str, sentence: String) {
        if self.kinds.insert(kind.to_owned()) {
            self.sentences.push(self.about(&sentence));
        }
    }
}
