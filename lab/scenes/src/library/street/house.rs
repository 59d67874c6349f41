//! The fronts of houses: windows in several storeys, a cornice, and the ground floor.

use super::{DARK_GLASS, DARK_PANE, DOOR, LIT_PANE, SHOP, TRIM};
use crate::library::builder::{MeshBuilder, Rect};
use crate::library::fittings::{Face, centred_rect};
use glam::{IVec2, Vec3};
use ssct_ground::math::noise::unit;

/// Heights of the ground floor and of each storey above it.
const GROUND_M: f32 = 4.0;
const STOREY_M: f32 = 3.15;
/// Width and height of a window, and the height of its sill above the storey's floor.
const WINDOW: [f32; 3] = [1.15, 1.75, 0.85];
/// Least width of a bay; each bay has one opening a storey.
const BAY_M: f32 = 2.55;
/// Depth of the openings in the wall.
const RECESS_M: f32 = 0.2;
/// Depth of a house; its gables show where they rise above lower neighbours.
const DEPTH_M: f32 = 7.0;
/// The share of windows with a lit room.
const LIT: f32 = 0.3;

/// The kinds of ground floor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ground {
    /// Shop windows with doors between.
    Shops,
    /// Doors, and windows like those of the storeys above.
    Doors,
    /// An entrance with glass doors in the middle.
    Cinema,
}

/// A house as seen from the street.
pub struct HouseFront {
    /// First part of the names of the house's meshes.
    pub name: &'static str,
    pub face: Face,
    /// Extent of the house along the face.
    pub span: [f32; 2],
    pub height: f32,
    /// An empty mesh of the wall's material.
    pub wall: MeshBuilder,
    pub ground: Ground,
}

/// Names of a house's meshes.
pub fn parts(name: &str) -> [String; 7] {
    ["wall", "trim", "dark-panes", "lit-panes", "shops", "doors", "glass"].map(|part| format!("{name}-{part}"))
}

/// An opening and its filling.
#[derive(Clone, Copy)]
struct Opening {
    rect: Rect,
    filling: Filling,
}

/// The fillings of an opening.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Filling {
    /// The window of a room.
    Pane,
    /// The window of a shop.
    Shop,
    /// A glass door of the cinema.
    Glass,
    Door,
}

/// Builds all meshes of a house.
pub fn build(front: &HouseFront) -> Vec<MeshBuilder> {
    let names = parts(front.name);
    let mut wall = front.wall.renamed(&names[0]);
    let [mut trim, mut dark, mut lit, mut shops, mut doors, mut glass] =
        [(1, TRIM), (2, DARK_PANE), (3, LIT_PANE), (4, SHOP), (5, DOOR), (6, DARK_GLASS)]
            .map(|(k, material)| MeshBuilder::new(names[k].as_str(), material, 1.0));
    let face = front.face;
    let openings = openings(front);
    let holes: Vec<Rect> = openings.iter().map(|o| o.rect).collect();
    face.wall(&mut wall, Rect::new(front.span, [0.0, front.height]), &holes);
    gables(&mut wall, front);
    for (k, Opening { rect, filling }) in openings.into_iter().enumerate() {
        face.reveals(&mut trim, rect, RECESS_M);
        match filling {
            Filling::Pane => {
                // A random number from the opening and the house decides whether the room is lit.
                let place = IVec2::new(k as i32, (front.height * 10.0) as i32 + front.span[0] as i32);
                let pane = if unit(place, 467) < LIT { &mut lit } else { &mut dark };
                face.picture(pane, rect, -RECESS_M);
                let sill = Rect::new([rect.min.x - 0.1, rect.max.x + 0.1], [rect.min.y - 0.1, rect.min.y]);
                face.block(&mut trim, sill, [-0.05, 0.1]);
                let lintel = Rect::new([rect.min.x - 0.08, rect.max.x + 0.08], [rect.max.y, rect.max.y + 0.16]);
                face.block(&mut trim, lintel, [-0.05, 0.04]);
            }
            Filling::Shop | Filling::Glass => {
                if filling == Filling::Shop {
                    face.picture(&mut shops, rect, -RECESS_M);
                } else {
                    face.block(&mut glass, rect, [-RECESS_M - 0.02, -RECESS_M]);
                }
                let middle = 0.5 * (rect.min.x + rect.max.x);
                let bar = Rect::new([middle - 0.03, middle + 0.03], [rect.min.y, rect.max.y]);
                face.block(&mut trim, bar, [-RECESS_M, -RECESS_M + 0.05]);
                face.border(&mut trim, rect, 0.09, [-0.05, 0.04]);
            }
            Filling::Door => {
                face.block(&mut doors, rect, [-RECESS_M - 0.05, -RECESS_M]);
                let (middle, half) = (0.5 * (rect.min + rect.max), 0.5 * (rect.max - rect.min));
                for (y, height) in [(-0.5, 0.7), (0.4, 0.75)] {
                    let panel = centred_rect(middle.x, middle.y + y * half.y, 1.3 * half.x, height * half.y);
                    face.border(&mut doors, panel, 0.04, [-RECESS_M, -RECESS_M + 0.03]);
                }
                face.border(&mut trim, rect, 0.12, [-0.05, 0.05]);
            }
        }
    }
    // String course and cornice.
    let [from, to] = front.span;
    let top = front.height;
    for (y, out) in
        [([GROUND_M - 0.12, GROUND_M + 0.12], 0.12), ([top - 0.5, top - 0.28], 0.16), ([top - 0.28, top], 0.34)]
    {
        face.block(&mut trim, Rect::new([from + 0.02, to - 0.02], y), [-0.05, out]);
    }
    let mut meshes = vec![wall, trim, dark, lit, shops, doors, glass];
    meshes.retain(|m| !m.is_empty());
    meshes
}

/// Doors and windows, storey by storey.
fn openings(front: &HouseFront) -> Vec<Opening> {
    let [from, to] = front.span;
    let count = ((to - from) / BAY_M).floor().max(1.0) as usize;
    let pitch = (to - from) / count as f32;
    let middle = |k: usize| from + (k as f32 + 0.5) * pitch;
    let window = |k: usize, floor: f32| {
        let y = floor + WINDOW[2];
        let a = middle(k);
        Rect::new([a - 0.5 * WINDOW[0], a + 0.5 * WINDOW[0]], [y, y + WINDOW[1]])
    };
    let mut all = Vec::new();
    let mut add = |rect: Rect, filling: Filling| all.push(Opening { rect, filling });
    let above = |a: f32, width: f32, heights: [f32; 2]| Rect::new([a - 0.5 * width, a + 0.5 * width], heights);
    for k in 0..count {
        match front.ground {
            Ground::Shops if k % 3 == 2 => add(above(middle(k), 1.1, [0.15, 2.75]), Filling::Door),
            Ground::Shops => add(above(middle(k), pitch - 0.5, [0.65, 3.1]), Filling::Shop),
            Ground::Doors if k % 4 == 1 => add(above(middle(k), 1.15, [0.15, 2.75]), Filling::Door),
            Ground::Doors => add(window(k, 0.35), Filling::Pane),
            Ground::Cinema => {}
        }
    }
    if front.ground == Ground::Cinema {
        let centre = 0.5 * (from + to);
        for k in -1..=1 {
            add(above(centre + 1.35 * k as f32, 1.2, [0.15, 2.7]), Filling::Glass);
        }
    }
    let mut floor = GROUND_M;
    while floor + WINDOW[1] + WINDOW[2] + 0.7 < front.height {
        for k in 0..count {
            // The cinema's canopy and its sign cover the lower part of this storey.
            let rect = window(k, if front.ground == Ground::Cinema { floor + 0.5 } else { floor });
            add(rect, Filling::Pane);
        }
        floor += STOREY_M;
    }
    all
}

/// The parts of the side walls that rise above lower neighbours.
fn gables(wall: &mut MeshBuilder, front: &HouseFront) {
    for (a, facing) in [(front.span[0], -front.face.right), (front.span[1], front.face.right)] {
        let point = |y: f32, out: f32| front.face.point_at(a, y, out);
        wall.polygon(
            &[point(0.0, 0.0), point(front.height, 0.0), point(front.height, -DEPTH_M), point(0.0, -DEPTH_M)],
            facing,
        );
    }
    let roof = |a: f32, out: f32| front.face.point_at(a, front.height, out);
    let [from, to] = front.span;
    wall.polygon(&[roof(from, 0.0), roof(to, 0.0), roof(to, -DEPTH_M), roof(from, -DEPTH_M)], Vec3::Y);
}
