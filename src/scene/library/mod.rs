//! The built-in scenes: generated, without files, with the views, lights and proportions of the
//! scenes that the thesis shows, so that everything runs out of the box.

mod atrium;
mod builder;
mod furnishing;
mod masonry;
mod rooms;

use super::pattern::{self, Pattern};
use super::{Aabb, Lens, Material, Probe, Scene, Surface, Texture, View};
use builder::MeshBuilder;
use glam::Vec3;
use rayon::prelude::*;

/// The names that [`scene`] knows.
pub fn names() -> &'static [&'static str] {
    &["rooms", "atrium"]
}

/// A built-in scene by its name; `None` for a name that is not in [`names`].
///
/// `rooms` stands for the thesis's two rooms (figures 5.1–5.5 and 5.9), `atrium` for Crytek Sponza
/// (figures 5.6–5.8).
pub fn scene(name: &str) -> Option<Scene> {
    match name {
        "rooms" => Some(rooms::scene()),
        "atrium" => Some(atrium::scene()),
        _ => None,
    }
}

/// A material of a built-in scene; the scenes keep these in tables and name them by index.
struct Finish {
    name: &'static str,
    /// `None` for windows, which show the sky.
    pattern: Option<Pattern>,
    reflectivity: f32,
}

impl Finish {
    const fn new(name: &'static str, pattern: Pattern, reflectivity: f32) -> Self {
        Self { name, pattern: Some(pattern), reflectivity }
    }

    const fn window(name: &'static str) -> Self {
        Self { name, pattern: None, reflectivity: 0.0 }
    }

    /// An empty mesh with the scale of this material's images.
    fn mesh(&self, name: impl Into<String>, material: usize) -> MeshBuilder {
        MeshBuilder::new(name, material, self.pattern.map_or(1.0, Pattern::size_m))
    }
}

/// Materials in the order of the table, and the images they use, each pattern once.
fn materials(finishes: &[Finish]) -> (Vec<Material>, Vec<Texture>) {
    let mut patterns: Vec<Pattern> = Vec::new();
    for pattern in finishes.iter().filter_map(|f| f.pattern) {
        if !patterns.contains(&pattern) {
            patterns.push(pattern);
        }
    }
    let textures = patterns
        .par_iter()
        .flat_map_iter(|&pattern| {
            let (albedo, normal) = pattern::images(pattern);
            [albedo, normal]
        })
        .collect();
    let material = |finish: &Finish| {
        let images = finish.pattern.and_then(|p| patterns.iter().position(|&q| q == p));
        Material {
            name: finish.name.to_owned(),
            albedo_map: images.map(|k| 2 * k),
            normal_map: images.map(|k| 2 * k + 1),
            reflectivity: finish.reflectivity,
            surface: if images.is_some() { Surface::Lit } else { Surface::Sky },
            ..Material::default()
        }
    };
    (finishes.iter().map(material).collect(), textures)
}

/// A probe of a box.
fn probe(name: &str, position: [f32; 3], min: [f32; 3], max: [f32; 3]) -> Probe {
    let bounds = Aabb { min: Vec3::from(min), max: Vec3::from(max) };
    Probe { name: name.to_owned(), position: Vec3::from(position), bounds }
}

/// A view with the scene's lens and materials.
fn view(name: &str, eye: [f32; 3], look_at: [f32; 3]) -> View {
    View { name: name.to_owned(), eye: Vec3::from(eye), look_at: Vec3::from(look_at), ..View::default() }
}

/// The lens of the thesis's program: 74° vertical, near 0.1 m, far 1000 m.
fn thesis_lens() -> Lens {
    Lens::default()
}

#[cfg(test)]
#[allow(clippy::expect_used)]
mod tests;
