//! Tests methods on a mirror under a known pattern. For every pixel, the host computes in 64 bits where the mirror ray
//! meets the wall and where that point is on the screen; the methods must find this point.

mod closed_form;
mod marches;
mod picture;
mod ramp;

use crate::common::{Builder, Shown, camera};
use glam::{DVec2, DVec3, Vec3};
use ssct::passes::PathCode;
use ssct_ground::math::display_byte;
use ssct_ground::math::projection::{project, unproject};
use ssct_scenes::{Camera, Scene};

/// The wall stands at this z, in metres.
const WALL_Z: f64 = 6.0;
/// The side of a cell of the wall's pattern, in metres.
const CELL: f64 = 1.5;
/// The number of cells across and up; their lower left corner is at (−12, −3) metres.
const CELLS: [u32; 2] = [16, 8];

/// Returns the colour of the cell in column i and row j, in sRGB.
fn cell_color(i: u32, j: u32) -> [u8; 3] {
    // Neighbours differ by 60 or more in every channel.
    [40 + 60 * ((i + 2 * j) % 4) as u8, 40 + 60 * ((2 * i + j) % 4) as u8, 40 + 60 * ((i + j) % 4) as u8]
}

/// A plane mirror, rolled about the z axis by an angle, before a wall of coloured cells.
struct Case {
    roll: f64,
}

impl Case {
    /// Returns the unit normal of the mirror.
    fn normal(&self) -> DVec3 {
        DVec3::new(self.roll.sin(), self.roll.cos(), 0.0)
    }

    /// Returns the scene of the mirror and the wall.
    fn scene(&self) -> Scene {
        let mut b = Builder::new("mirror");
        b.light(Vec3::Z);
        let texels = 64;
        let wall = b.picture(CELLS[0] * texels, CELLS[1] * texels, |x, y| {
            // Row 0 of the picture is the top; row 0 of the cells is the bottom.
            cell_color(x / texels, CELLS[1] - 1 - y / texels)
        });
        let width = (CELL * f64::from(CELLS[0])) as f32;
        let height = (CELL * f64::from(CELLS[1])) as f32;
        b.quad(wall, Vec3::new(-width / 2.0, -3.0, WALL_Z as f32), Vec3::X * width, Vec3::Y * height, -Vec3::Z);
        let mirror = b.mirror();
        let normal = self.normal().as_vec3();
        let right = Vec3::new(normal.y, -normal.x, 0.0) * 12.0;
        b.quad(mirror, -right, right * 2.0, Vec3::Z * WALL_Z as f32, normal);
        b.0
    }

    /// Returns a camera at `EYE` that looks along the z axis.
    fn camera(&self, extent: [u32; 2]) -> Camera {
        camera(EYE.as_vec3(), EYE.as_vec3() + Vec3::Z, extent)
    }
}

/// The place of the camera, in metres.
const EYE: DVec3 = DVec3::new(0.0, 1.2, 0.0);

/// Returns the pixels of a shot that reflect: column, row, and the texture coordinates of the centre.
fn reflecting(shown: &Shown) -> impl Iterator<Item = (u32, u32, DVec2)> {
    let material = shown.get("material");
    let (width, height) = (material.width, material.height);
    let pixels = (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)));
    pixels.filter(|&(x, y)| material.texel(x, y)[0] > 1e-4).map(move |(x, y)| {
        (x, y, DVec2::new((f64::from(x) + 0.5) / f64::from(width), (f64::from(y) + 0.5) / f64::from(height)))
    })
}

/// Returns the mirror ray of a pixel in view space: its start on the mirror's plane, and its direction. The plane is
/// given by a point and its unit normal, both in view space, and the pixel by texture coordinates.
fn mirror_ray(shown: &Shown, uv: DVec2, point: DVec3, normal: DVec3) -> (DVec3, DVec3) {
    let inverse = shown.camera.view_to_clip().as_dmat4().inverse();
    let direction = unproject(uv.extend(0.5), &inverse).normalize();
    let position = direction * (point.dot(normal) / direction.dot(normal));
    (position, direction - normal * 2.0 * direction.dot(normal))
}

/// Returns the texture coordinates of a point in view space, or `None` if it lies behind the camera or off the screen.
fn on_screen(shown: &Shown, view: DVec3) -> Option<DVec2> {
    let uv = project(view, &shown.camera.view_to_clip().as_dmat4()).truncate();
    (view.z > 0.0 && uv.cmpge(DVec2::ZERO).all() && uv.cmple(DVec2::ONE).all()).then_some(uv)
}

/// Returns the path code of a texel of the hits.
fn path(hit: &[f32]) -> PathCode {
    PathCode::from_channel(hit[3]).expect("a path code")
}

/// Returns the colour of a reflection in sRGB bytes.
fn bytes(color: &[f32]) -> [u8; 3] {
    [0, 1, 2].map(|c| display_byte(color[c]))
}

/// Returns whether two colours differ by at most one step in each channel.
fn is_near(a: [u8; 3], b: [u8; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 1)
}
