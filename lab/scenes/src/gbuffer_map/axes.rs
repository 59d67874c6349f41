//! The conventions that a map states of its renderer: the axes of world and view space, the order of matrices, the
//! direction of clip-space y, and the unit of length.

use super::keys::MapKeys;
use glam::{DMat3, DMat4, DVec3};
use ssct_ground::conventions::{Axes, ClipY, MatrixOrder};
use ssct_ground::{Error, Result};

/// The conventions of a map. The default is this program's conventions.
#[derive(Debug, Clone, Copy)]
pub(super) struct MapConventions {
    /// Matrix from the renderer's world space to this program's; lengths stay in the renderer's unit.
    pub world: DMat3,
    /// Matrix from the renderer's view space to this program's.
    pub view: DMat3,
    /// Order of the numbers of a matrix.
    pub matrices: MatrixOrder,
    /// Direction of y in clip space: up or down in the image.
    pub clip_y: ClipY,
    /// Number of metres in the renderer's unit of length.
    pub metres: f64,
}

impl MapConventions {
    /// Takes the keys of the section `[conventions]`.
    pub fn take(mut keys: MapKeys) -> Result<Self> {
        let mut axes_matrix = |key| Ok::<_, Error>(keys.word(key, &Axes::NAMES)?.unwrap_or_default().to_ours());
        let (world, view) = (axes_matrix("world")?, axes_matrix("view")?);
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

    /// Makes the matrix, for column vectors, from the 16 numbers that the renderer lists in its order.
    pub fn matrix(&self, numbers: &[f64]) -> DMat4 {
        let by_columns = DMat4::from_cols_slice(numbers);
        if self.matrices == MatrixOrder::Rows { by_columns.transpose() } else { by_columns }
    }

    /// Converts a place in the renderer's world and unit to this program's world, in metres.
    pub fn place(&self, place: [f64; 3]) -> DVec3 {
        self.direction(place) * self.metres
    }

    /// Converts a direction in the renderer's world to this program's world; its length stays.
    pub fn direction(&self, direction: [f64; 3]) -> DVec3 {
        self.world * DVec3::from(direction)
    }
}
