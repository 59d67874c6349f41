//! `street`: a street after rain between two rows of houses, after the first of Schmidt's scenes (2013, section 5.1,
//! figures 27, 32, 36, 39, 41 and 51a). Signs and a cinema are reflected in wet asphalt, and a parked car hides parts
//! of them from the road.

mod house;

use super::builder::{MeshBuilder, Rect, ordered};
use super::fittings::{Face, centred_rect};
use super::{Finish, car, materials, probe, thesis_lens, view};
use crate::{AreaLight, AreaShape, Light, Mesh, Scene};
use glam::{Vec2, Vec3};
use house::{Ground, HouseFront};
use ssct_geometry::impostor_image;
use ssct_geometry::pattern::{Painting, Pattern, Picture, Sign, SignOutline, Text, Wood};

// Indices of materials in `FINISHES`.
const ROAD: usize = 0;
const PAVEMENT: usize = 1;
const KERB: usize = 2;
const BRICKS: usize = 3;
const TEAL: usize = 4;
const OCHRE: usize = 5;
const STONE: usize = 6;
pub const TRIM: usize = 7;
pub const DARK_PANE: usize = 8;
pub const LIT_PANE: usize = 9;
pub const SHOP: usize = 10;
pub const DOOR: usize = 11;
const METAL: usize = 12;
const LAMP: usize = 13;
/// The index of the first of two neon colours.
const NEON_PAINT: usize = 14;
const RED_PAINT: usize = 16;
const BLUE_PAINT: usize = 17;
/// Index of the dark glass of cars and of the cinema's doors.
pub const DARK_GLASS: usize = 18;
const RUBBER: usize = 19;
const TAIL_LAMP: usize = 20;
const LINE: usize = 21;
const CINEMA: usize = 22;
const HOTEL: usize = 23;
const BAR: usize = 24;
const CAFE: usize = 25;
/// The index of the first of two posters.
const POSTER: usize = 26;

const FINISHES: [Finish; 28] = [
    Finish::new("road", Pattern::Asphalt, 0.0).reflecting(0.8, 0.05),
    Finish::new("pavement", Pattern::Slabs, 0.0).reflecting(0.16, 0.1).smoothed(0.5),
    Finish::paint("kerb", 0.24, 0.23, 0.22).reflecting(0.1, 0.1),
    Finish::new("bricks", Pattern::Bricks, 0.0),
    Finish::new("teal", Pattern::Plaster, 0.0).tinted(0.30, 0.52, 0.58),
    Finish::new("ochre", Pattern::Plaster, 0.0).tinted(1.0, 0.80, 0.50),
    Finish::new("stone", Pattern::Limestone, 0.0).tinted(0.85, 0.85, 0.88),
    Finish::paint("trim", 0.46, 0.44, 0.40),
    Finish::picture("dark-pane", Picture::Pane { lit: false }).reflecting(0.35, 0.0),
    Finish::picture("lit-pane", Picture::Pane { lit: true }).reflecting(0.1, 0.0),
    Finish::picture("shop", Picture::Shop).reflecting(0.3, 0.0),
    Finish::new("door", Pattern::Wood(Wood::Dark), 0.0).reflecting(0.1, 0.1),
    Finish::paint("metal", 0.05, 0.055, 0.06).reflecting(0.25, 0.08),
    Finish::paint("lamp", 1.0, 0.93, 0.74),
    Finish::paint("neon-pink", 1.0, 0.22, 0.52),
    Finish::paint("neon-cyan", 0.22, 0.90, 1.0),
    Finish::paint("red-paint", 0.45, 0.02, 0.02).reflecting(0.35, 0.03),
    Finish::paint("blue-paint", 0.03, 0.07, 0.26).reflecting(0.35, 0.03),
    Finish::paint("dark-glass", 0.02, 0.024, 0.028).reflecting(0.6, 0.0),
    Finish::paint("rubber", 0.02, 0.02, 0.021),
    Finish::paint("tail-lamp", 0.62, 0.02, 0.02).reflecting(0.2, 0.02),
    Finish::paint("line", 0.55, 0.54, 0.50).reflecting(0.25, 0.08),
    Finish::picture("cinema", Picture::Sign(&CINEMA_SIGN)),
    Finish::picture("hotel", Picture::Sign(&HOTEL_SIGN)),
    Finish::picture("bar", Picture::Sign(&BAR_SIGN)),
    Finish::picture("cafe", Picture::Sign(&CAFE_SIGN)),
    Finish::picture("poster-ship", Picture::Painting(Painting::Ship)),
    Finish::picture("poster-portrait", Picture::Painting(Painting::Portrait)),
];

const CINEMA_SIGN: Sign = Sign {
    text: Text { letters: "CINEMA", stacked: false },
    cut: SignOutline::Plate,
    ink: Vec3::new(1.0, 0.92, 0.30),
    ground: Vec3::new(0.30, 0.01, 0.015),
    bulbs: true,
    size: [768, 144],
};
const HOTEL_SIGN: Sign = Sign {
    text: Text { letters: "HOTEL", stacked: true },
    cut: SignOutline::Slant,
    ink: Vec3::new(0.35, 0.92, 1.0),
    ground: Vec3::new(0.005, 0.02, 0.09),
    bulbs: false,
    size: [128, 512],
};
const BAR_SIGN: Sign = Sign {
    text: Text { letters: "BAR", stacked: false },
    cut: SignOutline::Arrow,
    ink: Vec3::new(1.0, 0.35, 0.62),
    ground: Vec3::new(0.05, 0.0, 0.05),
    bulbs: false,
    size: [320, 128],
};
const CAFE_SIGN: Sign = Sign {
    text: Text { letters: "CAFE", stacked: false },
    cut: SignOutline::Plate,
    ink: Vec3::new(0.98, 0.95, 0.85),
    ground: Vec3::new(0.02, 0.22, 0.06),
    bulbs: false,
    size: [448, 128],
};

/// Half the width of the road, in metres: the kerbs are at ±x.
const KERB_X: f32 = 4.0;
/// Distance of the house fronts from the plane x = 0, in metres.
const HOUSE_X: f32 = 6.6;
/// The z of the street's two ends, in metres.
const ENDS_Z: [f32; 2] = [-8.0, 40.0];
/// Height of the kerbs and of the pavement, in metres.
const KERB_M: f32 = 0.14;
/// The height of the tallest houses, in metres.
const TOP: f32 = 14.2;
/// The points on the ground below the middles of the two parked cars.
const CAR: Vec3 = Vec3::new(-2.9, 0.0, 8.4);
const SECOND_CAR: Vec3 = Vec3::new(2.95, 0.0, 19.5);
/// The x and z of the posts of the street lamps, in metres.
const LAMPS: [[f32; 2]; 6] = [[-4.4, 4.4], [4.4, 2.6], [-4.4, 14.5], [4.4, 22.0], [-4.4, 29.0], [4.4, 35.0]];
/// Height of the lamps' globes, in metres.
const GLOBE_Y: f32 = 4.3;
/// Distance of the globes from their posts, towards the road, in metres.
const GLOBE_REACH: f32 = 0.55;
/// Radius of the lamps' globes, in metres.
const GLOBE_RADIUS: f32 = 0.19;
/// The range of the cinema's canopy along the house fronts, and its range of heights, in metres.
const CANOPY: Rect = Rect { min: Vec2::new(7.6, 3.35), max: Vec2::new(14.4, 4.60) };
/// Projection of the canopy from the house fronts, in metres.
const CANOPY_OUT: f32 = 1.6;

/// Builds the scene, with its meshes, materials, lights, views, probes and impostors.
pub fn scene() -> Scene {
    let (materials, textures) = materials(&FINISHES);
    let mut parts = vec![ground(), cinema(), signs(), lamps()];
    parts.extend(fronts().iter().map(house::build));
    let paints = [(CAR, RED_PAINT), (SECOND_CAR, BLUE_PAINT)];
    parts.extend(paints.map(|(position, paint)| car::parked_car(position, &car_materials(paint))));
    let meshes: Vec<Mesh> = parts.into_iter().flatten().map(MeshBuilder::build).collect();
    let (min, max) = ([-HOUSE_X, 0.0, ENDS_Z[0]], [HOUSE_X, TOP, ENDS_Z[1]]);
    let mut scene = Scene {
        name: "street".to_owned(),
        meshes,
        materials,
        textures,
        lights: lights(),
        lens: thesis_lens(),
        views: vec![
            view("street", [1.3, 1.6, -4.5], [-0.9, 1.15, 10.0]),
            view("car", [2.4, 1.55, 3.4], [-3.2, 0.75, 8.8]),
            view("puddles", [0.9, 0.5, 1.0], [-0.5, 0.2, 12.0]),
            view("signs", [-1.4, 1.6, 3.0], [4.6, 1.6, 13.0]),
            view("bonnet", [0.2, 1.45, 12.6], [-3.6, 0.75, 8.6]),
        ],
        probes: [("south", -1.0), ("cinema", 11.0), ("north", 27.0)]
            .map(|(name, z)| probe(name, [0.0, 2.0, z], min, max))
            .into(),
        area_lights: area_lights(),
        ..Scene::default()
    };
    add_impostors(&mut scene);
    scene
}

/// Makes an empty mesh; `material` is an index into [`FINISHES`].
fn mesh(name: impl Into<String>, material: usize) -> MeshBuilder {
    FINISHES[material].mesh(name, material)
}

/// Returns the materials of a car whose body has the material `paint`.
fn car_materials(paint: usize) -> car::Materials {
    car::Materials { paint, glass: DARK_GLASS, dark: RUBBER, chrome: METAL, tail_lamp: TAIL_LAMP }
}

/// Returns the plane of the house fronts at −x, on which z grows to the right.
fn left_fronts() -> Face {
    Face::new([-HOUSE_X, 0.0, 0.0], Vec3::Z)
}

/// Returns the plane of the house fronts at +x, on which z grows to the left.
fn right_fronts() -> Face {
    Face::new([HOUSE_X, 0.0, 0.0], Vec3::NEG_Z)
}

/// Returns the fronts of all houses. The first five have impostors.
fn fronts() -> [HouseFront; 8] {
    let north = Face::new([0.0, 0.0, ENDS_Z[1]], Vec3::X);
    let south = Face::new([0.0, 0.0, ENDS_Z[0]], Vec3::NEG_X);
    // Makes a front; `span` is its range along the face, in metres to the right of the face's origin.
    let front = |name, face, span, height, material: usize, ground| HouseFront {
        name,
        face,
        span,
        height,
        wall: FINISHES[material].mesh("", material),
        ground,
    };
    let across = [-HOUSE_X, HOUSE_X];
    [
        front("bricks-left", left_fronts(), [-8.0, 5.6], 13.6, BRICKS, Ground::Shops),
        front("cinema", left_fronts(), [5.6, 16.4], 11.0, TEAL, Ground::Cinema),
        front("stone-left", left_fronts(), [16.4, 40.0], TOP, STONE, Ground::Shops),
        front("cafe", right_fronts(), [-9.4, 8.0], 11.2, OCHRE, Ground::Shops),
        front("hotel", right_fronts(), [-24.6, -9.4], TOP, BRICKS, Ground::Doors),
        front("stone-right", right_fronts(), [-40.0, -24.6], 11.4, STONE, Ground::Doors),
        front("north", north, across, 12.4, OCHRE, Ground::Doors),
        front("south", south, across, 11.0, BRICKS, Ground::Doors),
    ]
}

/// Returns the point lights and a faint directional light. The point lights are below the globes of the lamps, at the
/// cinema and at the signs.
fn lights() -> Vec<Light> {
    let point = |x: f32, y: f32, z: f32, energy: f32| Light::Point { position: Vec3::new(x, y, z), energy };
    let globe = |[x, z]: [f32; 2]| point(x - x.signum() * GLOBE_REACH, GLOBE_Y - 0.55, z, 4.0);
    let mut lights = vec![Light::Directional { direction: Vec3::new(0.30, -0.80, 0.52).normalize(), energy: 0.30 }];
    lights.extend(LAMPS.map(globe));
    // The front of the canopy.
    let canopy_x = -HOUSE_X + CANOPY_OUT;
    lights.extend([
        point(canopy_x + 1.1, 4.0, 9.3, 4.0),
        point(canopy_x + 1.1, 4.0, 12.7, 4.0),
        point(canopy_x - 0.4, 2.7, 11.0, 3.0),
        point(5.6, 8.1, 10.7, 3.0),
        point(5.6, 6.3, 10.7, 3.0),
        point(-5.6, 3.2, 1.9, 2.0),
        point(5.3, 3.4, 2.9, 3.0),
        point(5.3, 3.4, 4.7, 2.0),
    ]);
    lights
}

/// Returns the globes of the lamps and the two neon tubes as area lights.
fn area_lights() -> Vec<AreaLight> {
    let globe = |[x, z]: [f32; 2]| AreaLight {
        shape: AreaShape::Sphere { centre: Vec3::new(x - x.signum() * GLOBE_REACH, GLOBE_Y, z), radius: GLOBE_RADIUS },
        radiance: Vec3::new(1.0, 0.93, 0.74),
    };
    let mut lights = LAMPS.map(globe).to_vec();
    for (tube, radiance) in NEON.iter().zip([Vec3::new(1.0, 0.22, 0.52), Vec3::new(0.22, 0.90, 1.0)]) {
        let [a, b] = *tube;
        lights.push(AreaLight { shape: AreaShape::Capsule { a, b, radius: NEON_RADIUS }, radiance });
    }
    lights
}

/// The two ends of each neon tube: one tube runs below the edge of the canopy, one up the corner of the hotel.
const NEON: [[Vec3; 2]; 2] = [
    [
        Vec3::new(-HOUSE_X + CANOPY_OUT + 0.05, CANOPY.min.y - 0.05, CANOPY.min.x),
        Vec3::new(-HOUSE_X + CANOPY_OUT + 0.05, CANOPY.min.y - 0.05, CANOPY.max.x),
    ],
    [Vec3::new(HOUSE_X - 0.12, 4.6, 14.0), Vec3::new(HOUSE_X - 0.12, 10.6, 14.0)],
];
/// Radius of the neon tubes, in metres.
const NEON_RADIUS: f32 = 0.05;

/// Builds the road with its markings and manhole covers, kerbs and pavements.
fn ground() -> Vec<MeshBuilder> {
    let mut road = mesh("road", ROAD);
    let z = [ENDS_Z[0] - 0.02, ENDS_Z[1] + 0.02];
    road.panel([Vec3::ZERO, Vec3::X, Vec3::Z], Rect::new([-KERB_X, 0.0], z), &[]);
    // The second lane is turned by a quarter, so that its puddles differ from those of the first lane.
    let mut lane = mesh("second-lane", ROAD).turned();
    lane.panel([Vec3::ZERO, Vec3::X, Vec3::Z], Rect::new([0.0, KERB_X], z), &[]);
    let mut pavement = mesh("pavement", PAVEMENT);
    let mut kerb = mesh("kerbs", KERB);
    for side in [-1.0, 1.0] {
        let pavement_x = ordered(side * (KERB_X + 0.15), side * (HOUSE_X + 0.3));
        pavement.panel([KERB_M * Vec3::Y, Vec3::X, Vec3::Z], Rect::new(pavement_x, z), &[]);
        let [kerb_min_x, kerb_max_x] = ordered(side * KERB_X, side * (KERB_X + 0.15));
        let mut from = z[0];
        while from < z[1] {
            let to = (from + 1.2).min(z[1]);
            kerb.cuboid(Vec3::new(kerb_min_x, -0.02, from + 0.006), Vec3::new(kerb_max_x, KERB_M + 0.006, to - 0.006));
            from = to;
        }
    }
    let mut line = mesh("road-markings", LINE);
    for number in 0..12 {
        let from = ENDS_Z[0] + 1.0 + 4.0 * number as f32;
        let stripe = Rect::new([-0.07, 0.07], [from, from + 1.8]);
        line.panel([0.004 * Vec3::Y, Vec3::X, Vec3::Z], stripe, &[]);
    }
    let mut cover = mesh("manhole-covers", METAL);
    for (x, z) in [(1.9, 2.6), (-1.3, 15.0), (2.2, 26.0)] {
        cover.cylinder(Vec3::new(x, -0.02, z), 0.34, 0.026, 32);
    }
    vec![road, lane, pavement, kerb, line, cover]
}

/// Builds the canopy above the cinema's entrance with its sign, the posters beside the entrance, and the neon tubes.
fn cinema() -> Vec<MeshBuilder> {
    let face = left_fronts();
    let mut canopy = mesh("canopy", METAL);
    face.block(&mut canopy, CANOPY, [-0.05, CANOPY_OUT - 0.01]);
    let mut sign = mesh("cinema-sign", CINEMA);
    face.picture(&mut sign, cinema_rect(), CANOPY_OUT);
    let mut trim = mesh("canopy-trim", TRIM);
    for y in [CANOPY.min.y - 0.03, CANOPY.max.y] {
        let strip = Rect::new([CANOPY.min.x - 0.03, CANOPY.max.x + 0.03], [y, y + 0.04]);
        face.block(&mut trim, strip, [0.0, CANOPY_OUT + 0.02]);
    }
    let mut parts = vec![canopy, sign, trim];
    for (number, rect) in poster_rects().into_iter().enumerate() {
        let mut frame = mesh("poster-frames", METAL);
        face.border(&mut frame, rect, 0.07, [0.0, 0.06]);
        let mut poster = mesh(POSTERS[number], POSTER + number);
        face.picture(&mut poster, rect, 0.03);
        parts.extend([frame, poster]);
    }
    for (number, [a, b]) in NEON.into_iter().enumerate() {
        let mut tube = mesh("neon", NEON_PAINT + number);
        tube.tube([12, 1], Vec3::X, |t| (a.lerp(b, t), NEON_RADIUS));
        tube.sphere(a, NEON_RADIUS, [12, 8]);
        tube.sphere(b, NEON_RADIUS, [12, 8]);
        parts.push(tube);
    }
    parts
}

/// The names of the posters' meshes.
const POSTERS: [&str; 2] = ["poster-ship", "poster-portrait"];

/// Returns the rectangle of the cinema's sign on the front of the canopy, with the aspect ratio of its image.
fn cinema_rect() -> Rect {
    centred_rect(0.5 * (CANOPY.min.x + CANOPY.max.x), 0.5 * (CANOPY.min.y + CANOPY.max.y), 6.2, 6.2 * 144.0 / 768.0)
}

/// Returns the rectangles of the posters on the fronts at −x.
fn poster_rects() -> [Rect; 2] {
    [centred_rect(7.05, 1.75, 1.9, 1.27), centred_rect(14.9, 1.75, 1.2, 1.5)]
}

/// A sign that projects from the houses at a right angle: name, material, plane and rectangle.
struct BladeSign {
    name: &'static str,
    material: usize,
    face: Face,
    rect: Rect,
}

/// Returns the signs that project from the houses: that of the hotel and that of the bar.
fn blades() -> [BladeSign; 2] {
    let across = |z: f32| Face::new([0.0, 0.0, z], Vec3::X);
    [
        BladeSign { name: "hotel-sign", material: HOTEL, face: across(11.4), rect: centred_rect(5.75, 7.2, 1.2, 4.8) },
        BladeSign { name: "bar-sign", material: BAR, face: across(2.6), rect: centred_rect(-5.55, 3.3, 1.75, 0.7) },
    ]
}

/// Returns the rectangle of the café's sign on the fronts at +x, with the aspect ratio of its image.
fn cafe_rect() -> Rect {
    centred_rect(-3.8, 3.53, 2.24, 2.24 * 128.0 / 448.0)
}

/// Builds the signs on the houses and the rods that carry them; the projecting signs also have a back side.
fn signs() -> Vec<MeshBuilder> {
    let mut parts = Vec::new();
    let mut rods = mesh("sign-rods", METAL);
    for blade in blades() {
        let mut front = mesh(blade.name, blade.material);
        blade.face.picture(&mut front, blade.rect, 0.0);
        let behind = Face { origin: blade.face.origin + 0.04 * Vec3::Z, right: -blade.face.right };
        let mirrored = Rect::new([-blade.rect.max.x, -blade.rect.min.x], [blade.rect.min.y, blade.rect.max.y]);
        let mut back = mesh(format!("{}-back", blade.name), blade.material);
        behind.picture(&mut back, mirrored, 0.0);
        let (low, high) = (blade.rect.min, blade.rect.max);
        let wall_x = HOUSE_X * low.x.signum();
        for y in [low.y + 0.3 * (high.y - low.y), high.y - 0.12 * (high.y - low.y)] {
            let (from, to) = (wall_x.min(low.x + 0.3), wall_x.max(high.x - 0.3));
            let z = blade.face.origin.z + 0.02;
            rods.cuboid(Vec3::new(from, y - 0.015, z - 0.012), Vec3::new(to, y + 0.015, z + 0.012));
        }
        parts.extend([front, back]);
    }
    let mut cafe = mesh("cafe-sign", CAFE);
    right_fronts().picture(&mut cafe, cafe_rect(), 0.08);
    let mut board = mesh("cafe-board", METAL);
    right_fronts().block(&mut board, centred_rect(-3.8, 3.53, 2.0, 0.5), [-0.05, 0.07]);
    parts.extend([rods, cafe, board]);
    parts
}

/// Builds the street lamps: posts with an arm over the road and a globe.
fn lamps() -> Vec<MeshBuilder> {
    let mut posts = mesh("lamp-posts", METAL);
    let mut globes = mesh("lamps", LAMP);
    for [x, z] in LAMPS {
        let foot = Vec3::new(x, KERB_M, z);
        posts.cylinder(foot, 0.09, 0.9, 20);
        posts.cylinder(foot, 0.055, GLOBE_Y, 16);
        let top = foot + GLOBE_Y * Vec3::Y;
        let globe = Vec3::new(x - x.signum() * GLOBE_REACH, GLOBE_Y, z);
        posts.tube([10, 12], Vec3::Z, |t| {
            let (sin, cos) = (0.5 * std::f32::consts::PI * t).sin_cos();
            let reach = globe + (GLOBE_RADIUS + 0.04) * Vec3::Y - top;
            (top + Vec3::new(reach.x * (1.0 - cos), reach.y + 0.35 * sin - 0.35 * (1.0 - cos), 0.0), 0.03)
        });
        posts.cylinder(globe + (GLOBE_RADIUS - 0.03) * Vec3::Y, 0.1, 0.05, 16);
        globes.sphere(globe, GLOBE_RADIUS, [24, 12]);
    }
    vec![posts, globes]
}

/// Adds the impostors, from the farthest from the road to the nearest, because Schmidt's listing (2013) keeps the last
/// impostor that a ray hits.
fn add_impostors(scene: &mut Scene) {
    for front in fronts().iter().take(5) {
        let names = house::mesh_names(front.name);
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let rect = Rect::new(front.span, [0.0, front.height]);
        impostor_image::add(scene, &names, &front.face.portrait(front.name, rect, 0.0, 320));
    }
    for (name, rect) in POSTERS.into_iter().zip(poster_rects()) {
        impostor_image::add(scene, &[name], &left_fronts().portrait(name, rect, 0.03, 192));
    }
    impostor_image::add(scene, &["cafe-sign"], &right_fronts().portrait("cafe sign", cafe_rect(), 0.08, 384));
    for blade in blades() {
        impostor_image::add(scene, &[blade.name], &blade.face.portrait(blade.name, blade.rect, 0.0, 192));
    }
    impostor_image::add(
        scene,
        &["cinema-sign"],
        &left_fronts().portrait("cinema sign", cinema_rect(), CANOPY_OUT, 512),
    );
    let side = Face::new([CAR.x, 0.0, CAR.z], Vec3::Z);
    let outline = Rect::new([-0.52 * car::SIZE.z, 0.52 * car::SIZE.z], [0.0, 1.02 * car::SIZE.y]);
    impostor_image::add(scene, &car::MESH_NAMES, &side.portrait("car", outline, 0.0, 320));
}
