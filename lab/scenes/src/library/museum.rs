//! `museum`: two halls joined by a wide arch, after the second of Schmidt's scenes (2013, section 5.1, figures 40 and
//! 51b). The halls have a dinosaur skeleton in the middle, paintings, and an exit sign that is reflected in the
//! polished wall beside it.

use super::builder::{MeshBuilder, Rect};
use super::fittings::{Face, centred_rect, standing_rect};
use super::masonry::{self, Arch, ColumnSize, Wall};
use super::{Finish, materials, probe, skeleton, thesis_lens, view};
use crate::{AreaLight, AreaShape, Light, Mesh, Scene};
use glam::{Vec2, Vec3};
use ssct_geometry::impostor_image;
use ssct_geometry::pattern::{Painting, Pattern, Picture, Sign, SignOutline, Text, Wood};
use std::f32::consts::PI;

// Indices of materials in `FINISHES`.
const FLOOR: usize = 0;
const WALL: usize = 1;
const CEILING: usize = 2;
const STONE: usize = 3;
const BONE: usize = 4;
const GILT: usize = 5;
const WOOD: usize = 6;
const LAMP: usize = 7;
const METAL: usize = 8;
const LEAF: usize = 9;
const WINDOW: usize = 10;
const EXIT: usize = 11;
/// The index of the first of four paintings.
const PAINTING: usize = 12;

const FINISHES: [Finish; 16] = [
    Finish::new("floor", Pattern::Marble, 0.5).reflecting(0.55, 0.02).smoothed(0.2),
    Finish::new("wall", Pattern::Stucco, 0.0).tinted(0.62, 0.17, 0.13).reflecting(0.2, 0.02).smoothed(0.0),
    Finish::new("ceiling", Pattern::Stucco, 0.0),
    Finish::new("stone", Pattern::Limestone, 0.0),
    Finish::new("bone", Pattern::Stucco, 0.0).tinted(1.0, 0.86, 0.60),
    Finish::paint("gilt", 0.55, 0.38, 0.11).reflecting(0.3, 0.1),
    Finish::new("wood", Pattern::Wood(Wood::Dark), 0.0).reflecting(0.2, 0.06).smoothed(0.3),
    Finish::paint("lamp", 1.0, 0.95, 0.84),
    Finish::paint("metal", 0.12, 0.12, 0.13).reflecting(0.4, 0.05),
    Finish::new("leaf", Pattern::Foliage, 0.0),
    Finish::window("window"),
    Finish::picture("exit", Picture::Sign(&EXIT_SIGN)),
    Finish::picture("landscape", Picture::Painting(Painting::Landscape)),
    Finish::picture("ship", Picture::Painting(Painting::Ship)),
    Finish::picture("fields", Picture::Painting(Painting::Fields)),
    Finish::picture("portrait", Picture::Painting(Painting::Portrait)),
];

const EXIT_SIGN: Sign = Sign {
    text: Text { letters: "EXIT", stacked: false },
    cut: SignOutline::Arrow,
    ink: Vec3::new(0.97, 1.0, 0.97),
    ground: Vec3::new(0.01, 0.55, 0.16),
    bulbs: false,
    size: [384, 128],
};

/// Half the width (x) and the height (y) of the halls, in metres.
const HALF_WIDTH: f32 = 6.0;
const HEIGHT: f32 = 5.0;
/// The z of the two end walls, in metres.
const ENDS_Z: [f32; 2] = [-9.0, 13.0];
/// The z of the middle and the thickness of the partition wall between the halls, in metres.
const PARTITION_Z: f32 = 3.2;
const PARTITION_M: f32 = 0.4;
/// The arch in the partition wall, along x.
const ARCH: Arch = Arch { centre_m: -1.0, half_width_m: 1.9, spring_m: 2.5, rise_m: 1.3 };
/// Overlap of neighbouring geometry, in metres, so that no light shows through the joints.
const OVERLAP: f32 = 0.02;
/// The x and z ranges of the skylight of the first hall and of its well, in metres.
const SKYLIGHT: ([f32; 2], [f32; 2]) = ([-1.4, 1.4], [-7.0, 1.0]);
/// The z of the centre of the door in the wall at +x, below the exit sign.
const DOOR_Z: f32 = 0.9;
/// The x and z of the middle of each pendant lamp, in metres.
const LAMPS: [[f32; 2]; 8] =
    [[-3.6, -6.5], [3.6, -6.5], [-3.6, -2.5], [3.6, -2.5], [-3.6, 1.2], [3.6, 1.2], [-2.6, 8.0], [2.6, 8.0]];
/// Height of the middle of the lamps, and their radius, in metres.
const LAMP_Y: f32 = 3.75;
const LAMP_RADIUS: f32 = 0.2;

/// Builds the scene, with its meshes, materials, lights, views, probes and impostors.
pub fn scene() -> Scene {
    let (materials, textures) = materials(&FINISHES);
    let parts = [shell(), skylight(), paintings(), exit_door(), exhibits(), lamps(), furniture()];
    let meshes: Vec<Mesh> = parts.into_iter().flatten().map(MeshBuilder::build).collect();
    let light_below = |[x, z]: [f32; 2]| Light::Point { position: Vec3::new(x, LAMP_Y - 0.6, z), energy: 7.0 };
    let mut lights = LAMPS.map(light_below).to_vec();
    lights.push(Light::Point { position: Vec3::new(HALF_WIDTH - 0.75, 2.75, DOOR_Z), energy: 2.0 });
    lights.push(Light::Point { position: Vec3::new(0.0, 4.7, -3.0), energy: 9.0 });
    let mut scene = Scene {
        name: "museum".to_owned(),
        meshes,
        materials,
        textures,
        lights,
        lens: thesis_lens(),
        views: vec![
            view("museum", [-4.3, 1.7, -8.0], [1.4, 1.0, 0.5]),
            view("exit-sign", [2.9, 1.6, -3.2], [5.3, 1.9, 2.4]),
            view("paintings", [-1.6, 1.5, -7.6], [-6.0, 0.9, -1.6]),
            view("second-hall", [-2.2, 1.6, 0.8], [0.6, 1.0, 9.0]),
        ],
        probes: vec![
            probe(
                "first-hall",
                [-2.6, 1.8, -5.5],
                [-HALF_WIDTH, 0.0, ENDS_Z[0]],
                [HALF_WIDTH, HEIGHT, PARTITION_Z - 0.5 * PARTITION_M],
            ),
            probe(
                "before-the-arch",
                [-1.0, 1.8, 1.4],
                [-HALF_WIDTH, 0.0, ENDS_Z[0]],
                [HALF_WIDTH, HEIGHT, PARTITION_Z - 0.5 * PARTITION_M],
            ),
            probe(
                "second-hall",
                [-1.8, 1.8, 8.6],
                [-HALF_WIDTH, 0.0, PARTITION_Z + 0.5 * PARTITION_M],
                [HALF_WIDTH, HEIGHT, ENDS_Z[1]],
            ),
        ],
        area_lights: LAMPS
            .map(|[x, z]| AreaLight {
                shape: AreaShape::Sphere { centre: Vec3::new(x, LAMP_Y, z), radius: LAMP_RADIUS },
                radiance: Vec3::new(1.0, 0.95, 0.84),
            })
            .to_vec(),
        ..Scene::default()
    };
    impostor_image::add(&mut scene, &["exit-sign"], &right_wall().portrait("exit sign", exit_rect(), 0.12, 384));
    for painting in hung_paintings().iter().take(6) {
        let mesh = format!("{}-{}", painting.name, painting.number);
        let frame = painting.wall.portrait(painting.name, painting.rect, 0.05, 256);
        impostor_image::add(&mut scene, &[&mesh], &frame);
    }
    scene
}

/// Makes an empty mesh; `material` is an index into [`FINISHES`].
fn mesh(name: impl Into<String>, material: usize) -> MeshBuilder {
    FINISHES[material].mesh(name, material)
}

/// Returns the wall at −x, on which z grows to the right.
fn left_wall() -> Face {
    Face::new([-HALF_WIDTH, 0.0, 0.0], Vec3::Z)
}

/// Returns the wall at +x, on which z grows to the left.
fn right_wall() -> Face {
    Face::new([HALF_WIDTH, 0.0, 0.0], Vec3::NEG_Z)
}

/// Returns the end wall at +z, which faces the second hall.
fn end_wall() -> Face {
    Face::new([0.0, 0.0, ENDS_Z[1]], Vec3::X)
}

/// Returns the face of the partition wall that is seen from the first hall.
fn partition_face() -> Face {
    Face::new([0.0, 0.0, PARTITION_Z - 0.5 * PARTITION_M], Vec3::X)
}

/// Builds floor, ceiling, walls, the partition with its arch, a stone skirting, and a moulding below the ceiling.
fn shell() -> Vec<MeshBuilder> {
    let x = [-HALF_WIDTH, HALF_WIDTH];
    let mut floor = mesh("floor", FLOOR);
    let widened = |range: [f32; 2]| [range[0] - OVERLAP, range[1] + OVERLAP];
    floor.panel([Vec3::ZERO, Vec3::X, Vec3::Z], Rect::new(widened(x), widened(ENDS_Z)), &[]);
    let mut ceiling = mesh("ceiling", CEILING);
    let well = Rect::new(SKYLIGHT.0, [-SKYLIGHT.1[1], -SKYLIGHT.1[0]]);
    let ceiling_rect = Rect::new(widened(x), widened([-ENDS_Z[1], -ENDS_Z[0]]));
    ceiling.panel([HEIGHT * Vec3::Y, Vec3::X, Vec3::NEG_Z], ceiling_rect, &[well]);

    let mut walls = mesh("walls", WALL);
    let mut stone = mesh("mouldings", STONE);
    let heights = [0.0, HEIGHT];
    let door = standing_rect(-DOOR_Z, 1.5, 2.3);
    let first_end = Face::new([0.0, 0.0, ENDS_Z[0]], Vec3::NEG_X);
    // Each wall with its range to the right of its origin, and the hole of its door.
    let sides = [
        (left_wall(), ENDS_Z, None),
        (right_wall(), [-ENDS_Z[1], -ENDS_Z[0]], Some(door)),
        (end_wall(), x, None),
        (first_end, x, None),
    ];
    for (wall, span, hole) in sides {
        wall.wall(&mut walls, Rect::new(span, heights), hole.as_slice());
        wall.block(&mut stone, Rect::new(span, [HEIGHT - 0.22, HEIGHT - 0.08]), [0.0, 0.10]);
        wall.block(&mut stone, Rect::new(span, [HEIGHT - 0.08, HEIGHT]), [0.0, 0.18]);
        // The skirting leaves the door and its frame free.
        let feet = match hole {
            Some(door) => vec![[span[0], door.min.x - 0.15], [door.max.x + 0.15, span[1]]],
            None => vec![span],
        };
        for foot in feet {
            wall.block(&mut stone, Rect::new(foot, [0.0, 0.16]), [0.0, 0.03]);
        }
    }
    let partition = Wall { origin: PARTITION_Z * Vec3::Z, along: Vec3::X, thickness_m: PARTITION_M };
    masonry::arched_wall(&mut walls, &partition, x, heights, &[ARCH]);
    masonry::soffit(&mut stone, &partition, &ARCH, 0.0);
    masonry::archivolt(&mut stone, &partition, &ARCH, 0.22, 0.04);
    for side in [-1.0, 1.0] {
        let edge = ARCH.centre_m + side * (ARCH.half_width_m + 0.11);
        let jamb = Vec3::new(0.11, 0.0, 0.5 * PARTITION_M + 0.04);
        stone.cuboid(Vec3::new(edge, 0.0, PARTITION_Z) - jamb, Vec3::new(edge, ARCH.spring_m, PARTITION_Z) + jamb);
    }
    vec![floor, ceiling, walls, stone]
}

/// Builds the skylight: a well through the ceiling, glazing bars, and a pane that shows the sky.
fn skylight() -> Vec<MeshBuilder> {
    let (x, z) = SKYLIGHT;
    let top = HEIGHT + 0.8;
    let mut well = mesh("skylight-well", CEILING);
    let ring = |y: f32| [(x[0], z[0]), (x[1], z[0]), (x[1], z[1]), (x[0], z[1])].map(|(x, z)| Vec3::new(x, y, z));
    // The corners of the well at the ceiling and at its top.
    let (low, high) = (ring(HEIGHT), ring(top));
    let middle = Vec3::new(0.5 * (x[0] + x[1]), HEIGHT, 0.5 * (z[0] + z[1]));
    for k in 0..4 {
        let next = (k + 1) % 4;
        well.polygon(&[low[k], low[next], high[next], high[k]], middle - 0.5 * (low[k] + low[next]));
    }
    let mut bars = mesh("glazing-bars", METAL);
    for k in 0..=8 {
        let bar_z = z[0] + (z[1] - z[0]) * k as f32 / 8.0;
        bars.cuboid(Vec3::new(x[0], top - 0.1, bar_z - 0.03), Vec3::new(x[1], top - 0.02, bar_z + 0.03));
    }
    bars.cuboid(Vec3::new(-0.03, top - 0.1, z[0]), Vec3::new(0.03, top - 0.02, z[1]));
    let mut glass = mesh("skylight", WINDOW);
    glass.polygon(&high, Vec3::NEG_Y);
    vec![well, bars, glass]
}

/// A painting on a wall. Its mesh has the name `name` of the image, followed by `number`, the index of the painting.
struct HungPainting {
    name: &'static str,
    number: usize,
    material: usize,
    wall: Face,
    rect: Rect,
}

/// Lists all paintings. The first six hang in the first hall and have impostors.
fn hung_paintings() -> Vec<HungPainting> {
    let (left, right) = (left_wall(), right_wall());
    let back_of_partition = Face::new([0.0, 0.0, PARTITION_Z + 0.5 * PARTITION_M], Vec3::NEG_X);
    // Index of the image in `image_names`, wall, z of the middle (on a wall along x, its x), its height, and width.
    let places = [
        (0, left, -6.6, 1.9, 2.4),
        (2, left, -3.0, 1.9, 2.1),
        (3, left, 0.6, 1.9, 1.2),
        (1, right, -6.0, 1.9, 2.4),
        (2, right, -2.4, 1.9, 1.8),
        (1, partition_face(), 3.2, 1.9, 2.1),
        (3, end_wall(), -3.2, 1.95, 1.3),
        (0, end_wall(), 0.6, 1.95, 3.0),
        (2, left, 8.0, 1.9, 2.4),
        (1, right, 7.0, 1.9, 2.4),
        (3, back_of_partition, 3.6, 1.9, 1.3),
    ];
    let image_names = ["landscape", "ship", "fields", "portrait"];
    places
        .into_iter()
        .enumerate()
        .map(|(number, (image, wall, coordinate, y, width))| {
            // The wall's right is an axis of the world or its opposite, which may change the sign of the coordinate.
            let rightwards = coordinate * (wall.right.x + wall.right.z);
            let height_per_width = if image == 3 { 1.25 } else { 2.0 / 3.0 };
            let rect = centred_rect(rightwards, y, width, width * height_per_width);
            HungPainting { name: image_names[image], number, material: PAINTING + image, wall, rect }
        })
        .collect()
}

/// Builds the paintings with their frames.
fn paintings() -> Vec<MeshBuilder> {
    let mut frames = mesh("picture-frames", GILT);
    let mut parts: Vec<MeshBuilder> = hung_paintings()
        .iter()
        .map(|hung| {
            let mut painting = mesh(format!("{}-{}", hung.name, hung.number), hung.material);
            hung.wall.picture(&mut painting, hung.rect, 0.03);
            hung.wall.border(&mut frames, hung.rect, 0.10, [0.0, 0.05]);
            let inner = Rect { min: hung.rect.min - 0.05, max: hung.rect.max + 0.05 };
            hung.wall.border(&mut frames, inner, 0.03, [0.0, 0.075]);
            painting
        })
        .collect();
    parts.push(frames);
    parts
}

/// Returns the rectangle of the exit sign on the wall at +x.
fn exit_rect() -> Rect {
    centred_rect(-DOOR_Z, 2.78, 1.2, 0.4)
}

/// Builds the side door and the exit sign above it.
fn exit_door() -> Vec<MeshBuilder> {
    let wall = right_wall();
    let hole = standing_rect(-DOOR_Z, 1.5, 2.3);
    let mut frame = mesh("door-frame", STONE);
    wall.reveals(&mut frame, hole, 0.2);
    for edge in [hole.min.x - 0.075, hole.max.x + 0.075] {
        wall.block(&mut frame, standing_rect(edge, 0.15, 2.3), [0.0, 0.05]);
    }
    wall.block(&mut frame, Rect::new([hole.min.x - 0.15, hole.max.x + 0.15], [2.3, 2.45]), [0.0, 0.06]);
    let mut leaves = mesh("door", WOOD).turned();
    for side in [-1.0, 1.0] {
        let middle = -DOOR_Z + 0.375 * side;
        wall.block(&mut leaves, standing_rect(middle, 0.74, 2.3), [-0.2, -0.15]);
        for (y, height) in [(0.6, 0.8), (1.65, 0.9)] {
            wall.border(&mut leaves, centred_rect(middle, y, 0.44, height), 0.04, [-0.15, -0.13]);
        }
    }
    let mut case = mesh("exit-box", METAL);
    wall.block(&mut case, centred_rect(-DOOR_Z - 0.1, 2.78, 0.9, 0.3), [0.0, 0.11]);
    let mut sign = mesh("exit-sign", EXIT);
    wall.picture(&mut sign, exit_rect(), 0.12);
    vec![frame, leaves, case, sign]
}

/// Builds the skeleton on its platform, sculptures on plinths in the second hall, and two columns.
fn exhibits() -> Vec<MeshBuilder> {
    let mut stone = mesh("platforms", STONE);
    stone.cuboid(Vec3::new(-1.3, -OVERLAP, -6.2), Vec3::new(1.7, 0.22, -0.4));
    stone.cuboid(Vec3::new(-1.4, -OVERLAP, -6.3), Vec3::new(1.8, 0.08, -0.3));
    let mut bones = mesh("skeleton", BONE);
    skeleton::stand(&mut bones, Vec3::new(0.2, 0.22, -3.5));
    // Adds a plinth, and returns the middle of its top.
    let plinth = |stone: &mut MeshBuilder, x: f32, z: f32, height: f32| {
        for (half, low, high) in [(0.42, -OVERLAP, 0.12), (0.34, 0.12, height - 0.08), (0.40, height - 0.08, height)] {
            stone.cuboid(Vec3::new(x - half, low, z - half), Vec3::new(x + half, high, z + half));
        }
        Vec3::new(x, height, z)
    };
    let top = plinth(&mut stone, 0.4, 8.2, 0.9);
    let mut ring = mesh("ring", GILT);
    ring.tube([20, 48], Vec3::Z, |t| {
        let (sin, cos) = (2.0 * PI * t).sin_cos();
        (top + Vec3::new(0.42 * cos, 0.56 + 0.42 * sin, 0.12 * (2.0 * PI * t).sin()), 0.12)
    });
    let top = plinth(&mut stone, 3.4, 10.6, 0.8);
    let mut ball = mesh("ball", METAL);
    ball.sphere(top + 0.4 * Vec3::Y, 0.4, [40, 20]);
    for (x, z) in [(-4.4, 5.4), (4.4, 5.4)] {
        let column = ColumnSize { radius_m: 0.22, height_m: HEIGHT - 0.08, half_plinth_m: 0.36, sides: 28 };
        masonry::column(&mut stone, Vec3::new(x, 0.0, z), &column);
    }
    vec![stone, bones, ring, ball]
}

/// Builds the lamps: globes that hang from the ceiling on thin rods.
fn lamps() -> Vec<MeshBuilder> {
    let mut globes = mesh("lamps", LAMP);
    let mut rods = mesh("lamp-rods", METAL);
    for [x, z] in LAMPS {
        let middle = Vec3::new(x, LAMP_Y, z);
        globes.sphere(middle, LAMP_RADIUS, [20, 10]);
        rods.cylinder(middle + LAMP_RADIUS * Vec3::Y, 0.015, HEIGHT - LAMP_Y - LAMP_RADIUS, 8);
        rods.cylinder(middle + (LAMP_RADIUS - 0.03) * Vec3::Y, 0.09, 0.05, 16);
    }
    vec![globes, rods]
}

/// Builds benches in front of the paintings, ropes around the platform, and potted plants.
fn furniture() -> Vec<MeshBuilder> {
    let mut wood = mesh("benches", WOOD);
    for (x, z) in [(-3.6, -4.8), (3.9, -4.2)] {
        wood.cuboid(Vec3::new(x - 0.25, 0.40, z - 0.9), Vec3::new(x + 0.25, 0.47, z + 0.9));
        for end in [-0.7, 0.7] {
            wood.cuboid(Vec3::new(x - 0.22, 0.0, z + end - 0.04), Vec3::new(x + 0.22, 0.40, z + end + 0.04));
        }
    }
    let mut posts = mesh("posts", GILT);
    let mut ropes = mesh("ropes", WALL);
    let corners = [(-1.9, -6.7), (-1.9, -3.3), (-1.9, 0.1), (2.3, 0.1), (2.3, -3.3), (2.3, -6.7)];
    for (x, z) in corners {
        posts.cylinder(Vec3::new(x, 0.0, z), 0.14, 0.025, 20);
        posts.cylinder(Vec3::new(x, 0.02, z), 0.022, 0.88, 12);
        posts.sphere(Vec3::new(x, 0.93, z), 0.045, [12, 8]);
    }
    for k in 0..corners.len() {
        let [from, to] = [k, (k + 1) % corners.len()].map(|k| {
            let (x, z) = corners[k];
            Vec3::new(x, 0.86, z)
        });
        ropes.tube([6, 10], Vec3::Y, |t| (from.lerp(to, t) - 0.9 * t * (1.0 - t) * Vec3::Y, 0.018));
    }
    let mut pots = mesh("pots", STONE);
    let mut leaves = mesh("plants", LEAF);
    for (x, z) in [(-5.4, -8.4), (5.4, -8.4), (-5.4, 2.4), (5.4, 2.5), (-5.4, 12.4), (5.4, 12.4)] {
        let foot = Vec3::new(x, 0.0, z);
        pots.revolve(foot, [24, 8], |t| Vec2::new(0.16 + 0.1 * t, 0.45 * t));
        pots.disc(foot + 0.43 * Vec3::Y, 0.25, 24, Vec3::Y);
        for leaf in 0..11 {
            // Leaves follow each other at about the golden angle, 2.4 radians.
            let (sin, cos) = (leaf as f32 * 2.4).sin_cos();
            let spread = 0.22 + 0.28 * (leaf % 4) as f32 / 3.0;
            leaves.tube([5, 6], Vec3::new(sin, 0.0, -cos), |t| {
                let out_m = spread * t * (0.6 + 0.4 * t);
                let rise_m = 1.25 * t - spread * t * t;
                let point = foot + Vec3::new(out_m * cos, 0.42 + rise_m, out_m * sin);
                (point, 0.005 + 0.05 * (PI * t.clamp(0.0, 1.0)).sin())
            });
        }
    }
    vec![wood, posts, ropes, pots, leaves]
}
