//! Hit agreement: how often a method's rays end where the oracle's do (docs/definitions.md, "Oracle").

use super::percentile;
use serde::{Deserialize, Serialize};

/// How a method's hits compare with the oracle's over the reflecting pixels. The four fractions are shares of the
/// reflecting pixels and add up to 1; all are null if no pixel reflects.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct HitAgreement {
    /// The number of reflecting pixels.
    #[serde(skip)]
    pub pixels: usize,
    /// Share of pixels where method and oracle both miss, or both hit with |Δx| ≤ 1 and |Δy| ≤ 1 pixel.
    pub hit_agreement: Option<f64>,
    /// Share of pixels where only the method hits.
    #[serde(rename = "false")]
    pub false_hits: Option<f64>,
    /// Share of pixels where only the oracle hits.
    pub missed: Option<f64>,
    /// Share of pixels where both hit, but further apart than one pixel in x or in y.
    pub displaced: Option<f64>,
    /// The 50th percentile of the distance in pixels between both hits, over the pixels where both hit: the least
    /// distance that half of the distances do not exceed. Null if there are none.
    pub hit_error_px_p50: Option<f64>,
    /// The 99th percentile of these distances.
    pub hit_error_px_p99: Option<f64>,
}

/// How the two hits of one pixel compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HitVerdict {
    /// Method and oracle both miss, or both hit within one pixel in x and in y.
    Agrees,
    /// Only the method hits.
    False,
    /// Only the oracle hits.
    Missed,
    /// Method and oracle both hit, but further apart.
    Displaced,
}

impl HitVerdict {
    /// Compares a method's hit with the oracle's; hits are pixel coordinates [x, y], and `None` is a miss.
    pub fn compare(method: Option<[f64; 2]>, oracle: Option<[f64; 2]>) -> Self {
        match (method, oracle) {
            (None, None) => Self::Agrees,
            (Some(_), None) => Self::False,
            (None, Some(_)) => Self::Missed,
            (Some(m), Some(o)) if (m[0] - o[0]).abs() <= 1.0 && (m[1] - o[1]).abs() <= 1.0 => Self::Agrees,
            // A hit of the method at NaN is displaced, since no comparison with NaN holds.
            (Some(_), Some(_)) => Self::Displaced,
        }
    }
}

impl HitAgreement {
    /// Compares a method's hits with the oracle's over the reflecting pixels. The slices have one element for each
    /// pixel. Hits are continuous pixel coordinates [x, y], rows from the top; `None` is a miss.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn new(reflecting: &[bool], method: &[Option<[f64; 2]>], oracle: &[Option<[f64; 2]>]) -> Self {
        assert!(reflecting.len() == method.len() && method.len() == oracle.len(), "the images must have equal sizes");
        // The hits (method, oracle) of each reflecting pixel.
        let pairs = || reflecting.iter().zip(method.iter().zip(oracle)).filter(|(r, _)| **r).map(|(_, pair)| pair);
        let pixels = pairs().count();
        let share = |verdict| {
            let count = pairs().filter(|(hit, truth)| HitVerdict::compare(**hit, **truth) == verdict).count();
            (pixels > 0).then(|| count as f64 / pixels as f64)
        };
        // Distances between both hits, over the pixels where both hit.
        let mut distances_px: Vec<f64> =
            pairs().filter_map(|(m, o)| m.zip(*o)).map(|(m, o)| (m[0] - o[0]).hypot(m[1] - o[1])).collect();
        distances_px.sort_by(f64::total_cmp);
        Self {
            pixels,
            hit_agreement: share(HitVerdict::Agrees),
            false_hits: share(HitVerdict::False),
            missed: share(HitVerdict::Missed),
            displaced: share(HitVerdict::Displaced),
            hit_error_px_p50: percentile(&distances_px, 0.5),
            hit_error_px_p99: percentile(&distances_px, 0.99),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MISS: Option<[f64; 2]> = None;

    /// A hit at pixel coordinates.
    fn hit(x: f64, y: f64) -> Option<[f64; 2]> {
        Some([x, y])
    }

    #[test]
    fn shares_are_those_of_a_count_by_hand() {
        let method =
            [MISS, hit(1.0, 1.0), hit(5.0, 5.0), MISS, hit(3.0, 4.0), hit(9.0, 9.0), hit(2.0, 2.0), hit(7.0, 7.0)];
        let oracle = [MISS, hit(2.0, 0.0), MISS, hit(4.0, 4.0), hit(0.0, 0.0), hit(9.0, 10.001), MISS, hit(7.0, 7.0)];
        let mut reflecting = [true; 8];
        reflecting[6] = false;
        let agreement = HitAgreement::new(&reflecting, &method, &oracle);
        let sevenths = |n: f64| Some(n / 7.0);
        assert_eq!(agreement.pixels, 7);
        // The three agreeing pixels: both miss; hits exactly one pixel apart on both axes; equal hits.
        assert_eq!(agreement.hit_agreement, sevenths(3.0));
        assert_eq!(
            (agreement.false_hits, agreement.missed, agreement.displaced),
            (sevenths(1.0), sevenths(1.0), sevenths(2.0))
        );
        // Distances √2, 5, 1.001, 0: a percentile is one of them, and not the mean of two.
        assert!((agreement.hit_error_px_p50.expect("hits") - 1.001).abs() < 1e-9);
        assert_eq!(agreement.hit_error_px_p99, Some(5.0));
    }

    #[test]
    fn nothing_to_compare_is_null_not_perfect() {
        let none = HitAgreement::new(&[false], &[MISS], &[MISS]);
        assert_eq!((none.pixels, none.hit_agreement, none.false_hits), (0, None, None));
        let misses = HitAgreement::new(&[true], &[MISS], &[MISS]);
        assert_eq!((misses.hit_agreement, misses.hit_error_px_p50, misses.hit_error_px_p99), (Some(1.0), None, None));
    }

    #[test]
    fn a_hit_at_nan_never_agrees() {
        assert_eq!(HitVerdict::compare(hit(f64::NAN, 1.0), hit(1.0, 1.0)), HitVerdict::Displaced);
        assert_eq!(HitVerdict::compare(hit(f64::NAN, 1.0), MISS), HitVerdict::False);
    }

    #[test]
    fn it_is_serialised_with_the_names_of_the_record() {
        let json = serde_json::to_value(HitAgreement::new(&[true], &[hit(0.5, 0.5)], &[MISS])).expect("plain numbers");
        let expected = serde_json::json!({"hit_agreement": 0.0, "false": 1.0, "missed": 0.0, "displaced": 0.0,
            "hit_error_px_p50": null, "hit_error_px_p99": null});
        assert_eq!(json, expected);
    }
}
