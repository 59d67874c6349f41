//! The images of materials: found on disk, decoded in parallel, replaced where they are missing.

use crate::error::Result;
use crate::scene::pattern;
use crate::scene::{Encoding, Scene, Texture};
use rayon::prelude::*;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The most texels of a scene's images together: 4 GiB.
const MAX_TEXELS: u64 = 1 << 30;

/// An image as an MTL file states it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ImageStatement {
    /// The file name as it stands there.
    pub name: String,
    /// The MTL file, beside which the image lies.
    pub mtl_path: PathBuf,
    /// The line there.
    pub line: usize,
    /// `-bm`.
    pub multiplier: f32,
    /// Whether `-s`, `-o` or `-t` would move the texture coordinates.
    pub transformed: bool,
}

/// The images that a material asks for.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct MaterialImages {
    /// `map_Kd`.
    pub albedo: Option<ImageStatement>,
    /// `bump`.
    pub normal: Option<ImageStatement>,
    /// `map_d`.
    pub mask: Option<ImageStatement>,
    /// `map_Ks`.
    pub reflectivity: Option<ImageStatement>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Use {
    Albedo,
    /// With the bits of the multiplier.
    Normal(u32),
    Mask,
    Reflectivity,
}

/// An image in one use; two materials that ask for the same share it.
#[derive(Debug, PartialEq, Eq, Hash, Clone)]
struct Request {
    path: PathBuf,
    role: Use,
}

/// Loads the images of the scene's materials (`sources[i]` belongs to material i) into the scene.
///
/// Every image that is missing or cannot be read is one warning. In its place comes a generated one
/// if its name suggests it; else the material's colour, no normal map, no mask, a reflectivity of
/// `Ks` alone.
pub(super) fn attach(scene: &mut Scene, sources: Vec<MaterialImages>) {
    let mut requests = Requests::default();
    let wanted: Vec<[Option<usize>; 4]> = sources
        .iter()
        .map(|s| {
            let bits = |i: &ImageStatement| i.multiplier.to_bits();
            [
                s.albedo.as_ref().map(|i| requests.add(i, Use::Albedo)),
                s.normal.as_ref().map(|i| requests.add(i, Use::Normal(bits(i)))),
                s.mask.as_ref().map(|i| requests.add(i, Use::Mask)),
                s.reflectivity.as_ref().map(|i| requests.add(i, Use::Reflectivity)),
            ]
        })
        .collect();

    let loaded: Vec<Loaded> = requests.within_budget().into_par_iter().map(load).collect();
    let mut warned = Vec::new();
    let mut index_of = Vec::with_capacity(loaded.len());
    for (loaded, statement) in loaded.into_iter().zip(&requests.statements) {
        if let Some(problem) = loaded.problem
            && !warned.contains(&loaded.path)
        {
            let ImageStatement { name, mtl_path, line, .. } = statement;
            let instead = loaded.instead;
            scene.warnings.push(format!("{}:{line}: image {name} {problem}; {instead}", mtl_path.display()));
            warned.push(loaded.path);
        }
        index_of.push(loaded.texture.map(|texture| {
            scene.textures.push(texture);
            scene.textures.len() - 1
        }));
    }
    for (material, wanted) in scene.materials.iter_mut().zip(wanted) {
        let [albedo, normal, mask, reflectivity] = wanted.map(|w| w.and_then(|i| index_of[i]));
        material.albedo_map = albedo;
        material.normal_map = normal;
        material.alpha_mask = mask;
        material.reflectivity_map = reflectivity;
    }
    warn_of_transforms(scene, &sources);
}

fn warn_of_transforms(scene: &mut Scene, sources: &[MaterialImages]) {
    for (images, material) in sources.iter().zip(&scene.materials) {
        let all = [&images.albedo, &images.normal, &images.mask, &images.reflectivity];
        if let Some(image) = all.into_iter().flatten().find(|i| i.transformed) {
            let place = format!("{}:{}", image.mtl_path.display(), image.line);
            let what = "the options -s, -o and -t of maps are not supported and left out";
            scene.warnings.push(format!("{place}: material {}: {what}", material.name));
        }
    }
}

#[derive(Default)]
struct Requests {
    list: Vec<Request>,
    /// The statement that asked first.
    statements: Vec<ImageStatement>,
    index: HashMap<Request, usize>,
    found: HashMap<(PathBuf, String), PathBuf>,
}

impl Requests {
    fn add(&mut self, statement: &ImageStatement, role: Use) -> usize {
        let folder = statement.mtl_path.parent().unwrap_or(Path::new(""));
        let key = (folder.to_owned(), statement.name.clone());
        let path = self.found.entry(key).or_insert_with(|| {
            // A path that does not exist stands for the missing image.
            resolve(folder, &statement.name).unwrap_or_else(|| folder.join(forward_slashes(&statement.name)))
        });
        let request = Request { path: path.clone(), role };
        *self.index.entry(request.clone()).or_insert_with(|| {
            self.list.push(request);
            self.statements.push(statement.clone());
            self.list.len() - 1
        })
    }

    /// The requests, each with whether it still fits into [`MAX_TEXELS`].
    fn within_budget(&self) -> Vec<(&Request, bool)> {
        let mut texels = 0;
        let with_size = self.list.iter().map(|request| {
            if let Ok((width, height)) = image::image_dimensions(&request.path) {
                texels += u64::from(width) * u64::from(height);
            }
            (request, texels <= MAX_TEXELS)
        });
        with_size.collect()
    }
}

/// What became of a request.
struct Loaded {
    path: PathBuf,
    texture: Option<Texture>,
    /// Why it is not the image that was asked for, and what there is instead.
    problem: Option<String>,
    instead: &'static str,
}

fn load((request, fits): (&Request, bool)) -> Loaded {
    let Request { path, role } = request.clone();
    let problem = if !path.is_file() {
        "is missing".to_owned()
    } else if !fits {
        format!("would exceed the {MAX_TEXELS} texels of a scene")
    } else {
        match decode(&path, role) {
            Ok(texture) => return Loaded { path, texture: Some(texture), problem: None, instead: "" },
            Err(error) => format!("cannot be used ({error})"),
        }
    };
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let texture = match role {
        Use::Albedo => pattern::by_name(&name, pattern::Role::Albedo),
        Use::Normal(_) => pattern::by_name(&name, pattern::Role::Normal),
        Use::Mask | Use::Reflectivity => None,
    };
    let instead = match role {
        _ if texture.is_some() => "a generated one takes its place",
        Use::Albedo => "the material's colour takes its place",
        Use::Normal(_) => "the surface is smooth",
        Use::Mask => "the surface is opaque",
        Use::Reflectivity => "white takes its place",
    };
    Loaded { path, texture, problem: Some(problem), instead }
}

fn decode(path: &Path, role: Use) -> Result<Texture> {
    Ok(match role {
        Use::Albedo => Texture::decode(path, Encoding::Srgb)?,
        Use::Mask => Texture::decode(path, Encoding::Linear)?.into_mask(),
        Use::Reflectivity => Texture::decode(path, Encoding::Linear)?.into_reflectivity(),
        Use::Normal(bits) => Texture::decode(path, Encoding::Linear)?.into_normal_map(f32::from_bits(bits)),
    })
}

fn forward_slashes(name: &str) -> String {
    name.trim_matches('"').replace('\\', "/")
}

/// The file that a name means, looked for from `folder`: with backslashes as separators, without
/// regard to case where it does not exist as written, and, where its folders do not exist (paths of
/// the author's own machine), by its last component.
pub(in crate::scene) fn resolve(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = forward_slashes(name);
    let last = name.rsplit('/').next().unwrap_or(&name);
    find(folder, &name).or_else(|| find(folder, last))
}

fn find(folder: &Path, name: &str) -> Option<PathBuf> {
    let exact = folder.join(name);
    if exact.is_file() {
        return Some(exact);
    }
    let mut found = if name.starts_with('/') { PathBuf::from("/") } else { folder.to_owned() };
    for component in name.split('/').filter(|c| !c.is_empty()) {
        let next = found.join(component);
        found = if next.exists() { next } else { entry_ignoring_case(&found, component)? };
    }
    found.is_file().then_some(found)
}

fn entry_ignoring_case(folder: &Path, name: &str) -> Option<PathBuf> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let wanted = name.to_lowercase();
    let entries = std::fs::read_dir(folder).ok()?.flatten();
    let matching = entries.filter(|e| e.file_name().to_string_lossy().to_lowercase() == wanted);
    // The order of a folder's entries is arbitrary.
    matching.map(|e| e.path()).min()
}
