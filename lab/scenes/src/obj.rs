//! Loads scenes from Wavefront OBJ files, including the irregular ones that exporters write.
//!
//! [`load`] reads one or more OBJ files, with their MTL files and images, into a [`Scene`]. The submodules do the work
//! in stages: `text` checks and normalises the statements, the crate tobj sorts them into groups, and `polygons` makes
//! triangles with normals. `mtl` reads materials, and `images` and `baked` make their textures. Tangents, meshes and
//! the default view are made by the same code as for other formats.

mod baked;
mod images;
mod mtl;
mod polygons;
mod text;

use super::source_text::decode;
use super::{LoadOptions, Material, Probe, Scene, Surface, material_terms};
use glam::DVec3;
use ssct_geometry::{assemble, bounded, viewpoint};
use ssct_ground::{Error, Result};
use std::path::{Path, PathBuf};

use baked::MaterialReading;
pub(super) use images::resolve;

/// Greatest size, in bytes, of an OBJ or MTL file that is read.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// The handedness of the coordinates in files, which decides the direction of their z axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Handedness {
    /// The convention of OBJ; loading negates z and reverses the winding.
    #[default]
    Right,
    /// This program's own convention; coordinates are not changed.
    Left,
}

/// Options for loading OBJ files.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ObjOptions {
    /// The files' handedness.
    pub handedness: Handedness,
    /// Options that all loaders share; `scale` is in metres per unit of length in the files.
    pub load: LoadOptions,
}

/// One OBJ file of a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ObjFile {
    /// Path of the file; MTL files and images are looked up relative to it.
    pub path: PathBuf,
    /// Kind of all surfaces of the file: lit, or showing the sky.
    pub surface: Surface,
}

impl<P: Into<PathBuf>> From<P> for ObjFile {
    fn from(path: P) -> Self {
        Self { path: path.into(), surface: Surface::Lit }
    }
}

/// Loads OBJ files as one scene, named after the first file.
///
/// - Polygons, concave ones included, are triangulated. Triangles without area, points and lines are left out.
///   [`Scene::warnings`] lists what was left out or replaced.
/// - Missing normals: inside a smoothing group (`s 1`), a vertex gets the mean normal of that group's faces at its
///   position, weighted by their angles there. Outside a smoothing group (`s off`, or no `s` at all, which the format
///   defines as off), a vertex gets the normal of its face, so that boxes keep their edges.
/// - Texture coordinates get their origin at the top left (v' = 1 − v). Tangents are those of MikkTSpace;
///   without texture coordinates, a tangent is any unit vector orthogonal to the normal.
/// - A mesh holds the triangles of one group with one material; large meshes are split in space.
/// - Materials come from MTL, by the law of the program that wrote it, as listed at the top of `obj/mtl.rs`. Materials
///   of equal name in two files stay separate; unused materials are dropped.
/// - The scene gets one view, `default`, which shows all of the scene, one directional light, and one probe at the
///   centre.
///
/// # Errors
/// [`Error::Io`] if a file cannot be read. [`Error::Malformed`], with file and line, for wrong statements, for vertices
/// that are not finite, and for indices of vertices that are out of range. This error is also returned for files
/// without any triangle, files in UTF-16 or UTF-32, and files larger than [`MAX_FILE_BYTES`]. [`Error::Usage`] if no
/// files are given, or for options out of range.
pub fn load(files: &[ObjFile], options: &ObjOptions) -> Result<Scene> {
    let mut scene = load_plain(files, options, None)?;
    scene.views = vec![viewpoint::default_view(&scene)];
    scene.lights = vec![viewpoint::default_light()];
    scene.probes = vec![Probe::in_the_middle_of(scene.bounds())];
    Ok(scene)
}

/// Loads a scene like [`load`], but without view, light and probe. `origin`, in units of the files, is subtracted from
/// every vertex. With `None`, the first file decides: if it is too far from the origin for its size, its centre is
/// subtracted.
pub(super) fn load_plain(files: &[ObjFile], options: &ObjOptions, mut origin: Option<DVec3>) -> Result<Scene> {
    let Some(first) = files.first() else {
        return Err(Error::Usage("a scene needs at least one OBJ file".into()));
    };
    options.load.check()?;
    let mut scene = Scene { name: stem(&first.path), ..Scene::default() };
    let mut sources = Vec::new();
    for file in files {
        load_file(file, options, &mut origin, &mut scene, &mut sources)?;
    }
    images::attach(&mut scene, sources, options.load.texture_side);
    scene.lens = viewpoint::lens(scene.bounds());
    Ok(scene)
}

/// Reads one OBJ file. Its meshes and the materials that they use are added to `scene`, and the images of these
/// materials to `sources`. `origin` is subtracted from every vertex, as in [`load_plain`], and set if it is `None`.
fn load_file(
    file: &ObjFile,
    options: &ObjOptions,
    origin: &mut Option<DVec3>,
    scene: &mut Scene,
    sources: &mut Vec<images::MaterialSource>,
) -> Result<()> {
    let bytes = read_limited(&file.path)?;
    let text = decode(&file.path, &bytes)?;
    let statements = text::normalise(&file.path, &text, origin, options.load.scale, &mut scene.warnings)?;
    drop(text);
    drop(bytes);
    let material_names = statements.material_names.clone();
    let lacks_library = statements.libraries.is_empty() && material_names.iter().any(|name| name != text::NO_MATERIAL);
    let definitions = mtl::read_libraries(&file.path, &statements.libraries, &mut scene.warnings)?;
    let parts = polygons::build(&file.path, statements, options, &mut scene.warnings)?;

    if lacks_library {
        let message = "uses materials but names no MTL file; the materials are white";
        scene.warnings.push(format!("{}: {message}", file.path.display()));
    }
    let mut has_warned_of_roughness = false;
    // The index in the scene for each material of the file, once a part uses it.
    let mut scene_index: Vec<Option<usize>> = vec![None; material_names.len()];
    for part in &parts {
        if scene_index[part.material].is_none() {
            let name = &material_names[part.material];
            let definition = definitions.get(name);
            if let Some(definition) = definition {
                definition.warn(&mut scene.warnings);
            }
            if definition.is_none() && name != text::NO_MATERIAL && !definitions.is_empty() {
                scene.warnings.push(format!(
                    "{}: material {} is not defined in any MTL file; it is white",
                    file.path.display(),
                    bounded::printable_name(name)
                ));
            }
            scene_index[part.material] = Some(scene.materials.len());
            let reading = definition.map(mtl::Definition::reading);
            let is_rough = |reading: &MaterialReading| reading.is_metallic && reading.material.roughness >= 1.0;
            if reading.as_ref().is_some_and(is_rough) && !has_warned_of_roughness {
                has_warned_of_roughness = true;
                scene.warnings.push(format!("{}: {}", file.path.display(), material_terms::TOO_ROUGH));
            }
            scene.materials.push(Material {
                name: name.clone(),
                surface: file.surface,
                ..reading.as_ref().map_or_else(Default::default, |reading| reading.material.clone())
            });
            let images = definition.map(mtl::Definition::images).unwrap_or_default();
            sources.push(images::MaterialSource { images, reading });
        }
    }
    let material_of = |part: &assemble::MeshPart| scene_index[part.material].unwrap_or_default();
    scene.meshes.extend(assemble::meshes(parts, material_of));
    Ok(())
}

/// Reads an OBJ or MTL file of at most [`MAX_FILE_BYTES`].
fn read_limited(path: &Path) -> Result<Vec<u8>> {
    bounded::read(path, "a file", MAX_FILE_BYTES)
}

/// Returns the name of a file without its folder and its ending.
fn stem(path: &Path) -> String {
    path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}
