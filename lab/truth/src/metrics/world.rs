//! World agreement (docs/definitions.md, "World agreement"): how often a method's ray ends like the same ray among the
//! scene's triangles. The method should hit there if the screen shows that end, and should miss if it does not.

/// The largest distance, in x and in y, between a method's hit and the world's that agree, in pixels.
pub const WITHIN_PIXELS: f64 = 2.0;

/// Counts of the reflecting pixels, by how a method's hit compares with the world's.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct WorldAgreement {
    /// The number of reflecting pixels.
    pub pixels: u64,
    /// Number of pixels where both hit within [`WITHIN_PIXELS`], or both miss.
    pub agree: u64,
    /// Number of pixels where the method hits, but the screen does not show the end of the ray.
    #[serde(rename = "false")]
    pub false_hits: u64,
    /// Number of pixels where the method misses, although the screen shows the end of the ray.
    pub missed: u64,
    /// Number of pixels where both hit, but further apart than [`WITHIN_PIXELS`].
    pub displaced: u64,
}

impl WorldAgreement {
    /// The share of pixels that agree; `None` if nothing reflects.
    pub fn fraction(&self) -> Option<f64> {
        (self.pixels > 0).then(|| self.agree as f64 / self.pixels as f64)
    }
}

/// Returns whether two pixel coordinates [x, y] are within [`WITHIN_PIXELS`] of each other in x and in y.
pub fn is_same_place(a: [f64; 2], b: [f64; 2]) -> bool {
    (0..2).all(|i| (a[i] - b[i]).abs() <= WITHIN_PIXELS)
}

/// Compares a method's hits with the world's. All three slices have one element for each pixel: `reflects` says whether
/// it reflects. `visible` has the pixel coordinates where the screen shows the end of its ray in the world, if it does.
/// `method` has the pixel coordinates of the method's hit, if any. A hit that is not finite counts as false or
/// displaced.
pub fn agreement(reflects: &[bool], visible: &[Option<[f64; 2]>], method: &[Option<[f64; 2]>]) -> WorldAgreement {
    let mut counts = WorldAgreement::default();
    for ((_, world), method) in reflects.iter().zip(visible).zip(method).filter(|((reflects, _), _)| **reflects) {
        counts.pixels += 1;
        match (world, method) {
            (None, None) => counts.agree += 1,
            (None, Some(_)) => counts.false_hits += 1,
            (Some(_), None) => counts.missed += 1,
            (Some(true_place), Some(hit)) if is_same_place(*true_place, *hit) => counts.agree += 1,
            (Some(_), Some(_)) => counts.displaced += 1,
        }
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_is_counted_once() {
        let visible = [None, None, Some([5.0, 5.0]), Some([5.0, 5.0]), Some([5.0, 5.0]), Some([5.0, 5.0]), None];
        let method =
            [None, Some([1.0, 1.0]), None, Some([7.0, 3.0]), Some([7.1, 5.0]), Some([5.0, 2.9]), Some([1.0, 1.0])];
        let reflects = [true, true, true, true, true, true, false];
        let counts = agreement(&reflects, &visible, &method);
        assert_eq!(counts, WorldAgreement { pixels: 6, agree: 2, false_hits: 1, missed: 1, displaced: 2 });
        assert_eq!(counts.fraction(), Some(2.0 / 6.0));
    }

    #[test]
    fn nothing_reflects_and_nan_never_agrees() {
        assert_eq!(agreement(&[false], &[None], &[None]).fraction(), None);
        let counts = agreement(&[true], &[Some([1.0, 1.0])], &[Some([f64::NAN, 1.0])]);
        assert_eq!((counts.agree, counts.displaced), (0, 1));
    }
}
