//! Loads the images of materials: finds the files, decodes them in parallel, and replaces missing ones.

use super::baked::{MaterialReading, Textures};
use crate::{Encoding, Scene, Texture};
use rayon::prelude::*;
use ssct_geometry::bounded::{self, printable_name};
use ssct_geometry::pattern;
use ssct_geometry::texture;
use ssct_geometry::texture::{MAX_TEXELS, TexelBudget};
use ssct_ground::{Error, Result};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// An image as an MTL file names it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ImageStatement {
    /// The file name as written in the statement.
    pub name: String,
    /// The MTL file; the image is looked up relative to it.
    pub mtl_path: PathBuf,
    /// The line of the statement.
    pub line: usize,
    /// The bump multiplier (`-bm`).
    pub multiplier: f32,
    /// Whether the statement says that the image is a normal map (`norm`), so that its look does not matter.
    pub is_normal_map: bool,
    /// Whether the statement has `-s`, `-o` or `-t`, which transform texture coordinates.
    pub transformed: bool,
    /// Whether the statement has `-mm`, `-imfchan` or `-clamp` with a value that changes the image.
    pub altered: bool,
}

impl ImageStatement {
    /// Returns the file and line of the statement, for messages.
    pub(super) fn place(&self) -> String {
        format!("{}:{}", self.mtl_path.display(), self.line)
    }
}

/// The images that a material names.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct MaterialImages {
    /// `map_Kd`.
    pub albedo: Option<ImageStatement>,
    /// `bump` or `norm`.
    pub normal: Option<ImageStatement>,
    /// `map_d`.
    pub mask: Option<ImageStatement>,
    /// `map_Ks`.
    pub reflectivity: Option<ImageStatement>,
    /// `map_Ke`.
    pub emission: Option<ImageStatement>,
    /// Perceptual roughness: `map_Pr`, and in some files `map_Ns`.
    pub roughness: Option<ImageStatement>,
    /// Metalness: `map_Pm`, and in some files `refl`.
    pub metalness: Option<ImageStatement>,
}

impl MaterialImages {
    /// Returns all images, in the order of the fields.
    fn in_order(&self) -> [&Option<ImageStatement>; 7] {
        let Self { albedo, normal, mask, reflectivity, emission, roughness, metalness } = self;
        [albedo, normal, mask, reflectivity, emission, roughness, metalness]
    }
}

/// The images that a material names, and the material that its numbers give; empty for a material without a definition.
#[derive(Default)]
pub(super) struct MaterialSource {
    pub images: MaterialImages,
    pub reading: Option<MaterialReading>,
}

/// The role of an image, which decides how the image is decoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum ImageRole {
    Albedo,
    /// A normal map or a height field, with the bits of the bump multiplier.
    Bump(u32),
    /// A normal map by its statement, with the bits of the bump multiplier.
    Normal(u32),
    Mask,
    Reflectivity,
    Emission,
    /// Images of numbers: roughness, metalness, and the level of the specular reflection.
    Data,
}

/// An image in one role. Materials that request the same image in the same role share the decoded image.
#[derive(Debug, PartialEq, Eq, Hash, Clone)]
struct Request {
    path: PathBuf,
    role: ImageRole,
}

/// Loads the images of the scene's materials (`sources[i]` belongs to material i) into the scene.
///
/// Larger images are shrunk to `side` texels along their longer side. Each image that is missing or cannot be read adds
/// one warning. A generated image replaces it if its file name suggests a pattern. Otherwise the material has its plain
/// colour, no normal map, no mask, or only the value of its numbers.
pub(super) fn attach(scene: &mut Scene, sources: Vec<MaterialSource>, side: u32) {
    let mut requests = Requests::default();
    let requested: Vec<[Option<usize>; 7]> = sources.iter().map(|source| requests.add_all(source)).collect();

    let progress = bounded::image_bar(requests.list.len());
    let loaded: Vec<LoadedImage> = requests
        .within_budget(side)
        .into_par_iter()
        .map(|(request, fits)| {
            let loaded = load(request, fits, side);
            progress.inc(1);
            loaded
        })
        .collect();
    progress.finish_and_clear();
    let mut warned = HashSet::new();
    let mut images = Vec::with_capacity(loaded.len());
    for (loaded, statement) in loaded.into_iter().zip(&requests.statements) {
        if let Some(problem) = loaded.problem
            && warned.insert(loaded.path)
        {
            let ImageStatement { name, mtl_path, line, .. } = statement;
            let replacement = loaded.replacement;
            scene.warnings.push(format!(
                "{}:{line}: image {} {problem}; {replacement}",
                mtl_path.display(),
                printable_name(name)
            ));
        }
        images.push(loaded.texture);
    }
    let mut textures = Textures::new(images);
    for ((material, source), requested) in scene.materials.iter_mut().zip(&sources).zip(requested) {
        let images = requested.map(|request| request.filter(|&index| textures.has_image(index)));
        textures.set_maps(material, source.reading.as_ref(), images);
    }
    scene.textures.extend(textures.finish(scene.textures.len(), &mut scene.materials));
    warn_of_options(scene, &sources);
}

/// Adds a warning for each material with an image whose options would transform texture coordinates, and one for each
/// material with an image whose options would change the image.
fn warn_of_options(scene: &mut Scene, sources: &[MaterialSource]) {
    for (source, material) in sources.iter().zip(&scene.materials) {
        let images = || source.images.in_order().into_iter().flatten();
        let transformed = images().find(|image| image.transformed).map(|image| (image, "-s, -o and -t"));
        let altered = images().find(|image| image.altered).map(|image| (image, "-mm, -imfchan and -clamp"));
        for (image, options) in transformed.into_iter().chain(altered) {
            let place = image.place();
            let message = format!("the options {options} of maps are not supported and were ignored");
            scene.warnings.push(format!("{place}: material {}: {message}", material.name));
        }
    }
}

/// The images that the materials of a scene need, each listed once for each role.
#[derive(Default)]
struct Requests {
    list: Vec<Request>,
    /// The first statement that made each request, in the order of the list.
    statements: Vec<ImageStatement>,
    /// Index of each request in the list.
    index: HashMap<Request, usize>,
    /// The path of each image that was looked up, by the folder of the MTL file and the name in it.
    resolved_paths: HashMap<(PathBuf, String), PathBuf>,
}

impl Requests {
    /// Requests the images of a material. Returns the index of each request, in the order of
    /// [`MaterialImages::in_order`], and `None` where the material has no such image.
    fn add_all(&mut self, source: &MaterialSource) -> [Option<usize>; 7] {
        let is_metallic = source.reading.as_ref().is_some_and(|reading| reading.is_metallic);
        let specular = if is_metallic { ImageRole::Data } else { ImageRole::Reflectivity };
        // The bits of the multiplier make requests with different multipliers differ.
        let bump = match &source.images.normal {
            Some(image) if image.is_normal_map => ImageRole::Normal(image.multiplier.to_bits()),
            image => ImageRole::Bump(image.as_ref().map_or(0, |image| image.multiplier.to_bits())),
        };
        let roles =
            [ImageRole::Albedo, bump, ImageRole::Mask, specular, ImageRole::Emission, ImageRole::Data, ImageRole::Data];
        let mut roles = roles.into_iter();
        source.images.in_order().map(|image| {
            let role = roles.next()?;
            image.as_ref().map(|image| self.add(image, role))
        })
    }

    /// Returns the index of the request for an image in a role, which is added to the list if it is new.
    fn add(&mut self, statement: &ImageStatement, role: ImageRole) -> usize {
        let folder = statement.mtl_path.parent().unwrap_or(Path::new(""));
        let key = (folder.to_owned(), statement.name.clone());
        let path = self.resolved_paths.entry(key).or_insert_with(|| {
            // If the image is not found, the request gets the path as written, at which there is no file.
            resolve(folder, &statement.name).unwrap_or_else(|| folder.join(forward_slashes(&statement.name)))
        });
        let request = Request { path: path.clone(), role };
        *self.index.entry(request.clone()).or_insert_with(|| {
            self.list.push(request);
            self.statements.push(statement.clone());
            self.list.len() - 1
        })
    }

    /// Returns the requests, each with true if its image still fits into [`MAX_TEXELS`]. Texels are added up in the
    /// order of the list, with sides of at most `side` texels.
    fn within_budget(&self, side: u32) -> Vec<(&Request, bool)> {
        let mut budget = TexelBudget::default();
        let with_flags = self.list.iter().map(|request| {
            // An image without readable dimensions is reported when it is decoded.
            let dimensions = image::image_dimensions(&request.path);
            (request, dimensions.map_or(true, |(width, height)| budget.admits(width, height, side)))
        });
        with_flags.collect()
    }
}

/// The result of a request.
struct LoadedImage {
    path: PathBuf,
    /// The image or its generated replacement; `None` if a number takes its place.
    texture: Option<Texture>,
    /// The reason why the requested image is not used; `None` if it is used.
    problem: Option<String>,
    /// The part of the warning that says what takes the image's place.
    replacement: &'static str,
}

/// Decodes the image of a request, with at most `side` texels along a side, or finds a replacement if the image cannot
/// be used. `fits` is false if the image would exceed the texels of a scene.
fn load(request: &Request, fits: bool, side: u32) -> LoadedImage {
    let Request { path, role } = request.clone();
    let problem = if !path.is_file() {
        "is missing".to_owned()
    } else if !fits {
        format!("would exceed the {MAX_TEXELS} texels of a scene")
    } else {
        match decode(&path, role, side) {
            Ok(texture) => return LoadedImage { path, texture: Some(texture), problem: None, replacement: "" },
            Err(error) => format!("cannot be used ({error})"),
        }
    };
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let texture = match role {
        ImageRole::Albedo => pattern::by_name(&name, pattern::Role::Albedo),
        ImageRole::Bump(_) | ImageRole::Normal(_) => pattern::by_name(&name, pattern::Role::Normal),
        ImageRole::Mask | ImageRole::Reflectivity | ImageRole::Emission | ImageRole::Data => None,
    };
    let replacement = match role {
        _ if texture.is_some() => "a generated image takes its place",
        ImageRole::Albedo => "the material's colour takes its place",
        ImageRole::Bump(_) | ImageRole::Normal(_) => "the surface is smooth",
        ImageRole::Mask => "the surface is opaque",
        ImageRole::Reflectivity => "white takes its place",
        ImageRole::Emission | ImageRole::Data => "the material's number takes its place",
    };
    LoadedImage { path, texture, problem: Some(problem), replacement }
}

/// Decodes a file, shrinks the image to at most `side` texels along a side, and converts the image to its role.
fn decode(path: &Path, role: ImageRole, side: u32) -> Result<Texture> {
    let decode = |encoding| Ok::<_, Error>(texture::shrink_to_side(texture::decode(path, encoding)?, side));
    Ok(match role {
        ImageRole::Albedo | ImageRole::Emission => decode(Encoding::Srgb)?,
        ImageRole::Data => decode(Encoding::Linear)?,
        ImageRole::Mask => texture::into_mask(decode(Encoding::Linear)?),
        ImageRole::Reflectivity => texture::into_reflectivity(decode(Encoding::Linear)?),
        ImageRole::Bump(bits) => texture::into_normal_map(decode(Encoding::Linear)?, f32::from_bits(bits)),
        ImageRole::Normal(bits) => texture::tidy_normal_map(decode(Encoding::Linear)?, f32::from_bits(bits)),
    })
}

/// Returns a file name without quotation marks, with each backslash replaced by a slash.
fn forward_slashes(name: &str) -> String {
    name.trim_matches('"').replace('\\', "/")
}

/// Finds the file that a name refers to, starting from `folder`. Backslashes and slashes separate folders. If no file
/// has the name as written, case is ignored. If the name is not found with its folders, for example because it is a
/// path on the author's machine, only its last component is looked up.
pub(crate) fn resolve(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = forward_slashes(name);
    let last_component = name.rsplit('/').next().unwrap_or(&name);
    find_file(folder, &name).or_else(|| find_file(folder, last_component))
}

/// Finds a file below `folder` by its name with folders. The name is taken as written, or else with case ignored in
/// components that do not exist as written.
fn find_file(folder: &Path, name: &str) -> Option<PathBuf> {
    let exact = folder.join(name);
    if exact.is_file() {
        return Some(exact);
    }
    let mut path_so_far = if name.starts_with('/') { PathBuf::from("/") } else { folder.to_owned() };
    for component in name.split('/').filter(|component| !component.is_empty()) {
        let next = path_so_far.join(component);
        path_so_far = if next.exists() { next } else { entry_ignoring_case(&path_so_far, component)? };
    }
    path_so_far.is_file().then_some(path_so_far)
}

/// Returns the path of an entry of a folder whose name differs from `name` at most in case.
fn entry_ignoring_case(folder: &Path, name: &str) -> Option<PathBuf> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let wanted = name.to_lowercase();
    let entries = std::fs::read_dir(folder).ok()?.flatten();
    let matching = entries.filter(|entry| entry.file_name().to_string_lossy().to_lowercase() == wanted);
    // The alphabetically first entry is taken, since the order of a folder's entries is arbitrary.
    matching.map(|entry| entry.path()).min()
}
