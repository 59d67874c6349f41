//! Decides whether times changed: the ratio of two medians with a percentile bootstrap interval (Efron and
//! Tibshirani 1993, "An Introduction to the Bootstrap", chapter 13), and the verdict that follows from the
//! interval. The resampling is seeded, so the same samples give the same interval everywhere.

use super::percentile;
use serde::Serialize;
use ssct_ground::math::random::Stream;

/// The number of resamples from which an interval is made. Fifty of them lie beyond each end of the interval; this
/// count varies by about a seventh (1 / √50).
pub const RESAMPLES: u32 = 2000;

/// The share of the resamples that lies inside the interval; the other resamples are split evenly between both ends.
pub const CONFIDENCE: f64 = 0.95;

/// The least number of samples of each side that a verdict needs. Even the range from the least to the greatest of four
/// samples contains the true median only seven times in eight (1 − 2 · 2⁻⁴).
pub const MIN_SAMPLES: usize = 5;

/// The ratio of B's median to A's, with its interval over resamples: 0 ≤ `low` ≤ `high`. The ratio is infinite if A's
/// median is 0 and B's is not, and 1 if both medians are 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratio {
    /// Ratio of the medians of the original samples.
    pub ratio: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// The verdict whether B is faster or slower than A, from the interval of the [`Ratio`] of B's median time to A's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Verdict {
    /// The whole interval lies below 1 − bound, where the bound is the greater of threshold and noise floor.
    Faster,
    /// The whole interval lies above 1 + bound, where the bound is the greater of threshold and noise floor.
    Slower,
    /// The whole interval lies within 1 ± threshold.
    Same,
    /// The interval meets none of the conditions of the other verdicts.
    Undecided,
}

impl Verdict {
    /// All verdicts, in the order in which a summary lists them.
    pub const ALL: [Self; 4] = [Self::Faster, Self::Slower, Self::Same, Self::Undecided];

    /// Returns the verdict for the interval of `ratio`. The threshold (0 ≤ t < 1) and the noise floor (at least 0) are
    /// shares: 0.05 is 5 %. A change up to the greater of both is neither faster nor slower. The noise floor does not
    /// widen the range that counts as the same.
    pub fn for_ratio(ratio: &Ratio, threshold: f64, floor: f64) -> Self {
        let bound = threshold.max(floor);
        match (ratio.low, ratio.high) {
            (_, high) if high < 1.0 - bound => Self::Faster,
            (low, _) if low > 1.0 + bound => Self::Slower,
            (low, high) if low >= 1.0 - threshold && high <= 1.0 + threshold => Self::Same,
            _ => Self::Undecided,
        }
    }

    /// The name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Faster => "FASTER",
            Self::Slower => "SLOWER",
            Self::Same => "SAME",
            Self::Undecided => "UNDECIDED",
        }
    }
}

/// The greatest number of samples that [`samples_to_decide`] predicts. If more are needed, the ratio lies too near to
/// the bound.
pub const MOST_FORETOLD: u64 = 10_000;

/// Returns about how many samples would decide a verdict that `sample_count` samples left undecided, if the ratio does
/// not change.
/// The widths of the interval and of the noise floor are taken to fall with the square root of the number of samples.
/// The result is at least [`MIN_SAMPLES`] and more than `sample_count`; `None` above [`MOST_FORETOLD`].
pub fn samples_to_decide(ratio: &Ratio, sample_count: usize, threshold: f64, floor: f64) -> Option<u64> {
    if sample_count < MIN_SAMPLES {
        return Some(MIN_SAMPLES as u64);
    }
    let Ratio { ratio, low, high } = *ratio;
    let change = (ratio - 1.0).abs();
    // Width of the half of the interval that is on the side of 1.
    let half_width_toward_one = if ratio > 1.0 { ratio - low } else { high - ratio };
    // The factor by which the widths of the interval and of the noise floor must shrink.
    let shrink_factor = if change > threshold {
        // For a faster or slower B, the interval must end beyond the threshold and beyond the noise floor, which
        // shrinks, too.
        ((change - threshold) / half_width_toward_one).min(change / (half_width_toward_one + floor))
    } else {
        // For the same time, the upper and the lower half of the interval must lie within 1 ± threshold.
        ((1.0 + threshold - ratio) / (high - ratio)).min((ratio - 1.0 + threshold) / (ratio - low))
    };
    let needed_count = sample_count as f64 / (shrink_factor * shrink_factor);
    let is_foretold = needed_count.is_finite() && needed_count <= MOST_FORETOLD as f64;
    is_foretold.then(|| (needed_count.ceil() as u64).max(sample_count as u64 + 1))
}

/// Returns the ends [low, high] of the bootstrap interval of the median of the samples, at [`CONFIDENCE`], over
/// [`RESAMPLES`] resamples. `None` with fewer than [`MIN_SAMPLES`] samples.
pub fn interval_of_median(samples: &[f64], seed: u64) -> Option<[f64; 2]> {
    if samples.len() < MIN_SAMPLES {
        return None;
    }
    interval([samples], seed, |[samples]| median(samples))
}

/// Returns the ratio of the median of `b` to the median of `a`, with its interval over [`RESAMPLES`] resamples. Both
/// sides are resampled independently and with replacement. Samples must be finite and ≥ 0. `None` if a side has no
/// samples.
pub fn ratio_of_medians(a: &[f64], b: &[f64], seed: u64) -> Option<Ratio> {
    let ratio = quotient(median(&mut a.to_vec())?, median(&mut b.to_vec())?);
    let [low, high] = interval([a, b], seed, |[a, b]| Some(quotient(median(a)?, median(b)?)))?;
    Some(Ratio { ratio, low, high })
}

/// Returns the median of the ratios b / a of pairs [a, b] of times that were measured in turn, with its interval over
/// [`RESAMPLES`] resamples of the pairs. A disturbance that slows both times of a pair by one factor does not change
/// their ratio. Times must be finite and ≥ 0. `None` without pairs.
pub fn median_of_ratios(pairs: &[[f64; 2]], seed: u64) -> Option<Ratio> {
    let ratios: Vec<f64> = pairs.iter().map(|[a, b]| quotient(*a, *b)).collect();
    let [low, high] = interval([&ratios], seed, |[ratios]| median(ratios))?;
    Some(Ratio { ratio: median(&mut ratios.clone())?, low, high })
}

/// Returns the ends [low, high] of the interval that contains the share [`CONFIDENCE`] of the values of `statistic`
/// over [`RESAMPLES`] resamples. A resample draws from each series, with replacement, as many samples as the series
/// has. `None` if `statistic`, which may reorder the resample, has no value.
fn interval<const N: usize>(
    series: [&[f64]; N],
    seed: u64,
    statistic: impl Fn(&mut [Vec<f64>; N]) -> Option<f64>,
) -> Option<[f64; 2]> {
    let mut resampled = series.map(|samples| Vec::with_capacity(samples.len()));
    let mut statistics = Vec::with_capacity(RESAMPLES as usize);
    for resample in 0..RESAMPLES {
        let stream = Stream::new(seed, resample.into());
        // Index of the next random number of the stream, which all series share.
        let mut draw_index = 0;
        for (drawn, samples) in resampled.iter_mut().zip(series) {
            drawn.clear();
            for _ in samples {
                let index = (stream.uniform(draw_index) * samples.len() as f64) as usize;
                drawn.push(samples[index.min(samples.len() - 1)]);
                draw_index += 1;
            }
        }
        statistics.push(statistic(&mut resampled)?);
    }
    statistics.sort_by(f64::total_cmp);
    let tail_share = (1.0 - CONFIDENCE) / 2.0;
    Some([percentile(&statistics, tail_share)?, percentile(&statistics, 1.0 - tail_share)?])
}

/// Returns the noise floor: how far a time strays from itself, as a share. The series `a` and `again` are times of the
/// same work, measured in turn, so that the ratio of their true medians is 1. The distance from 1 to the farther end of
/// the ratio's confidence interval is therefore noise. `None` if a series has fewer than [`MIN_SAMPLES`] or the
/// distance is infinite.
pub fn noise_floor(a: &[f64], again: &[f64], seed: u64) -> Option<f64> {
    if a.len().min(again.len()) < MIN_SAMPLES {
        return None;
    }
    let Ratio { low, high, .. } = ratio_of_medians(a, again, seed)?;
    Some((1.0 - low).max(high - 1.0).max(0.0)).filter(|floor| floor.is_finite())
}

/// Returns the median of the samples: for an even number of them, the mean of the middle two; NaN without samples.
pub fn median_of(samples: impl IntoIterator<Item = f64>) -> f64 {
    median(&mut samples.into_iter().collect::<Vec<_>>()).unwrap_or(f64::NAN)
}

/// Sorts the samples and returns their median: for an even number of them, the mean of the middle two; `None` without
/// samples.
fn median(samples: &mut [f64]) -> Option<f64> {
    samples.sort_by(f64::total_cmp);
    let n = samples.len();
    // Both indices are equal for an odd number of samples.
    Some((samples.get(n.checked_sub(1)? / 2)? + samples.get(n / 2)?) / 2.0)
}

/// Returns b / a, or 1 if both are equal: a coarse clock may measure 0 for both, and 0 / 0 is not a number.
fn quotient(a: f64, b: f64) -> f64 {
    if a == b { 1.0 } else { b / a }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns `count` random samples, uniform over an interval of `width` around `center`.
    fn noise(center: f64, width: f64, count: u64, seed: u64) -> Vec<f64> {
        (0..count).map(|i| center + width * (Stream::new(seed, 99).uniform(i) - 0.5)).collect()
    }

    /// Returns the verdict on the times `b` compared with `a`, for a threshold of 5 % and no noise floor.
    fn verdict(a: &[f64], b: &[f64]) -> Verdict {
        Verdict::for_ratio(&ratio_of_medians(a, b, 1).expect("samples"), 0.05, 0.0)
    }

    #[test]
    fn constant_samples_have_an_interval_without_width() {
        let ratio = |b: f64| ratio_of_medians(&[3.0; 7], &[b; 9], 1).expect("samples");
        assert_eq!(ratio(3.0), Ratio { ratio: 1.0, low: 1.0, high: 1.0 });
        assert_eq!(ratio(6.0), Ratio { ratio: 2.0, low: 2.0, high: 2.0 });
        assert_eq!(ratio(1.5), Ratio { ratio: 0.5, low: 0.5, high: 0.5 });
        let verdicts = [3.0, 6.0, 1.5].map(|b| Verdict::for_ratio(&ratio(b), 0.05, 0.0));
        assert_eq!(verdicts, [Verdict::Same, Verdict::Slower, Verdict::Faster]);
    }

    #[test]
    fn the_verdict_depends_on_the_width_of_the_noise() {
        let base = noise(10.0, 0.4, 20, 1);
        assert_eq!(verdict(&base, &noise(10.0, 0.4, 20, 2)), Verdict::Same);
        assert_eq!(verdict(&base, &noise(12.0, 0.4, 20, 2)), Verdict::Slower);
        assert_eq!(verdict(&base, &noise(8.0, 0.4, 20, 2)), Verdict::Faster);
        let wide = |seed| noise(10.0, 12.0, 10, seed);
        assert_eq!(verdict(&wide(1), &wide(2)), Verdict::Undecided);
        // A difference that is as large as the threshold cannot be distinguished from no difference.
        assert_eq!(verdict(&base, &noise(10.5, 0.4, 20, 2)), Verdict::Undecided);
    }

    #[test]
    fn the_interval_of_three_samples_is_that_of_their_order_statistics() {
        // A is constant, so that the ratio is the median of a resample of {1, 2, 3}. It is 1 with probability 3 · 2/27
        // + 1/27 = 7/27, and 3 with the same probability. Both probabilities exceed the 2.5 % of a tail.
        let ratio = ratio_of_medians(&[1.0; 5], &[2.0, 3.0, 1.0], 1).expect("samples");
        assert_eq!(ratio, Ratio { ratio: 2.0, low: 1.0, high: 3.0 });
        // The median of a resample of seven values is the least value if that is drawn four times or more. The
        // probability, Σₖ C(7,k) 6^(7−k) / 7⁷ = 0.0102 for k ≥ 4, is less than the 0.025 of a tail. One of the least
        // two values is drawn so often with probability 0.108 > 0.025, so that the second value is the end of the
        // interval.
        let seven: Vec<f64> = (1..=7).map(f64::from).collect();
        let ratio = ratio_of_medians(&[1.0; 5], &seven, 1).expect("samples");
        assert_eq!(ratio, Ratio { ratio: 4.0, low: 2.0, high: 6.0 });
    }

    #[test]
    fn the_interval_covers_the_true_ratio_at_its_confidence() {
        let covers = |trial: u64| {
            let (a, b) = (noise(10.0, 2.0, 15, 2 * trial), noise(10.0, 2.0, 15, 2 * trial + 1));
            let ratio = ratio_of_medians(&a, &b, trial).expect("samples");
            ratio.low <= 1.0 && 1.0 <= ratio.high
        };
        let covered_trials = (0..200).filter(|trial| covers(*trial)).count();
        // The expected number is the share `CONFIDENCE` of all trials, with a standard deviation of 3. It is exceeded,
        // since the percentile interval of a median is a little wide.
        assert!((180..=200).contains(&covered_trials), "{covered_trials}");
        assert!(covered_trials < 200, "an interval that never misses is too wide");
    }

    #[test]
    fn zero_medians_and_empty_sides_are_defined() {
        assert_eq!(ratio_of_medians(&[0.0; 5], &[0.0; 5], 1), Some(Ratio { ratio: 1.0, low: 1.0, high: 1.0 }));
        let ratio = ratio_of_medians(&[0.0; 5], &[1.0; 5], 1).expect("samples");
        assert_eq!((ratio.low, Verdict::for_ratio(&ratio, 0.05, 0.0)), (f64::INFINITY, Verdict::Slower));
        assert_eq!((ratio_of_medians(&[], &[1.0], 1), ratio_of_medians(&[1.0], &[], 1)), (None, None));
    }

    #[test]
    fn what_slows_both_of_a_pair_does_not_widen_the_interval() {
        // A load doubles both times of every third pair. The second time of a pair is always a fifth longer.
        let load_factor = |n: u32| if n.is_multiple_of(3) { 2.0 } else { 1.0 };
        let pairs: Vec<[f64; 2]> = (0..12).map(|n| [load_factor(n), 1.2 * load_factor(n)]).collect();
        let paired = median_of_ratios(&pairs, 1).expect("pairs");
        assert!([paired.ratio, paired.low, paired.high].iter().all(|v| (v - 1.2).abs() < 1e-12), "{paired:?}");
        let [a, b] = [0, 1].map(|side| pairs.iter().map(|pair| pair[side]).collect::<Vec<_>>());
        let unpaired = ratio_of_medians(&a, &b, 1).expect("samples");
        assert!(unpaired.high > 2.0, "{unpaired:?}");
        assert_eq!(median_of_ratios(&[], 1), None);
    }

    #[test]
    fn equal_seeds_repeat_the_interval_and_others_change_it() {
        let (a, b) = (noise(5.0, 3.0, 12, 3), noise(5.0, 3.0, 12, 4));
        assert_eq!(ratio_of_medians(&a, &b, 7), ratio_of_medians(&a, &b, 7));
        assert_ne!(ratio_of_medians(&a, &b, 7), ratio_of_medians(&a, &b, 8));
    }

    #[test]
    fn verdicts_turn_at_the_threshold() {
        let verdict = |low, high| Verdict::for_ratio(&Ratio { ratio: 1.0, low, high }, 0.25, 0.0);
        assert_eq!(verdict(0.75, 1.25), Verdict::Same);
        assert_eq!([verdict(0.7, 0.75), verdict(0.7, 0.74)], [Verdict::Undecided, Verdict::Faster]);
        assert_eq!([verdict(1.25, 1.3), verdict(1.26, 1.3)], [Verdict::Undecided, Verdict::Slower]);
        assert_eq!(verdict(0.5, 1.5), Verdict::Undecided);
    }

    #[test]
    fn a_noise_floor_makes_nothing_the_same() {
        let verdict = |low, high, floor| Verdict::for_ratio(&Ratio { ratio: 1.0, low, high }, 0.05, floor);
        assert_eq!(verdict(0.702, 1.082, 0.34), Verdict::Undecided);
        assert_eq!([verdict(0.96, 1.04, 0.34), verdict(0.96, 1.04, 0.0)], [Verdict::Same; 2]);
        assert_eq!([verdict(1.2, 1.3, 0.34), verdict(1.2, 1.3, 0.1)], [Verdict::Undecided, Verdict::Slower]);
        assert_eq!([verdict(0.5, 0.6, 0.34), verdict(0.7, 0.8, 0.34)], [Verdict::Faster, Verdict::Undecided]);
    }

    #[test]
    fn as_many_samples_decide_as_are_foretold() {
        let foretold_count = |ratio, low, high, floor| samples_to_decide(&Ratio { ratio, low, high }, 10, 0.05, floor);
        // The end of the interval is four times as far from the ratio as allowed, which takes sixteen times as many
        // samples. Rounding may raise the number by one.
        let is_about = |found: Option<u64>, count: u64| {
            assert!(found == Some(count) || found == Some(count + 1), "{found:?}, {count}")
        };
        is_about(foretold_count(1.1, 0.9, 1.3, 0.0), 160);
        is_about(foretold_count(0.9, 0.7, 1.1, 0.0), 160);
        // If the ratio is within the threshold, the end of the interval that needs more samples decides.
        is_about(foretold_count(1.0, 0.9, 1.1, 0.0), 40);
        is_about(foretold_count(1.025, 0.925, 1.125, 0.0), 160);
        // An interval without a width is undecided only because of the noise floor, which shrinks with more samples,
        // too.
        is_about(foretold_count(1.1, 1.1, 1.1, 0.2), 40);
        assert_eq!(
            [foretold_count(1.0501, 0.9, 1.2, 0.0), foretold_count(f64::INFINITY, 1.0, f64::INFINITY, 0.0)],
            [None; 2]
        );
        assert_eq!(samples_to_decide(&Ratio { ratio: 1.0, low: 0.9, high: 1.1 }, 4, 0.05, 0.0), Some(5));
        // The predicted number of samples decides, if the noise stays the same.
        let ratio = |n| ratio_of_medians(&noise(10.0, 8.0, n, 1), &noise(13.0, 8.0, n, 2), 1).expect("samples");
        let ratio_of_ten = ratio(10);
        assert_eq!(Verdict::for_ratio(&ratio_of_ten, 0.05, 0.0), Verdict::Undecided);
        let needed = samples_to_decide(&ratio_of_ten, 10, 0.05, 0.0).expect("not too many");
        assert_eq!(Verdict::for_ratio(&ratio(2 * needed), 0.05, 0.0), Verdict::Slower, "{ratio_of_ten:?}: {needed}");
    }

    #[test]
    fn the_interval_of_a_median_holds_it_and_needs_samples() {
        let samples = noise(10.0, 4.0, 30, 5);
        let [low, high] = interval_of_median(&samples, 1).expect("enough");
        assert!(8.0 < low && low < median_of(samples.clone()) && median_of(samples) < high && high < 12.0);
        assert_eq!(interval_of_median(&[1.0; 4], 1), None);
    }
}
