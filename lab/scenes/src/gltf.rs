//! Loads scenes from glTF 2.0, as `.gltf` with its files or as `.glb`.
//!
//! [`load`] reads a file into a [`Scene`]. The submodule `data` finds buffers and images and reads accessors,
//! `geometry` makes triangles, and `nodes` walks through the tree of nodes for meshes, cameras, lights and motions.
//! `materials` converts metallic-roughness to reflectivity and ϱ ([`material_terms`](super::material_terms)) and
//! computes the images of a material.
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

/// Greatest size of a file that is read, in bytes; the header of a `.glb` cannot state a greater one.
pub const MAX_FILE_BYTES: u64 = u32::MAX as u64;

/// Greatest number of triangles that a file may place in the world; each mesh counts as often as nodes place it. While
/// triangles are sorted into meshes, each takes 144 bytes.
pub const MAX_TRIANGLES: usize = 20_000_000;

/// Extensions that are read.
const READ_EXTENSIONS: [&str; 12] = [
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

/// Returns true if a path ends in `.gltf` or `.glb`, in any case.
pub fn is_named(path: &Path) -> bool {
    let is_gltf =
        |extension: &std::ffi::OsStr| extension.eq_ignore_ascii_case("gltf") || extension.eq_ignore_ascii_case("glb");
    path.extension().is_some_and(is_gltf)
}

/// Loads a glTF file as a scene, named after the file.
///
/// - The file's default scene is loaded, or its first if it states none. Nodes are placed by their transforms; glTF is
///   right-handed, so z is negated. A mesh is in the scene once for each node that places it, and for each copy of
///   `EXT_mesh_gpu_instancing`. Nodes that `KHR_node_visibility` hides are left out.
/// - Reflectivity is the luminance of the reflection at normal incidence, from `KHR_materials_ior`,
///   `KHR_materials_specular` and the metallic factor; albedo is the base colour times 1 − metalness. Roughness becomes
///   ϱ by the width of the lobe ([`roughness_of_perceptual`](super::material_terms::roughness_of_perceptual)). Images
///   of base colour, metallic-roughness, normals and emission are used; images of occlusion are not.
/// - Emission, and the colour of `KHR_materials_unlit`, are lit colour that no light changes; values above 1 count as
///   1.
/// - `MASK` makes holes where alpha is below its cutoff; `BLEND` makes holes below one half. Materials that are not
///   double-sided are not seen from behind.
/// - Cameras become views. Lights are scaled by one exposure, with which the brightest gives 1 at the scene's centre.
///   Without a camera the scene gets the default view, and without a light the default light. It always gets one probe.
/// - Animations of nodes become motions ([`Scene::motions`]); at rest, the scene is placed by the transforms of its
///   nodes. Animations of skins, morph targets, cameras and lights are not played.
/// - Tangents come from the file or, if it has none, from MikkTSpace. `KHR_texture_transform` is applied to the
///   coordinates.
///
/// [`Scene::notes`] says which lights and views were chosen for a file without them, and the exposure of its lights.
///
/// Each unsupported feature adds one sentence to [`Scene::warnings`], however often it occurs.
///
/// # Errors
/// [`Error::Io`](ssct_ground::Error::Io) if the file cannot be read.
/// [`Error::Malformed`](ssct_ground::Error::Malformed) for buffers that cannot be read, for files that are not glTF
/// 2.0, and for extensions that the file requires and this loader lacks. This error is also returned for accessors that
/// leave their buffers, positions that are not finite, files without a triangle, more than [`MAX_TRIANGLES`] and files
/// larger than [`MAX_FILE_BYTES`]. [`Error::Usage`](ssct_ground::Error::Usage) for options out of range.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    let mut scene = load_plain(path, options, None)?;
    if let Some(defaults) = chosen_defaults(&scene) {
        scene.notes.push(format!("{}: {defaults}", path.display()));
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

/// Says in words which light or view is chosen for a file without lights or cameras; `None` for a file with both.
fn chosen_defaults(scene: &Scene) -> Option<String> {
    let light = "one directional light shines from above";
    let view = "the view shows all of the scene";
    match (scene.lights.is_empty(), scene.views.is_empty()) {
        (true, true) => Some(format!("it has neither lights nor cameras; {light}, and {view}")),
        (true, false) => Some(format!("it has no lights; {light}")),
        (false, true) => Some(format!("it has no cameras; {view}")),
        (false, false) => None,
    }
}

/// Loads a scene like [`load`], but with only the views and lights of the file, and without a probe. `origin`, in
/// metres, is subtracted from every position. With `None`, a scene that is too far from the origin for its size is
/// moved to its centre.
pub(super) fn load_plain(path: &Path, options: &LoadOptions, origin: Option<DVec3>) -> Result<Scene> {
    options.check()?;
    let bytes = bounded::read(path, "a glTF file", MAX_FILE_BYTES)?;
    let mut notes = Notes::new(path);
    let (document, animations, binary_chunk) = document::read(path, &bytes, &mut notes)?;
    drop(bytes);
    let data = Data::new(path, &document, binary_chunk)?;
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let mut scene = Scene { name, ..Scene::default() };
    let used_materials = nodes::place(&data, &animations, options.scale, origin, &mut scene, &mut notes)?;
    materials::attach(&data, &used_materials, options.texture_side, &mut scene, &mut notes);
    scene.lens = viewpoint::lens(scene.bounds());
    scene.warnings = notes.sentences;
    Ok(scene)
}

/// Sentences about unsupported features, at most one of each kind.
#[derive(Clone)]
struct Notes {
    /// The path of the file, with which every sentence begins.
    file: String,
    /// The kinds of sentences that were added.
    kinds: HashSet<String>,
    sentences: Vec<String>,
}

impl Notes {
    /// Makes an empty list of sentences about the file at `path`.
    fn new(path: &Path) -> Self {
        Self { file: path.display().to_string(), kinds: HashSet::new(), sentences: Vec::new() }
    }

    /// Returns a sentence with the path of the file in front.
    fn about(&self, sentence: &str) -> String {
        format!("{}: {sentence}", self.file)
    }

    /// Adds a sentence, unless one of the same kind was added before. `kind` is a key that no message shows.
    fn add(&mut self, kind: &str, sentence: String) {
        if self.kinds.insert(kind.to_owned()) {
            self.sentences.push(self.about(&sentence));
        }
    }
}
