//! `cathedral`: nave, aisles and choir with stained glass, after the third of Schmidt's scenes (2013, section 5.1,
//! figures 33, 50 and 51c). For a correction of parallax, the pillars and aisles cannot be approximated by a single
//! box.

use super::builder::{MeshBuilder, Rect, ordered};
use super::fittings::{Face, centred_rect, standing_rect};
use super::masonry::{self, Arch, ColumnSize, Wall};
use super::{Finish, materials, probe, thesis_lens, view};
use crate::{Light, Mesh, Scene};
use glam::{Vec2, Vec3};
use ssct_geometry::impostor_image;
use ssct_geometry::pattern::{Pattern, Picture, Wood};

// Indices of materials in `FINISHES`.
const FLOOR: usize = 0;
const WALL: usize = 1;
const PILLAR: usize = 2;
const VAULT: usize = 3;
const CHOIR: usize = 4;
const PEW: usize = 5;
const ALTAR: usize = 6;
const GOLD: usize = 7;
const ROSE: usize = 8;
/// The index of the first of three lancets.
const LANCET: usize = 9;

const FINISHES: [Finish; 12] = [
    Finish::new("floor", Pattern::Slabs, 0.0).reflecting(0.5, 0.02).smoothed(0.1),
    Finish::new("wall", Pattern::Limestone, 0.0).tinted(0.95, 0.90, 0.80),
    Finish::new("pillar", Pattern::Limestone, 0.0),
    Finish::new("vault", Pattern::Stucco, 0.0).tinted(0.62, 0.60, 0.56),
    Finish::new("choir-floor", Pattern::Wood(Wood::Middle), 0.0).reflecting(0.35, 0.05).smoothed(0.1),
    Finish::new("pew", Pattern::Wood(Wood::Dark), 0.0).reflecting(0.12, 0.1).smoothed(0.3),
    Finish::new("altar", Pattern::Limestone, 0.0).tinted(1.0, 0.95, 0.88),
    Finish::paint("gold", 0.62, 0.43, 0.12).reflecting(0.3, 0.1),
    Finish::picture("rose", Picture::Rose),
    Finish::picture("lancet-red", Picture::Lancet { design: 0 }),
    Finish::picture("lancet-gold", Picture::Lancet { design: 1 }),
    Finish::picture("lancet-green", Picture::Lancet { design: 2 }),
];

/// The number of bays of the nave along z; the choir follows them.
const BAYS: usize = 6;
/// Length of a bay along z, in metres.
const BAY_M: f32 = 5.0;
/// The z at which the nave ends and the choir begins, in metres; the nave begins at 0.
const NAVE_END: f32 = BAYS as f32 * BAY_M;
/// The z at which the choir ends, in metres.
const CHOIR_END: f32 = NAVE_END + 7.0;
/// Distance of the middle of the arcades' walls from the plane x = 0, in metres.
const ARCADE_X: f32 = 4.2;
/// Distance of the outer walls from the plane x = 0, in metres.
const OUTER_X: f32 = 8.4;
/// Thickness of the arcades' walls, in metres.
const ARCADE_M: f32 = 0.7;
/// Distance of the arcades' inner faces from the plane x = 0, in metres.
const NAVE_X: f32 = ARCADE_X - 0.5 * ARCADE_M;
/// Height at which the arches of the arcades begin, in metres.
const ARCADE_SPRING: f32 = 3.6;
/// Height at which the vaults of the aisles begin, in metres.
const AISLE_SPRING: f32 = 4.6;
/// Height at which the vault of the nave begins, in metres.
const NAVE_SPRING: f32 = 10.6;
/// Height of the nave's vault above the height at which it begins, in metres.
const NAVE_RISE: f32 = 3.2;
/// Height of the walls of nave and choir, in metres.
const TOP: f32 = NAVE_SPRING + NAVE_RISE + 0.1;
/// Height of the choir's floor above the nave's, in metres.
const CHOIR_STEP: f32 = 0.32;
/// Overlap of neighbouring geometry, in metres, so that no light shows through the joints.
const OVERLAP: f32 = 0.02;
/// Height of the middle of the rose window, in metres.
const ROSE_Y: f32 = 8.6;
/// Diameter of the rose window, in metres.
const ROSE_M: f32 = 5.2;

/// Builds the scene, with its meshes, materials, lights, views, probes and impostors.
pub fn scene() -> Scene {
    let (materials, textures) = materials(&FINISHES);
    let parts = [floors(), arcades(), outer_walls(), end_walls(), vaults(), pews(), choir(), windows()];
    let meshes: Vec<Mesh> = parts.into_iter().flatten().map(MeshBuilder::build).collect();
    let mut lights = Vec::new();
    let mut add_light = |x: f32, y: f32, z: f32, energy: f32| {
        lights.push(Light::Point { position: Vec3::new(x, y, z), energy });
    };
    for bay in 0..BAYS {
        add_light(0.0, 9.0, (bay as f32 + 0.5) * BAY_M, 13.0);
    }
    for z in [5.0, 15.0, 25.0] {
        add_light(6.6, 3.4, z, 7.0);
        add_light(-6.6, 3.4, z, 7.0);
    }
    add_light(0.0, ROSE_Y - 1.0, CHOIR_END - 3.2, 12.0);
    add_light(0.0, 4.0, CHOIR_END - 2.4, 5.0);
    let (nave_min, nave_max) = ([-NAVE_X, 0.0, 0.0], [NAVE_X, TOP, CHOIR_END]);
    let mut scene = Scene {
        name: "cathedral".to_owned(),
        meshes,
        materials,
        textures,
        lights,
        lens: thesis_lens(),
        views: vec![
            view("nave", [0.0, 1.7, 1.2], [0.0, 2.4, 14.0]),
            view("pillars", [-2.9, 1.5, 4.0], [4.6, 1.3, 15.0]),
            view("clerestory", [0.9, 2.6, 9.0], [-3.0, 3.2, 19.0]),
            view("rose", [0.0, 1.3, 19.5], [0.0, 1.6, 30.0]),
        ],
        probes: vec![
            probe("west", [0.0, 2.5, 7.5], nave_min, nave_max),
            probe("east", [0.0, 2.5, 22.5], nave_min, nave_max),
            probe("left-aisle", [-6.3, 2.0, 12.5], [-OUTER_X, 0.0, 0.0], [-ARCADE_X, 6.4, NAVE_END]),
            probe("right-aisle", [6.3, 2.0, 12.5], [ARCADE_X, 0.0, 0.0], [OUTER_X, 6.4, NAVE_END]),
        ],
        ..Scene::default()
    };
    for (mesh, frame) in impostors() {
        impostor_image::add(&mut scene, &[&mesh], &frame);
    }
    scene
}

/// Makes an empty mesh; `material` is an index into [`FINISHES`].
fn mesh(name: impl Into<String>, material: usize) -> MeshBuilder {
    FINISHES[material].mesh(name, material)
}

/// Returns the faces of the nave's left and right side walls that are seen from the nave.
fn nave_walls() -> [Face; 2] {
    [Face::new([-NAVE_X, 0.0, 0.0], Vec3::Z), Face::new([NAVE_X, 0.0, 0.0], Vec3::NEG_Z)]
}

/// Returns the face of the wall behind the choir that is seen from the nave.
fn east_wall() -> Face {
    Face::new([0.0, 0.0, CHOIR_END], Vec3::X)
}

/// Builds the floor of nave and aisles, the floor of the choir, and the steps between them.
fn floors() -> Vec<MeshBuilder> {
    let mut floor = mesh("floor", FLOOR);
    let widened = |half_width: f32| [-half_width - OVERLAP, half_width + OVERLAP];
    floor.panel([Vec3::ZERO, Vec3::X, Vec3::Z], Rect::new(widened(OUTER_X), [-OVERLAP, NAVE_END]), &[]);
    let mut choir = mesh("choir-floor", CHOIR).turned();
    let choir_rect = Rect::new(widened(ARCADE_X), [NAVE_END - 0.4, CHOIR_END + OVERLAP]);
    choir.panel([CHOIR_STEP * Vec3::Y, Vec3::X, Vec3::Z], choir_rect, &[]);
    let mut steps = mesh("choir-steps", PILLAR);
    for (front_z, height) in [(NAVE_END - 0.4, CHOIR_STEP - 0.005), (NAVE_END - 0.75, 0.5 * CHOIR_STEP)] {
        steps.cuboid(Vec3::new(-ARCADE_X, -OVERLAP, front_z), Vec3::new(ARCADE_X, height, NAVE_END));
    }
    vec![floor, choir, steps]
}

/// Builds the pillars, the arches between them, the walls above, and the shafts that rise to the vault.
fn arcades() -> Vec<MeshBuilder> {
    let mut wall = mesh("nave-walls", WALL);
    let mut stone = mesh("pillars", PILLAR);
    for x in [-ARCADE_X, ARCADE_X] {
        let arcade_wall = Wall { origin: x * Vec3::X, along: Vec3::Z, thickness_m: ARCADE_M };
        for bay in 0..BAYS {
            let z = bay as f32 * BAY_M;
            let arch = Arch { centre_m: z + 0.5 * BAY_M, half_width_m: 1.95, spring_m: ARCADE_SPRING, rise_m: 2.2 };
            masonry::arched_wall(&mut wall, &arcade_wall, [z, z + BAY_M], [ARCADE_SPRING, TOP], &[arch]);
            masonry::archivolt(&mut stone, &arcade_wall, &arch, 0.2, 0.06);
        }
        for pillar in 0..=BAYS {
            let foot = Vec3::new(x, 0.0, pillar as f32 * BAY_M);
            let size = ColumnSize { radius_m: 0.42, height_m: ARCADE_SPRING, half_plinth_m: 0.62, sides: 24 };
            masonry::column(&mut stone, foot, &size);
            let shaft = Vec3::new(x.signum() * (NAVE_X - 0.02), ARCADE_SPRING - 0.02, foot.z);
            stone.cylinder(shaft, 0.14, NAVE_SPRING - ARCADE_SPRING, 16);
            let cap = Vec3::new(0.24, 0.16, 0.24);
            stone.cuboid(
                shaft + (NAVE_SPRING - ARCADE_SPRING) * Vec3::Y - cap,
                shaft + (NAVE_SPRING - ARCADE_SPRING + 0.1) * Vec3::Y + Vec3::new(0.24, 0.0, 0.24),
            );
        }
    }
    // A horizontal moulding runs along both walls above the arches.
    for face in nave_walls() {
        let span = ordered(0.0, CHOIR_END * face.right.z);
        face.block(&mut stone, Rect::new(span, [6.55, 6.75]), [-0.05, 0.12]);
    }
    vec![wall, stone]
}

/// Builds the outer walls of the aisles with their mouldings, and the side walls of the choir.
fn outer_walls() -> Vec<MeshBuilder> {
    let mut wall = mesh("outer-walls", WALL);
    let mut stone = mesh("wall-mouldings", PILLAR);
    for side in [-1.0, 1.0] {
        let face = Face::new([side * OUTER_X, 0.0, 0.0], -side * Vec3::Z);
        // The range along the face between two z; the face's right is +z or −z.
        let range = |from_z: f32, to_z: f32| ordered(from_z * face.right.z, to_z * face.right.z);
        face.wall(&mut wall, Rect::new(range(0.0, NAVE_END), [0.0, 6.8]), &[]);
        face.block(&mut stone, Rect::new(range(0.0, NAVE_END), [0.0, 0.35]), [0.0, 0.12]);
        for pillar in 0..=BAYS {
            let middle = pillar as f32 * BAY_M * face.right.z;
            face.block(&mut stone, standing_rect(middle, 0.5, AISLE_SPRING), [-0.1, 0.22]);
        }
        let choir = Face::new([side * NAVE_X, 0.0, 0.0], -side * Vec3::Z);
        choir.wall(&mut wall, Rect::new(range(NAVE_END, CHOIR_END), [0.0, TOP]), &[]);
        // Adds the wall that closes the aisle at this z; `right` is its right, as seen from the aisle.
        let mut aisle_end = |z: f32, right: Vec3| {
            let span = ordered(side * NAVE_X * right.x, side * (OUTER_X + OVERLAP) * right.x);
            Face::new([0.0, 0.0, z], right).wall(&mut wall, Rect::new(span, [0.0, 6.8]), &[]);
        };
        aisle_end(0.0, Vec3::NEG_X);
        aisle_end(NAVE_END, Vec3::X);
    }
    vec![wall, stone]
}

/// Builds the west and east walls of the nave, and the west door.
fn end_walls() -> Vec<MeshBuilder> {
    let mut wall = mesh("end-walls", WALL);
    let across = Rect::new([-ARCADE_X - 0.4, ARCADE_X + 0.4], [0.0, TOP]);
    east_wall().wall(&mut wall, across, &[]);
    let west = Face::new([0.0, 0.0, 0.0], Vec3::NEG_X);
    west.wall(&mut wall, across, &[]);
    let mut stone = mesh("portal", PILLAR);
    west.border(&mut stone, standing_rect(0.0, 2.4, 3.4), 0.3, [-0.1, 0.15]);
    let mut door = mesh("door", PEW).turned();
    for leaf_x in [-0.6, 0.6] {
        west.block(&mut door, standing_rect(leaf_x, 1.18, 3.4), [-0.1, 0.06]);
        west.border(&mut door, centred_rect(leaf_x, 1.7, 0.7, 2.6), 0.06, [0.0, 0.09]);
    }
    vec![wall, stone, door]
}

/// Builds the vaults over nave, aisles and choir, with ribs between their bays.
fn vaults() -> Vec<MeshBuilder> {
    let mut vault = mesh("vaults", VAULT);
    let mut ribs = mesh("ribs", PILLAR);
    // Adds the vault over these ranges of x and z, which begins at the height `spring` and is `rise` high.
    let mut add_bay = |x: [f32; 2], z: [f32; 2], spring: f32, rise: f32| {
        masonry::groin_vault(&mut vault, [Vec2::new(x[0], z[0]), Vec2::new(x[1], z[1])], spring, rise, [20, 2]);
    };
    for bay in 0..BAYS {
        let z = [bay as f32 * BAY_M, (bay + 1) as f32 * BAY_M];
        add_bay([-ARCADE_X, ARCADE_X], z, NAVE_SPRING, NAVE_RISE);
        add_bay([-OUTER_X, -ARCADE_X], z, AISLE_SPRING, 1.9);
        add_bay([ARCADE_X, OUTER_X], z, AISLE_SPRING, 1.9);
    }
    add_bay([-ARCADE_X, ARCADE_X], [NAVE_END, CHOIR_END], NAVE_SPRING, NAVE_RISE);
    // Adds a rib across this range of x, at this z.
    let mut add_rib = |x: [f32; 2], z: f32, spring: f32, rise: f32| {
        let rib_wall = Wall { origin: z * Vec3::Z, along: Vec3::X, thickness_m: 0.34 };
        let arch = Arch {
            centre_m: 0.5 * (x[0] + x[1]),
            half_width_m: 0.5 * (x[1] - x[0]) - 0.3,
            spring_m: spring,
            rise_m: rise - 0.3,
        };
        masonry::arched_wall(&mut ribs, &rib_wall, x, [spring, spring + rise], &[arch]);
        masonry::soffit(&mut ribs, &rib_wall, &arch, spring);
    };
    for bays_before in 1..=BAYS {
        let z = bays_before as f32 * BAY_M;
        add_rib([-NAVE_X, NAVE_X], z, NAVE_SPRING, NAVE_RISE);
        if bays_before < BAYS {
            add_rib([-OUTER_X, -ARCADE_X - 0.3], z, AISLE_SPRING, 1.9);
            add_rib([ARCADE_X + 0.3, OUTER_X], z, AISLE_SPRING, 1.9);
        }
    }
    vec![vault, ribs]
}

/// Builds pews on both sides of a free way through the middle of the nave.
fn pews() -> Vec<MeshBuilder> {
    let mut wood = mesh("pews", PEW);
    for row in 0..9 {
        let z = 7.0 + 1.15 * row as f32;
        for side in [-1.0_f32, 1.0] {
            let [left, right] = ordered(side * 1.25, side * 3.35);
            wood.cuboid(Vec3::new(left, 0.42, z), Vec3::new(right, 0.47, z + 0.42));
            wood.cuboid(Vec3::new(left, 0.42, z - 0.05), Vec3::new(right, 0.92, z));
            for end in [left, right] {
                wood.cuboid(Vec3::new(end - 0.04, 0.0, z - 0.08), Vec3::new(end + 0.04, 0.98, z + 0.46));
            }
        }
    }
    vec![wood]
}

/// Builds the altar with a cross and two candlesticks, on the floor of the choir.
fn choir() -> Vec<MeshBuilder> {
    let z = CHOIR_END - 2.6;
    let mut altar = mesh("altar", ALTAR);
    // Adds a box in the middle of the choir, over this range of heights above its floor.
    let block = |mesh: &mut MeshBuilder, half_width: f32, y: [f32; 2], half_depth: f32| {
        let min = Vec3::new(-half_width, CHOIR_STEP + y[0], z - half_depth);
        mesh.cuboid(min, Vec3::new(half_width, CHOIR_STEP + y[1], z + half_depth));
    };
    block(&mut altar, 1.5, [-OVERLAP, 0.16], 0.9);
    block(&mut altar, 1.0, [0.16, 1.0], 0.4);
    block(&mut altar, 1.15, [1.0, 1.1], 0.5);
    let mut gold = mesh("cross", GOLD);
    block(&mut gold, 0.16, [1.1, 1.16], 0.12);
    block(&mut gold, 0.035, [1.16, 2.1], 0.03);
    block(&mut gold, 0.28, [1.72, 1.79], 0.03);
    for x in [-0.75, 0.75] {
        let foot = Vec3::new(x, CHOIR_STEP + 1.1, z);
        gold.revolve(foot, [16, 8], |t| Vec2::new(0.10 - 0.08 * (t * 3.0).clamp(0.0, 1.0), 0.42 * t));
        gold.sphere(foot + 0.42 * Vec3::Y, 0.05, [12, 8]);
        altar.cylinder(foot + 0.44 * Vec3::Y, 0.028, 0.34, 12);
    }
    vec![altar, gold]
}

/// A window: its wall, its rectangle on this wall, the material that shows its design, and the name of its mesh.
struct Window {
    wall: Face,
    rect: Rect,
    material: usize,
    name: String,
}

/// Lists the lancets: those of the clerestory (the row above the arcades), of the aisles and of the choir.
fn lancets() -> Vec<Window> {
    let mut lancets = Vec::new();
    // `coordinate` is the z of the window's middle or, on the east wall, the x; `y` is the height of the middle. Where
    // the wall's right is −z, the sign of the coordinate changes.
    let mut add = |wall: Face, coordinate: f32, y: f32, height: f32, design: usize, name: &str| {
        let rightwards = coordinate * (wall.right.x + wall.right.z);
        let rect = centred_rect(rightwards, y, height * 0.375, height);
        lancets.push(Window { wall, rect, material: LANCET + design % 3, name: format!("{name}-{}", lancets.len()) });
    };
    for (side, wall) in nave_walls().into_iter().enumerate() {
        let outer = Face::new([wall.origin.x.signum() * OUTER_X, 0.0, 0.0], wall.right);
        for bay in 0..BAYS {
            let z = (bay as f32 + 0.5) * BAY_M;
            add(wall, z - 0.75, 8.9, 3.3, bay + side, "clerestory");
            add(wall, z + 0.75, 8.9, 3.3, bay + side + 1, "clerestory");
            add(outer, z, 3.1, 3.3, bay + 2 * side, "aisle");
        }
        add(wall, NAVE_END + 3.5, 8.0, 4.4, side, "choir-side");
    }
    for (number, x) in [-1.9, 0.0, 1.9].into_iter().enumerate() {
        add(east_wall(), x, 3.9, if number == 1 { 3.6 } else { 3.0 }, number + 1, "east");
    }
    lancets
}

/// Builds the rose and the lancets, each as a pane just in front of its wall; the lancets have sills of stone.
fn windows() -> Vec<MeshBuilder> {
    let mut stone = mesh("window-sills", PILLAR);
    let mut parts = Vec::new();
    for window in lancets() {
        let mut pane = mesh(window.name.as_str(), window.material);
        window.wall.picture(&mut pane, window.rect, 0.03);
        let (low, high) = (window.rect.min, window.rect.max);
        let sill = Rect::new([low.x - 0.12, high.x + 0.12], [low.y - 0.14, low.y]);
        window.wall.block(&mut stone, sill, [0.0, 0.16]);
        parts.push(pane);
    }
    let mut rose = mesh("rose", ROSE);
    east_wall().picture(&mut rose, rose_rect(), 0.03);
    parts.extend([rose, stone]);
    parts
}

/// Returns the rectangle of the rose window on the east wall.
fn rose_rect() -> Rect {
    centred_rect(0.0, ROSE_Y, ROSE_M, ROSE_M)
}

/// Returns the name of the mesh and the frame of each impostor: the rose, the lancets below it, and the clerestory
/// windows of the two bays in front of the choir.
fn impostors() -> Vec<(String, ssct_geometry::impostor_image::ImpostorFrame)> {
    let mut impostors = vec![("rose".to_owned(), east_wall().portrait("rose", rose_rect(), 0.03, 512))];
    for window in lancets() {
        let z = window.wall.point_at(window.rect.min.x, 0.0, 0.0).z;
        let label = if window.name.starts_with("east") {
            "east window"
        } else if window.name.starts_with("clerestory") && z > NAVE_END - 2.0 * BAY_M {
            "clerestory window"
        } else {
            continue;
        };
        impostors.push((window.name.clone(), window.wall.portrait(label, window.rect, 0.03, 96)));
    }
    impostors
}
