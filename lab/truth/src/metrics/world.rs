//! World agreement (docs/definitions.md, "World agreement"): how often a method hits what the ray hits in the scene's triangles
//! if the screen shows the end of the ray, and misses if it does not.

/// The largest distance, in x and in y, between a method's hit and the world's, in pixels.
pub const WITHIN_PIXELS: f64 = 2.0;

/// Counts over the reflecting pixels.
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
    /// Number of pixels where both hit, but further apart.
    pub displaced: u64,
}

impl WorldAgreement {
    /// The share of pixels that agree; `None` if nothing reflects.
    pub fn fraction(&self) -> Option<f64> {
        (self.pixels > 0).then(|| self.agree as f64 / self.pixels as f64)
    }
}

/// Whether two pixel coordinates are within [`WITHIN_PIXELS`] of each other in x and in y.
pub fn is_same_place(a: [f64; 2], b: [f64; 2]) -> bool {
    (0..2).all(|i| (a[i] - b[i]).abs() <= WITHIN_PIXELS)
}

/// Compares a method's hits with the world's. All three slices have equal length. For each pixel, `reflects` says whether it
/// reflects, and `visible` has the end of its ray in the world, if the screen shows it. `method` has the method's hit, if any,
/// in pixel coordinates like `visible`. A hit that is not finite counts as false or displaced.
pub fn agreement(reflects: &[bool], visible: &[Option<[f64; 2]>], method: &[Option<[f64; 2]>]) -> WorldAgreement {
    let mut counts = WorldAgreement::default();
    for ((_, world), method) in reflects.iter().zip(visible).zip(method).filter(|((reflects, _), _)| **reflects) {
        counts.pixels += 1;
        match (world, method) {
            (None, None) => counts.agree += 1,
            (None, Some(_)) => counts.false_hits += 1,
            (Some(_), None) => counts.missed += 1,
            (Some(a), Some(b)) if is_same_place(*a, *b) => counts.agree += 1,
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
