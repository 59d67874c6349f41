//! The scenes of the complaints, each made of a few rectangles and boxes. Painted surfaces emit their colour, so that
//! it is the same from everywhere. Reflecting surfaces are black, so that they show nothing but their reflection. In
//! all scenes x is to the right, y up and z ahead of the camera, in metres.

use glam::{Vec2, Vec3};
use ssct_scenes::library::builder::MeshBuilder;
use ssct_scenes::{Encoding, Lens, Light, Material, Mesh, Scene, Texture, View};

/// Vertical field of view, in degrees.
const FIELD_OF_VIEW: f32 = 50.0;

pub const RED: Vec3 = Vec3::new(0.8, 0.05, 0.04);
pub const BLUE: Vec3 = Vec3::new(0.05, 0.15, 0.7);
pub const YELLOW: Vec3 = Vec3::new(0.9, 0.7, 0.05);
pub const GREEN: Vec3 = Vec3::new(0.08, 0.5, 0.12);
pub const GREY: Vec3 = Vec3::new(0.5, 0.5, 0.5);
pub const DARK: Vec3 = Vec3::new(0.04, 0.04, 0.05);
pub const WHITE: Vec3 = Vec3::new(0.95, 0.95, 0.95);

/// Returns the lens of the cases, with the given near and far plane.
pub fn lens(near_m: f32, far_m: f32) -> Lens {
    Lens::perspective(FIELD_OF_VIEW.to_radians(), near_m, far_m)
}

/// A scene under construction: meshes, each with its own material.
pub struct SceneParts {
    meshes: Vec<Mesh>,
    materials: Vec<Material>,
}

impl SceneParts {
    /// Makes a scene without parts.
    pub fn new() -> Self {
        Self { meshes: Vec::new(), materials: Vec::new() }
    }

    /// Adds a mesh of paint, which emits its colour; `shape` builds the mesh.
    pub fn paint(mut self, name: &str, albedo: Vec3, shape: impl FnOnce(&mut MeshBuilder)) -> Self {
        self.add(name, Material { albedo, reflectivity: 0.0, emission: 1.0, ..Material::default() }, shape);
        self
    }

    /// Adds a mesh that reflects all light and has no colour of its own; `shape` builds the mesh.
    pub fn mirror(mut self, name: &str, roughness: f32, shape: impl FnOnce(&mut MeshBuilder)) -> Self {
        self.add(name, Material { albedo: Vec3::ZERO, roughness, ..Material::default() }, shape);
        self
    }

    /// Adds a mesh, which `shape` builds, and its material under the same name.
    fn add(&mut self, name: &str, material: Material, shape: impl FnOnce(&mut MeshBuilder)) {
        let mut mesh = MeshBuilder::new(name, self.materials.len(), 1.0);
        shape(&mut mesh);
        self.meshes.push(mesh.build());
        self.materials.push(Material { name: name.to_owned(), ..material });
    }

    /// Finishes the scene, with one view: from the place `eye` towards the point `look_at`.
    pub fn with_view(self, name: &str, eye: [f32; 3], look_at: [f32; 3]) -> Scene {
        let view = View { name: name.to_owned(), eye: eye.into(), look_at: look_at.into(), ..View::default() };
        Scene {
            name: name.to_owned(),
            meshes: self.meshes,
            materials: self.materials,
            lights: vec![Light::Directional { direction: Vec3::NEG_Y, energy: 1.0 }],
            lens: lens(0.1, 100.0),
            views: vec![view],
            ..Scene::default()
        }
    }
}

/// Returns a function that adds a horizontal rectangle at y = 0 that faces up; `x` and `z` are its least and greatest
/// coordinates.
pub fn floor(x: [f32; 2], z: [f32; 2]) -> impl FnOnce(&mut MeshBuilder) {
    move |mesh| {
        let corner = |a: f32, b: f32| Vec3::new(a, 0.0, b);
        mesh.polygon(&[corner(x[0], z[0]), corner(x[1], z[0]), corner(x[1], z[1]), corner(x[0], z[1])], Vec3::Y);
    }
}

/// Returns a function that adds an upright rectangle across the view, at z, that faces the camera; `x` and `y` are its
/// least and greatest coordinates.
pub fn wall(x: [f32; 2], y: [f32; 2], z: f32) -> impl FnOnce(&mut MeshBuilder) {
    move |mesh| {
        let corner = |a: f32, b: f32| Vec3::new(a, b, z);
        mesh.polygon(&[corner(x[0], y[0]), corner(x[1], y[0]), corner(x[1], y[1]), corner(x[0], y[1])], Vec3::NEG_Z);
    }
}

/// Returns a function that adds an upright rectangle at `x`, parallel to the direction of view, that faces the plane x
/// = 0; `y` and `z` are its least and greatest coordinates.
pub fn side(x: f32, y: [f32; 2], z: [f32; 2]) -> impl FnOnce(&mut MeshBuilder) {
    move |mesh| {
        let corner = |a: f32, b: f32| Vec3::new(x, a, b);
        mesh.polygon(
            &[corner(y[0], z[0]), corner(y[1], z[0]), corner(y[1], z[1]), corner(y[0], z[1])],
            Vec3::new(-x, 0.0, 0.0),
        );
    }
}

/// Returns a function that adds a box between two opposite corners.
pub fn block(min: [f32; 3], max: [f32; 3]) -> impl FnOnce(&mut MeshBuilder) {
    move |mesh| mesh.cuboid(min.into(), max.into())
}

/// Adds a back wall at `z`, from −`x` to `x` and up to `height`, in upright stripes of two colours, so that a displaced
/// reflection is visible.
fn back_wall(mut parts: SceneParts, x: f32, height: f32, z: f32) -> SceneParts {
    const STRIPES: usize = 24;
    for (name, albedo, first_stripe) in [("wall", GREY, 0), ("wall-dark", GREEN, 1)] {
        parts = parts.paint(name, albedo, |mesh| {
            for stripe in (first_stripe..STRIPES).step_by(2) {
                let [from, to] = [stripe, stripe + 1].map(|edge| x * (2.0 * edge as f32 / STRIPES as f32 - 1.0));
                wall([from, to], [0.0, height], z)(mesh);
            }
        });
    }
    parts
}

/// A reflecting floor of a roughness, blocks that stand on it, and a wall behind them.
pub fn blocks(name: &str, roughness: f32) -> Scene {
    let parts = SceneParts::new()
        .mirror("floor", roughness, floor([-12.0, 12.0], [-2.0, 12.0]))
        .paint("red", RED, block([-2.2, 0.0, 4.0], [-1.2, 1.0, 5.0]))
        .paint("blue", BLUE, block([0.6, 0.0, 6.0], [1.6, 1.8, 7.0]))
        .paint("yellow", YELLOW, block([2.0, 0.0, 3.5], [2.6, 0.5, 4.1]));
    back_wall(parts, 12.0, 12.0, 12.0).with_view(name, [0.0, 1.5, -2.0], [0.0, 0.8, 5.0])
}

/// A tower that hangs behind the end of a floor, with sky between tower and floor.
pub fn sky_gap() -> Scene {
    SceneParts::new()
        .mirror("floor", 0.0, floor([-12.0, 12.0], [-2.0, 8.0]))
        .paint("tower", RED, block([-2.5, 1.4, 14.0], [2.5, 5.0, 16.0]))
        .with_view("sky-gap", [0.0, 1.5, -2.0], [0.0, 1.2, 8.0])
}

/// Poles before a wall, reflected in a mirroring floor and a mirroring side wall.
pub fn poles() -> Scene {
    let pole = |mesh: &mut MeshBuilder, x: f32, z: f32| block([x, 0.0, z], [x + 0.06, 2.6, z + 0.06])(mesh);
    let parts = SceneParts::new()
        .mirror("floor", 0.0, floor([-12.0, 3.0], [-2.0, 12.0]))
        .mirror("mirror", 0.0, side(3.0, [0.0, 4.0], [0.0, 12.0]))
        .paint("poles", RED, |mesh| {
            for (x, z) in [(-2.0, 3.5), (-1.0, 4.0), (0.0, 3.5), (0.8, 4.0), (1.6, 3.5)] {
                pole(mesh, x, z);
            }
        });
    back_wall(parts, 12.0, 12.0, 12.0).with_view("poles", [-0.8, 1.5, -2.0], [0.6, 1.0, 5.0])
}

/// A glossy floor, seen from a hand's breadth above it.
pub fn grazing() -> Scene {
    let parts = SceneParts::new()
        .mirror("floor", 0.3, floor([-12.0, 12.0], [-2.0, 12.0]))
        .paint("red", RED, block([-2.0, 0.0, 5.0], [-1.0, 1.5, 6.0]))
        .paint("white", WHITE, block([0.5, 0.0, 7.0], [0.9, 3.0, 7.4]));
    back_wall(parts, 12.0, 12.0, 12.0).with_view("grazing", [0.0, 0.25, -2.0], [0.0, 0.3, 5.0])
}

/// A pillar on a mirroring floor, for cameras near and far.
pub fn pillar() -> Scene {
    let parts = SceneParts::new().mirror("floor", 0.0, floor([-30.0, 30.0], [-60.0, 8.0])).paint(
        "pillar",
        RED,
        block([-0.4, 0.0, 2.0], [0.4, 3.0, 2.8]),
    );
    back_wall(parts, 30.0, 12.0, 8.0).with_view("pillar", [0.0, 1.5, -4.0], [0.0, 1.0, 2.0])
}

/// A bright block that hangs before a dark wall, reflected in a glossy floor.
pub fn silhouettes() -> Scene {
    SceneParts::new()
        .mirror("floor", 0.25, floor([-12.0, 12.0], [-2.0, 12.0]))
        .paint("white", WHITE, block([-1.5, 0.8, 3.5], [0.0, 2.3, 4.0]))
        .paint("yellow", YELLOW, block([1.2, 0.0, 4.5], [1.6, 2.6, 5.0]))
        .paint("wall", DARK, wall([-14.0, 14.0], [0.0, 12.0], 12.0))
        .with_view("silhouettes", [0.0, 1.5, -2.0], [0.0, 0.8, 4.0])
}

/// A side wall of black metal that shows nothing but reflections, and that a mirroring floor reflects.
pub fn metal() -> Scene {
    let parts = SceneParts::new()
        .mirror("floor", 0.0, floor([-12.0, 3.0], [-2.0, 12.0]))
        .mirror("metal", 0.0, side(3.0, [0.0, 3.0], [1.0, 11.0]))
        .paint("red", RED, block([-1.0, 0.0, 6.0], [0.0, 2.0, 7.0]));
    back_wall(parts, 12.0, 12.0, 12.0).with_view("metal", [-0.6, 1.5, -2.0], [0.8, 1.0, 5.0])
}

/// A block that moves before a wall, on a mirroring floor.
pub fn moving() -> Scene {
    let parts = SceneParts::new().mirror("floor", 0.15, floor([-12.0, 12.0], [-2.0, 12.0])).paint(
        "thing",
        RED,
        block([-3.0, 0.2, 4.0], [-2.0, 1.4, 5.0]),
    );
    back_wall(parts, 12.0, 12.0, 12.0).with_view("moving", [0.0, 1.5, -2.0], [0.0, 0.8, 5.0])
}

/// A weapon close to the camera, above a mirroring floor.
pub fn weapon() -> Scene {
    let parts = SceneParts::new()
        .mirror("floor", 0.0, floor([-12.0, 12.0], [-2.0, 12.0]))
        .paint("weapon", RED, block([0.08, 1.18, -1.6], [0.2, 1.3, -1.0]))
        .paint("blue", BLUE, block([0.6, 0.0, 6.0], [1.6, 1.8, 7.0]));
    back_wall(parts, 12.0, 12.0, 12.0).with_view("weapon", [0.0, 1.5, -2.0], [0.0, 0.8, 5.0])
}

/// A wall for the case of a pane between the camera and the wall; the scene itself has no pane.
pub fn pane() -> Scene {
    let parts = SceneParts::new().mirror("floor", 0.0, floor([-12.0, 12.0], [-2.0, 12.0]));
    back_wall(parts, 12.0, 12.0, 12.0).with_view("pane", [0.0, 1.5, -2.0], [0.0, 0.8, 5.0])
}

/// A wall of fine stripes, reflected in a floor that bends down with distance, so that a pixel of its far part reflects
/// more of the wall.
pub fn stripes() -> Scene {
    // The radius of the floor's bend, and the length on the wall that one repetition of the stripes takes.
    const RADIUS_M: f32 = 60.0;
    const STRIPES_M: f32 = 0.5;
    let mut scene = SceneParts::new()
        .mirror("floor", 0.0, |mesh| {
            // A grid of 1 × 96 cells, over which s and t run from 0 to 1.
            mesh.surface(Vec3::ZERO, [1, 96], |s, t| {
                let (x, z) = (24.0 * s - 12.0, 14.0 * t);
                // A parabola of this height follows a circle of the radius near its top.
                (Vec3::new(x, -z * z / (2.0 * RADIUS_M), z), Vec2::new(x, z))
            });
        })
        .paint("stripes", Vec3::ONE, |mesh| {
            // The texture repeats every `STRIPES_M` metres, which only a new builder can set.
            let mut striped = MeshBuilder::new("stripes", 1, STRIPES_M);
            wall([-14.0, 14.0], [-4.0, 12.0], 16.0)(&mut striped);
            *mesh = striped;
        })
        .with_view("stripes", [0.0, 1.2, -1.0], [0.0, 0.9, 5.0]);
    // The material of the stripes is the second one, after that of the floor.
    scene.materials[1].albedo_map = Some(0);
    scene.textures = vec![stripe()];
    scene
}

/// Makes a texture whose upper half is bright and whose lower half is dark.
fn stripe() -> Texture {
    let texel = |row: u32| if row < STRIPE_TEXELS / 2 { [250, 250, 250, 255] } else { [40, 40, 44, 255] };
    let rgba = (0..STRIPE_TEXELS * STRIPE_TEXELS).flat_map(|i| texel(i / STRIPE_TEXELS)).collect();
    let (width, height, encoding) = (STRIPE_TEXELS, STRIPE_TEXELS, Encoding::Srgb);
    Texture { name: "stripe".into(), width, height, rgba, encoding }
}

/// Texels along a side of the texture of a stripe.
const STRIPE_TEXELS: u32 = 32;
