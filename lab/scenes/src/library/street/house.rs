//! Builds the fronts of houses: a ground floor, windows in several storeys, and a cornice.

use super::{DARK_GLASS, DARK_PANE, DOOR, LIT_PANE, SHOP, TRIM};
use crate::library::builder::{MeshBuilder, Rect};
use crate::library::fittings::{Face, centred_rect};
use glam::{IVec2, Vec3};
use ssct_ground::math::noise::unit;

/// Height of the ground floor, in metres.
const GROUND_M: f32 = 4.0;
/// Height of each storey above the ground floor, in metres.
const STOREY_M: f32 = 3.15;
/// Width and height of a window, in metres.
const WINDOW_M: [f32; 2] = [1.15, 1.75];
/// Height of a window's sill above the floor of its storey, in metres.
const SILL_M: f32 = 0.85;
/// Least width of a bay, in metres. A house is divided into equal bays, with one opening in each storey of a bay.
const BAY_M: f32 = 2.55;
/// Depth of the openings in the wall, in metres.
const RECESS_M: f32 = 0.2;
/// Depth of a house, in metres. Its side walls are seen where they rise above lower neighbours.
const DEPTH_M: f32 = 7.0;
/// The share of windows with a lit room.
const LIT_SHARE: f32 = 0.3;

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
    /// Range of the house along the face, in metres.
    pub span: [f32; 2],
    pub height: f32,
    /// An empty mesh of the wall's material.
    pub wall: MeshBuilder,
    pub ground: Ground,
}

/// Returns the names of a house's meshes, each with the house's name in front.
pub fn mesh_names(name: &str) -> [String; 7] {
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
    let names = mesh_names(front.name);
    let mut wall = front.wall.renamed(&names[0]);
    // Each mesh has the index of its name in `names`, and its material.
    let [mut trim, mut dark, mut lit, mut shops, mut doors, mut glass] =
        [(1, TRIM), (2, DARK_PANE), (3, LIT_PANE), (4, SHOP), (5, DOOR), (6, DARK_GLASS)]
            .map(|(part, material)| MeshBuilder::new(names[part].as_str(), material, 1.0));
    let face = front.face;
    let openings = openings(front);
    let holes: Vec<Rect> = openings.iter().map(|opening| opening.rect).collect();
    face.wall(&mut wall, Rect::new(front.span, [0.0, front.height]), &holes);
    gables(&mut wall, front);
    for (number, Opening { rect, filling }) in openings.into_iter().enumerate() {
        face.reveals(&mut trim, rect, RECESS_M);
        match filling {
            Filling::Pane => {
                // A hash of the opening's number and of the house, from 0 to 1, decides whether the room is lit.
                let hash_input = IVec2::new(number as i32, (front.height * 10.0) as i32 + front.span[0] as i32);
                let pane = if unit(hash_input, 467) < LIT_SHARE { &mut lit } else { &mut dark };
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
                // Two panels, one above the other; places and sizes are shares of half the door's size.
                for (y, height) in [(-0.5, 0.7), (0.4, 0.75)] {
                    let panel = centred_rect(middle.x, middle.y + y * half.y, 1.3 * half.x, height * half.y);
                    face.border(&mut doors, panel, 0.04, [-RECESS_M, -RECESS_M + 0.03]);
                }
                face.border(&mut trim, rect, 0.12, [-0.05, 0.05]);
            }
        }
    }
    // A horizontal band above the ground floor, and a cornice of two bands at the top, with how far they project.
    let [from, to] = front.span;
    let top = front.height;
    for (heights, out) in
        [([GROUND_M - 0.12, GROUND_M + 0.12], 0.12), ([top - 0.5, top - 0.28], 0.16), ([top - 0.28, top], 0.34)]
    {
        face.block(&mut trim, Rect::new([from + 0.02, to - 0.02], heights), [-0.05, out]);
    }
    let mut meshes = vec![wall, trim, dark, lit, shops, doors, glass];
    meshes.retain(|mesh| !mesh.is_empty());
    meshes
}

/// Lists the doors and windows of a house, storey by storey from below.
fn openings(front: &HouseFront) -> Vec<Opening> {
    let [from, to] = front.span;
    let count = ((to - from) / BAY_M).floor().max(1.0) as usize;
    let bay_width = (to - from) / count as f32;
    let bay_middle = |bay: usize| from + (bay as f32 + 0.5) * bay_width;
    let window = |bay: usize, floor_y: f32| {
        let [x, y] = [bay_middle(bay), floor_y + SILL_M];
        Rect::new([x - 0.5 * WINDOW_M[0], x + 0.5 * WINDOW_M[0]], [y, y + WINDOW_M[1]])
    };
    let mut openings = Vec::new();
    let mut add = |rect: Rect, filling: Filling| openings.push(Opening { rect, filling });
    let upright_rect = |x: f32, width: f32, heights: [f32; 2]| Rect::new([x - 0.5 * width, x + 0.5 * width], heights);
    for bay in 0..count {
        match front.ground {
            Ground::Shops if bay % 3 == 2 => add(upright_rect(bay_middle(bay), 1.1, [0.15, 2.75]), Filling::Door),
            Ground::Shops => add(upright_rect(bay_middle(bay), bay_width - 0.5, [0.65, 3.1]), Filling::Shop),
            Ground::Doors if bay % 4 == 1 => add(upright_rect(bay_middle(bay), 1.15, [0.15, 2.75]), Filling::Door),
            Ground::Doors => add(window(bay, 0.35), Filling::Pane),
            Ground::Cinema => {}
        }
    }
    if front.ground == Ground::Cinema {
        let centre = 0.5 * (from + to);
        for door in -1..=1 {
            add(upright_rect(centre + 1.35 * door as f32, 1.2, [0.15, 2.7]), Filling::Glass);
        }
    }
    let mut floor_y = GROUND_M;
    while floor_y + WINDOW_M[1] + SILL_M + 0.7 < front.height {
        for bay in 0..count {
            // Windows of the cinema are higher, since its canopy covers the lower part of the first storey.
            let rect = window(bay, if front.ground == Ground::Cinema { floor_y + 0.5 } else { floor_y });
            add(rect, Filling::Pane);
        }
        floor_y += STOREY_M;
    }
    openings
}

/// Adds the side walls of a house, which are seen where they rise above lower neighbours, and its flat roof.
fn gables(wall: &mut MeshBuilder, front: &HouseFront) {
    for (end, facing) in [(front.span[0], -front.face.right), (front.span[1], front.face.right)] {
        let point = |y: f32, out: f32| front.face.point_at(end, y, out);
        wall.polygon(
            &[point(0.0, 0.0), point(front.height, 0.0), point(front.height, -DEPTH_M), point(0.0, -DEPTH_M)],
            facing,
        );
    }
    let roof = |x: f32, out: f32| front.face.point_at(x, front.height, out);
    let [from, to] = front.span;
    wall.polygon(&[roof(from, 0.0), roof(to, 0.0), roof(to, -DEPTH_M), roof(from, -DEPTH_M)], Vec3::Y);
}
