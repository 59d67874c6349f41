//! How other renderers lay the axes of world and view space, and how they write matrices.

use super::keys::MapKeys;
use crate::error::Result;
use glam::{DMat3, DMat4, DVec3};

/// The conventions of a map. Our own are the default.
#[derive(Debug, Clone, Copy)]
pub(super) struct MapConventions {
    /// From the renderer's world space to ours, without its unit of length.
    pub world: DMat3,
    /// From the renderer's view space to ours.
    pub view: DMat3,
    /// Whether a matrix is listed row by row.
    pub rows: bool,
    /// Whether the top of the image is at y = w in clip space.
    pub clip_y_is_up: bool,
    /// Metres in a unit of length of the renderer.
    pub metres: f64,
}

/// A matrix that takes a vector of another renderer to ours, whose axes x, y and z are these of its components.
const fn axes(x: [f64; 3], y: [f64; 3], z: [f64; 3]) -> DMat3 {
    // Rows are what was given.
    DMat3::from_cols_array(&[x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]])
}

const LEFT: DMat3 = DMat3::IDENTITY;
const RIGHT: DMat3 = axes([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]);
const RIGHT_Z_UP: DMat3 = axes([1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]);

/// Conventions of world space.
const WORLDS: [(&str, DMat3); 4] = [
    ("left", LEFT),
    ("right", RIGHT),
    ("right-z-up", RIGHT_Z_UP),
    // x forwards, y to the right.
    ("left-z-up", axes([0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])),
];

/// Conventions of view space.
const VIEWS: [(&str, DMat3); 4] = [
    ("left", LEFT),
    ("right", RIGHT),
    ("right-z-up", RIGHT_Z_UP),
    ("right-y-down", axes([1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0])),
];

impl MapConventions {
    pub fn take(mut keys: MapKeys) -> Result<Self> {
        let world = keys.word("world", &WORLDS)?.unwrap_or(LEFT);
        let view = keys.word("view", &VIEWS)?.unwrap_or(LEFT);
        let rows = keys.word("matrices", &[("columns", false), ("rows", true)])?.unwrap_or(false);
        let clip_y_is_up = keys.word("clip-y", &[("up", true), ("down", false)])?.unwrap_or(true);
        let metres = keys.number("metres-per-unit", false)?.unwrap_or(1.0);
        if metres <= 0.0 {
            return Err(keys.error(keys.line, format!("metres-per-unit must be above 0, not {metres}")));
        }
        keys.finish()?;
        Ok(Self { world, view, rows, clip_y_is_up, metres })
    }

    /// The matrix of 16 numbers.
    pub fn matrix(&self, numbers: &[f64]) -> DMat4 {
        let listed = DMat4::from_cols_slice(numbers);
        if self.rows { listed.transpose() } else { listed }
    }

    /// A place of the renderer's world in ours, in metres.
    pub fn place(&self, [x, y, z]: [f64; 3]) -> DVec3 {
        self.direction([x, y, z]) * self.metres
    }

    /// A direction of the renderer's world in ours.
    pub fn direction(&self, direction: [f64; 3]) -> DVec3 {
        self.world * DVec3::from(direction)
    }
}
