//! The conventions of other renderers: how the axes of world and view space lie, how matrices are listed, and the unit
//! of length.

use super::keys::MapKeys;
use crate::error::Result;
use glam::{DMat3, DMat4, DVec3};

/// The conventions of a map. Those of this program are the default.
#[derive(Debug, Clone, Copy)]
pub(super) struct MapConventions {
    /// From the renderer's world space to ours; lengths stay in the renderer's unit.
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

// Matrices that take a vector of another renderer to ours. Their columns are the renderer's axes x, y and z in ours.
const LEFT: DMat3 = DMat3::IDENTITY;
const RIGHT: DMat3 = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::NEG_Z);
const RIGHT_Z_UP: DMat3 = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Y);
const RIGHT_Y_DOWN: DMat3 = DMat3::from_cols(DVec3::X, DVec3::NEG_Y, DVec3::Z);
/// x forwards, y to the right, z up.
const LEFT_Z_UP: DMat3 = DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y);

/// Conventions of world space.
const WORLDS: [(&str, DMat3); 4] =
    [("left", LEFT), ("right", RIGHT), ("right-z-up", RIGHT_Z_UP), ("left-z-up", LEFT_Z_UP)];

/// Conventions of view space.
const VIEWS: [(&str, DMat3); 4] =
    [("left", LEFT), ("right", RIGHT), ("right-z-up", RIGHT_Z_UP), ("right-y-down", RIGHT_Y_DOWN)];

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

    /// The matrix, for column vectors, that 16 numbers of the renderer list.
    pub fn matrix(&self, numbers: &[f64]) -> DMat4 {
        let listed = DMat4::from_cols_slice(numbers);
        if self.rows { listed.transpose() } else { listed }
    }

    /// A place of the renderer's world in ours, in metres.
    pub fn place(&self, place: [f64; 3]) -> DVec3 {
        self.direction(place) * self.metres
    }

    /// A direction of the renderer's world in ours.
    pub fn direction(&self, direction: [f64; 3]) -> DVec3 {
        self.world * DVec3::from(direction)
    }
}
