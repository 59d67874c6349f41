//! Scenes far from their origin, where 32-bit floats are coarser than the scene's details.

use glam::DVec3;

/// Greatest ratio of a scene's distance from the origin to its size at which 32-bit floats keep the details: their
/// steps are then finer than 1 / 16,000 of the size.
const MOST_SIZES_AWAY: f64 = 1024.0;

/// The centre and the size of a scene that lies too far from the origin for its size.
pub(super) struct FarScene {
    /// Offset that is subtracted from every position, in metres. It is whole metres, so that positions are easy to
    /// convert, unless the scene measures less than one metre.
    pub(super) centre: DVec3,
    /// Diagonal of the scene's bounds, in metres.
    size: f64,
}

/// Returns the centre and the size of a scene that lies too far from the origin for its size, else `None`. The scene's
/// bounds are given by their least and greatest corner, in metres.
pub(super) fn far_origin([min, max]: [DVec3; 2]) -> Option<FarScene> {
    let (centre, size) = (0.5 * (min + max), (max - min).length());
    let is_far = centre.is_finite() && centre.length() > MOST_SIZES_AWAY * size && size > 0.0;
    is_far.then(|| FarScene { centre: if size < 1.0 { centre } else { centre.round() }, size })
}

impl FarScene {
    /// Makes the warning for a scene that lies far away and is not moved, since its file places other things by its
    /// coordinates.
    pub(super) fn warning(&self) -> String {
        format!(
            "it lies {:.4e} m from the origin, too far for its size of {:.4e} m: floats lose its details; move it to the \
             origin",
            self.centre.length(),
            self.size
        )
    }

    /// Makes the message for a scene that was moved by −`centre`.
    pub(super) fn sentence(&self) -> String {
        // Subtracting from 0 never gives −0, which would be printed with its sign.
        let [x, y, z] = self.centre.to_array().map(|coordinate| 0.0 - coordinate);
        format!(
            "it lies {:.4e} m from the origin, too far for its size of {:.4e} m; it was moved by ({x}, {y}, {z}) m, \
             and places are those after the move",
            self.centre.length(),
            self.size
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_scenes_that_floats_cannot_hold_are_moved() {
        let cube_bounds = |centre: DVec3, half_side: f64| [centre - half_side, centre + half_side];
        assert!(far_origin(cube_bounds(DVec3::ZERO, 1.0)).is_none());
        assert!(far_origin(cube_bounds(DVec3::splat(1000.0), 1.0)).is_none());
        let far = far_origin(cube_bounds(DVec3::new(6_378_137.4, 0.0, 0.0), 2.0)).expect("far");
        assert_eq!(far.centre, DVec3::new(6_378_137.0, 0.0, 0.0));
        assert!(far.sentence().contains("moved by (-6378137, 0, 0) m"), "{}", far.sentence());
        assert!(far_origin([DVec3::INFINITY, DVec3::NEG_INFINITY]).is_none(), "no vertex");
        assert!(far_origin(cube_bounds(DVec3::splat(5.0), 0.0)).is_none(), "a point");
    }
}
