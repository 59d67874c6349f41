//! Scenes from Wavefront OBJ files as they are found in the wild.
//!
//! [`load`] reads one or more OBJ files, with their MTL files and images, into a [`Scene`]. The
//! submodules are the stages: `text` checks and normalises the statements (with line numbers), tobj
//! sorts them into groups, `polygons` makes triangles with normals, `tangents` the tangent frames,
//! `assemble` welds and splits meshes; `mtl` reads materials and `images` their textures; `viewpoint`
//! looks for a place to look from.

mod assemble;
mod images;
mod mtl;
mod polygons;
mod tangents;
mod text;
mod viewpoint;

use super::{Light, Probe, Scene, Surface};
use crate::error::{Error, Result};
use glam::Vec3;
use std::path::{Path, PathBuf};

pub(super) use images::resolve;
pub(super) use viewpoint::default_view;

/// The largest OBJ file that is read, in bytes.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// Which way the z axis of the files points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Handedness {
    /// As OBJ has it: z is negated and the winding reversed on loading.
    #[default]
    Right,
    /// Already as the world has it: taken as it stands.
    Left,
}

/// How OBJ files become a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObjOptions {
    /// The files' handedness.
    pub handedness: Handedness,
    /// Metres per unit of the files, finite and > 0.
    pub scale: f32,
}

impl Default for ObjOptions {
    fn default() -> Self {
        Self { handedness: Handedness::Right, scale: 1.0 }
    }
}

/// One OBJ file of a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ObjFile {
    /// Where it lies; its MTL files and images are looked for beside it.
    pub path: PathBuf,
    /// What all its materials are to the reflections.
    pub surface: Surface,
}

impl<P: Into<PathBuf>> From<P> for ObjFile {
    fn from(path: P) -> Self {
        Self { path: path.into(), surface: Surface::Lit }
    }
}

/// Loads OBJ files as one scene, named after the first.
///
/// - Polygons are triangulated (concave ones too); triangles without area, points and lines are left
///   out; what is left out or replaced is told in [`Scene::warnings`].
/// - Missing normals: inside a smoothing group (`s 1`) the mean over the faces of that group that meet
///   in the position, weighted by their angles there; outside (`s off`, or no `s` at all, which the format defines as
///   off) the normal of the face, so that boxes stay boxes.
/// - Texture coordinates get their origin at the top left (v' = 1 − v). Tangents are MikkTSpace's;
///   without texture coordinates, any that are orthogonal to the normal.
/// - A mesh is a group's triangles of one material; large ones are split in space.
/// - Materials by MTL: `Kd`, `Ks`, `Pr` or else `Ns`, their maps, `map_d` and `bump`, by the table that
///   opens `obj/mtl.rs`. Equal names in two files stay two materials; unused materials are dropped.
/// - One view, `default`, that frames the bounds, one directional light, and one probe in the middle.
///
/// # Errors
/// [`Error::Io`] for a file that cannot be read; [`Error::Malformed`] with file and line for wrong
/// statements, numbers that are not finite, indices that are out of range, and files without any
/// triangle or beyond [`MAX_FILE_BYTES`]; [`Error::Usage`] for no files or a scale that is not > 0.
pub fn load(files: &[ObjFile], options: &ObjOptions) -> Result<Scene> {
    let mut scene = load_unlit(files, options)?;
    scene.views = vec![viewpoint::default_view(&scene)];
    scene.lights = vec![default_light()];
    scene.probes = vec![Probe::in_the_middle_of(scene.bounds())];
    Ok(scene)
}

/// As [`load`], without view, light and probe.
pub(super) fn load_unlit(files: &[ObjFile], options: &ObjOptions) -> Result<Scene> {
    let Some(first) = files.first() else {
        return Err(Error::Usage("a scene needs at least one OBJ file".into()));
    };
    if !(options.scale.is_finite() && options.scale > 0.0) {
        return Err(Error::Usage(format!("the scale must be a positive number, not {}", options.scale)));
    }
    let mut scene = Scene { name: stem(&first.path), ..Scene::default() };
    let mut sources = Vec::new();
    for file in files {
        load_file(file, options, &mut scene, &mut sources)?;
    }
    images::attach(&mut scene, sources);
    scene.lens = viewpoint::lens(scene.bounds());
    Ok(scene)
}

/// The light of a scene that has none: from above and behind the default view's left shoulder.
pub(super) fn default_light() -> Light {
    Light::Directional { direction: Vec3::new(-0.3, -1.0, 0.25).normalize(), energy: 1.0 }
}

/// Reads one file and appends its meshes and used materials, with the images that these ask for.
fn load_file(
    file: &ObjFile,
    options: &ObjOptions,
    scene: &mut Scene,
    sources: &mut Vec<images::MaterialImages>,
) -> Result<()> {
    let bytes = read_limited(&file.path)?;
    let statements = text::normalise(&file.path, &String::from_utf8_lossy(&bytes))?;
    drop(bytes);
    let names = statements.material_names.clone();
    let statements_lack_library = statements.libraries.is_empty() && names.iter().any(|n| n != text::NO_MATERIAL);
    let definitions = mtl::read_libraries(&file.path, &statements.libraries, &mut scene.warnings)?;
    let parts = polygons::build(&file.path, statements, options, &mut scene.warnings)?;

    if statements_lack_library {
        let message = "names materials but no MTL file; they are white";
        scene.warnings.push(format!("{}: {message}", file.path.display()));
    }
    let mut scene_index: Vec<Option<usize>> = vec![None; names.len()];
    for part in &parts {
        if scene_index[part.material].is_none() {
            let name = &names[part.material];
            let definition = definitions.get(name);
            if definition.is_none() && name != text::NO_MATERIAL && !definitions.is_empty() {
                scene
                    .warnings
                    .push(format!("{}: material {name} is defined in no MTL file; it is white", file.path.display()));
            }
            scene_index[part.material] = Some(scene.materials.len());
            scene.materials.push(definition.map_or_else(Default::default, mtl::Definition::material));
            if let Some(material) = scene.materials.last_mut() {
                material.name.clone_from(name);
                material.surface = file.surface;
            }
            sources.push(definition.map(mtl::Definition::images).unwrap_or_default());
        }
    }
    let material_of = |part: &polygons::Part| scene_index[part.material].unwrap_or_default();
    scene.meshes.extend(assemble::meshes(parts, material_of));
    Ok(())
}

fn read_limited(path: &Path) -> Result<Vec<u8>> {
    let length = std::fs::metadata(path).map_err(|e| Error::io("read", path, e))?.len();
    if length > MAX_FILE_BYTES {
        let message = format!("a file of {length} bytes is larger than the {MAX_FILE_BYTES} that are read");
        return Err(Error::malformed(path, None, message));
    }
    std::fs::read(path).map_err(|e| Error::io("read", path, e))
}

fn stem(path: &Path) -> String {
    path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default()
}
