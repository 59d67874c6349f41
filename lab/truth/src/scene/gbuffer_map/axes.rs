//! The conventions of other renderers: how the axes of world and view space lie, how matrices are listed, and the unit
//! of length.

use super::keys::MapKeys;
use crate::conventions::{Axes, ClipY, MatrixOrder};
use crate::error::{Error, Result};
use glam::{DMat3, DMat4, DVec3};

/// The conventions of a map. Those of this program are the default.
#[derive(Debug, Clone, Copy)]
pub(super) struct MapConventions {
    /// From the renderer's world space to ours; lengths stay in the renderer's unit.
    pub world: DMat3,
    /// From the renderer's view space to ours.
    pub view: DMat3,
    /// How a matrix is listed.
    pub matrices: MatrixOrder,
    /// Where the top of the image is in clip space.
    pub clip_y: ClipY,
    /// Metres in a unit of length of the renderer.
    pub metres: f64,
}

impl MapConventions {
    pub fn take(mut keys: MapKeys) -> Result<Self> {
        let mut axes = |name| Ok::<_, Error>(keys.word(name, &Axes::NAMES)?.unwrap_or_default().to_ours());
        let (world, view) = (axes("world")?, axes("view")?);
        let orders = [("columns", MatrixOrder::Columns), ("rows", MatrixOrder::Rows)];
        let matrices = keys.word("matrices", &orders)?.unwrap_or_default();
        let clip_y = keys.word("clip-y", &[("up", ClipY::Up), ("down", ClipY::Down)])?.unwrap_or(ClipY::Up);
        let metres = keys.number("metres-per-unit", false)?.unwrap_or(1.0);
        if metres <= 0.0 {
            return Err(keys.error(keys.line, format!("metres-per-unit must be above 0, not {metres}")));
        }
        keys.finish()?;
        Ok(Self { world, view, matrices, clip_y, metres })
    }

    /// The matrix, for column vectors, that 16 numbers of the renderer list.
    pub fn matrix(&self, numbers: &[f64]) -> DMat4 {
        let listed = DMat4::from_cols_slice(numbers);
        if self.matrices == MatrixOrder::Rows { listed.transpose() } else { listed }
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
