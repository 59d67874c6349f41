//! The built-in scenes. They are generated without files, so that the program can be used without downloads, and have
//! the views, lights and proportions of the scenes in the theses.

mod atrium;
pub mod builder;
mod car;
mod cathedral;
mod cornell_box;
mod corridor;
mod fittings;
mod masonry;
mod museum;
mod rooms;
mod skeleton;
mod street;

use super::{Aabb, Lens, LoadOptions, Material, Probe, Scene, Surface, Texture, View, scene_file};
use builder::MeshBuilder;
use glam::Vec3;
use rayon::prelude::*;
use ssct_geometry::pattern::{self, Pattern, Picture};
use ssct_ground::Result;
use std::path::Path;

/// Returns the names of the scenes that studies use.
pub fn names() -> &'static [&'static str] {
    &["rooms", "atrium", "street", "museum", "cathedral", "corridor"]
}

/// Returns all names that [`scene`] knows: the scenes of studies, and a box without reflections, which only shows a
/// figure.
pub fn every_name() -> impl Iterator<Item = &'static str> {
    names().iter().copied().chain(["cornell-box"])
}

/// Makes the built-in scene of this name; for any other name, loads the scene file with this path.
///
/// # Errors
/// The errors of [`scene_file::load`].
pub fn scene_or_file(name: &str) -> Result<Scene> {
    scene(name).map_or_else(|| scene_file::load(Path::new(name), &LoadOptions::default()), Ok)
}

/// Makes a built-in scene; `None` if the name is not in [`every_name`].
///
/// `rooms` replaces the thesis's two rooms (figures 5.1–5.5 and 5.9), and `atrium` replaces Crytek Sponza (figures
/// 5.6–5.8). `street`, `museum` and `cathedral` replace the three scenes of Schmidt's thesis (2013, section 5.1).
/// `corridor` is a narrow room, as section 5.2 of Schmidt's thesis recommends for parallax-corrected cube maps.
/// `cornell-box` is the scene of the thesis's figure 2.4.
pub fn scene(name: &str) -> Option<Scene> {
    match name {
        "rooms" => Some(rooms::scene()),
        "atrium" => Some(atrium::scene()),
        "street" => Some(street::scene()),
        "museum" => Some(museum::scene()),
        "cathedral" => Some(cathedral::scene()),
        "corridor" => Some(corridor::scene()),
        "cornell-box" => Some(cornell_box::scene()),
        _ => None,
    }
}

/// A material of a built-in scene. Each scene keeps its materials in a table and refers to them by index.
#[derive(Clone, Copy)]
struct Finish {
    name: &'static str,
    look: SurfaceLook,
    /// Linear factor on the images, or the linear albedo without images.
    tint: Vec3,
    reflectivity: f32,
    roughness: f32,
    /// Weight of the relief (the normal map); 1 leaves the relief of the image unchanged.
    normal_deviation: f32,
}

/// The source of a material's images.
#[derive(Clone, Copy, PartialEq)]
enum SurfaceLook {
    /// A repeating image with its relief.
    Pattern(Pattern),
    /// One image from edge to edge.
    Picture(Picture),
    /// No image: one uniform colour.
    Paint,
    /// No image: the surface shows the sky.
    Window,
}

impl Finish {
    /// Makes a white finish with this look, roughness 0 and the full strength of its normal map.
    const fn with_look(name: &'static str, look: SurfaceLook, reflectivity: f32) -> Self {
        Self { name, look, tint: Vec3::ONE, reflectivity, roughness: 0.0, normal_deviation: 1.0 }
    }

    /// Makes a finish whose image is a repeating pattern.
    const fn new(name: &'static str, pattern: Pattern, reflectivity: f32) -> Self {
        Self::with_look(name, SurfaceLook::Pattern(pattern), reflectivity)
    }

    /// Makes a finish with one image from edge to edge, which does not reflect.
    const fn picture(name: &'static str, picture: Picture) -> Self {
        Self::with_look(name, SurfaceLook::Picture(picture), 0.0)
    }

    /// Makes a finish of one uniform colour, given as linear albedo, which does not reflect.
    const fn paint(name: &'static str, red: f32, green: f32, blue: f32) -> Self {
        Self::with_look(name, SurfaceLook::Paint, 0.0).tinted(red, green, blue)
    }

    /// Makes a finish that shows the sky.
    const fn window(name: &'static str) -> Self {
        Self::with_look(name, SurfaceLook::Window, 0.0)
    }

    /// Multiplies the images by a linear colour.
    const fn tinted(self, red: f32, green: f32, blue: f32) -> Self {
        Self { tint: Vec3::new(red, green, blue), ..self }
    }

    /// Sets how much the finish reflects, and how rough it is.
    const fn reflecting(self, reflectivity: f32, roughness: f32) -> Self {
        Self { reflectivity, roughness, ..self }
    }

    /// Sets the weight of the normal map, which is below 1 for a polished surface.
    const fn smoothed(self, normal_deviation: f32) -> Self {
        Self { normal_deviation, ..self }
    }

    /// Makes an empty mesh with this finish's texture scale; `material` is the index of the finish in the scene's
    /// table.
    fn mesh(&self, name: impl Into<String>, material: usize) -> MeshBuilder {
        let image_m = if let SurfaceLook::Pattern(pattern) = self.look { pattern.size_m() } else { 1.0 };
        MeshBuilder::new(name, material, image_m)
    }
}

/// The images of a look, or their indices in the scene.
struct Maps<T> {
    albedo: T,
    normal: Option<T>,
    mask: Option<T>,
    reflectivity: Option<T>,
}

impl SurfaceLook {
    /// Makes the images of the look; `None` for a look without images.
    fn images(self) -> Option<Maps<Texture>> {
        match self {
            Self::Pattern(pattern) => {
                let (albedo, normal) = pattern::images(pattern);
                let reflectivity = pattern::reflectivity_image(pattern);
                Some(Maps { albedo, normal: Some(normal), mask: None, reflectivity })
            }
            Self::Picture(picture) => {
                let (albedo, mask) = pattern::picture_images(picture);
                Some(Maps { albedo, normal: None, mask, reflectivity: None })
            }
            Self::Paint | Self::Window => None,
        }
    }
}

/// Makes the materials that the finishes of a table describe, in its order, and the images that they use. Finishes with
/// equal looks share images.
fn materials(finishes: &[Finish]) -> (Vec<Material>, Vec<Texture>) {
    let mut looks: Vec<SurfaceLook> = Vec::new();
    for finish in finishes {
        if !looks.contains(&finish.look) {
            looks.push(finish.look);
        }
    }
    let images_of_looks: Vec<Option<Maps<Texture>>> = looks.par_iter().map(|look| look.images()).collect();
    let mut textures = Vec::new();
    let mut add_texture = |texture| {
        textures.push(texture);
        textures.len() - 1
    };
    // The indices in `textures` of each look's images.
    let maps_of_looks: Vec<Option<Maps<usize>>> = images_of_looks
        .into_iter()
        .map(|images| {
            images.map(|images| Maps {
                albedo: add_texture(images.albedo),
                normal: images.normal.map(&mut add_texture),
                mask: images.mask.map(&mut add_texture),
                reflectivity: images.reflectivity.map(&mut add_texture),
            })
        })
        .collect();
    let material = |finish: &Finish| {
        let maps = looks.iter().position(|&look| look == finish.look).and_then(|index| maps_of_looks[index].as_ref());
        Material {
            name: finish.name.to_owned(),
            albedo: finish.tint,
            albedo_map: maps.map(|maps| maps.albedo),
            normal_map: maps.and_then(|maps| maps.normal),
            alpha_mask: maps.and_then(|maps| maps.mask),
            reflectivity: finish.reflectivity,
            reflectivity_map: maps.and_then(|maps| maps.reflectivity),
            roughness: finish.roughness,
            normal_deviation: finish.normal_deviation,
            surface: if finish.look == SurfaceLook::Window { Surface::Sky } else { Surface::Lit },
            ..Material::default()
        }
    };
    (finishes.iter().map(material).collect(), textures)
}

/// Makes a probe for a cube map from its position and the least and the greatest corner of the box that corrects its
/// parallax, in metres.
fn probe(name: &str, position: [f32; 3], min: [f32; 3], max: [f32; 3]) -> Probe {
    let bounds = Aabb { min: Vec3::from(min), max: Vec3::from(max) };
    Probe { name: name.to_owned(), position: Vec3::from(position), bounds }
}

/// Makes a view that changes neither the lens nor the materials of the scene; `eye` and `look_at` are in metres.
fn view(name: &str, eye: [f32; 3], look_at: [f32; 3]) -> View {
    View { name: name.to_owned(), eye: Vec3::from(eye), look_at: Vec3::from(look_at), ..View::default() }
}

/// Returns the lens of the thesis's program: 74° vertical, near 0.1 m, far 1000 m.
fn thesis_lens() -> Lens {
    Lens::default()
}

#[cfg(test)]
#[allow(clippy::expect_used)]
mod tests;
