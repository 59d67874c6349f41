//! Sums over the samples of pixels that do not depend on how runs divide the samples. One run, an interrupted run and
//! several runs that each take some of the samples give the same sums, to the bit.
//!
//! Floating-point sums depend on their grouping, so that the grouping is fixed. [`LEAF`] samples are added up one after
//! the other, and make a leaf of a binary tree over all samples. The sums of leaves and subtrees are added in pairs
//! (pairwise summation: Higham 1993). For a range of samples, one sum is kept for each largest subtree that the range
//! fills. There are at most two such subtrees for each level of the tree.

use std::ops::AddAssign;

/// The number of samples that are added up one after the other. Runs divide samples only at multiples of this number.
pub const LEAF: u32 = 64;

/// Sums of each pixel over the samples from number `first` to before number `end`.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialSums<S> {
    first: u32,
    end: u32,
    /// Number of pixels.
    pixels: usize,
    /// The subtrees that the samples fill, in order; the last one may be an unfinished leaf.
    parts: Vec<Part<S>>,
}

/// The sums over a subtree, which has a power of two of leaves, or over the beginning of a leaf.
#[derive(Debug, Clone, PartialEq)]
struct Part<S> {
    /// Number of the first sample.
    first: u32,
    /// Count of the samples.
    samples: u32,
    /// The sum of each pixel.
    sums: Vec<S>,
}

impl<S: Copy + Default + AddAssign> PartialSums<S> {
    /// Makes the sums of `pixels` pixels without samples. The first sample to be added has the number `first`, a
    /// multiple of [`LEAF`].
    pub fn new(first: u32, pixels: usize) -> Self {
        Self { first, end: first, pixels, parts: Vec::new() }
    }

    /// Returns the number of the first sample.
    pub fn first(&self) -> u32 {
        self.first
    }

    /// Returns the number of the sample that follows the last one.
    pub fn end(&self) -> u32 {
        self.end
    }

    /// Returns the number of pixels.
    pub fn pixels(&self) -> usize {
        self.pixels
    }

    /// Returns the number of the sample before which the caller must stop adding and call [`Self::close`]: the end of
    /// the current leaf, or `end` if that comes first. `None` once all samples before `end` are added.
    pub fn next_stop(&self, end: u32) -> Option<u32> {
        (self.end < end).then(|| (self.end / LEAF * LEAF).saturating_add(LEAF).min(end))
    }

    /// Returns the sums of the current leaf, one for each pixel. The caller adds the samples up to [`Self::next_stop`]
    /// to them, and then calls [`Self::close`].
    pub fn open(&mut self) -> &mut [S] {
        if self.end.is_multiple_of(LEAF) || self.parts.is_empty() {
            self.parts.push(Part { first: self.end, samples: 0, sums: vec![S::default(); self.pixels] });
        }
        let last = self.parts.len() - 1;
        &mut self.parts[last].sums
    }

    /// Notes that the caller added the samples before number `stop` to the sums that [`Self::open`] returned.
    pub fn close(&mut self, stop: u32) {
        if let Some(last) = self.parts.last_mut() {
            last.samples += stop - self.end;
        }
        self.end = stop;
        self.join_halves();
    }

    /// Joins the last two parts as long as they are the two halves of a larger subtree.
    fn join_halves(&mut self) {
        while let [.., left, right] = &mut self.parts[..] {
            let are_halves = left.samples == right.samples && left.samples.is_multiple_of(LEAF);
            let begins_subtree = u64::from(left.first).is_multiple_of(2 * u64::from(left.samples.max(1)));
            if !(are_halves && begins_subtree) {
                return;
            }
            left.sums.iter_mut().zip(&right.sums).for_each(|(left, right)| *left += *right);
            left.samples *= 2;
            self.parts.pop();
        }
    }

    /// Appends the sums of the samples that follow these. Returns false, and adds nothing, if `next` does not begin
    /// where these sums end, does not begin with a leaf, or has another number of pixels.
    #[must_use]
    pub fn append(&mut self, next: Self) -> bool {
        if next.first != self.end || !next.first.is_multiple_of(LEAF) || next.pixels != self.pixels {
            return false;
        }
        for part in next.parts {
            self.parts.push(part);
            self.join_halves();
        }
        self.end = next.end;
        true
    }

    /// Applies a function to each sum, and returns the results in the same parts.
    pub fn map<T>(&self, function: impl Fn(&S) -> T) -> PartialSums<T> {
        let map_part = |part: &Part<S>| {
            let sums = part.sums.iter().map(&function).collect();
            Part { first: part.first, samples: part.samples, sums }
        };
        PartialSums {
            first: self.first,
            end: self.end,
            pixels: self.pixels,
            parts: self.parts.iter().map(map_part).collect(),
        }
    }

    /// Returns the sum of a pixel over all samples; the parts are added in order.
    pub fn total(&self, pixel: usize) -> S {
        let mut part_sums = self.parts.iter().map(|part| part.sums[pixel]);
        let first_sum = part_sums.next().unwrap_or_default();
        part_sums.fold(first_sum, |mut sum, next_sum| {
            sum += next_sum;
            sum
        })
    }

    /// Returns the sums in the order in which files keep them: the sums of all pixels, part by part.
    pub fn in_file_order(&self) -> impl Iterator<Item = &S> {
        self.parts.iter().flat_map(|part| &part.sums)
    }

    /// Restores the sums of the samples from `first` to before `end` from the result of [`Self::in_file_order`]; `None`
    /// if there are too few sums or too many.
    pub fn from_file_order(first: u32, end: u32, pixels: usize, mut stored: impl Iterator<Item = S>) -> Option<Self> {
        let mut sums = Self::new(first, pixels);
        for (first, samples) in parts(first, end) {
            let part = Part { first, samples, sums: stored.by_ref().take(pixels).collect() };
            if part.sums.len() != pixels {
                return None;
            }
            sums.parts.push(part);
        }
        sums.end = end;
        stored.next().is_none().then_some(sums)
    }
}

/// Splits the samples `first..end` into the parts of the tree that they fill. Returns the first sample of each part,
/// and the number of its samples. `first` is a multiple of [`LEAF`].
pub fn parts(first: u32, end: u32) -> Vec<(u32, u32)> {
    let (mut start, end, leaf) = (u64::from(first), u64::from(end), u64::from(LEAF));
    let mut parts = Vec::new();
    while start < end {
        let mut samples = leaf;
        while start.is_multiple_of(2 * samples) && start + 2 * samples <= end {
            samples *= 2;
        }
        let samples = samples.min(end - start);
        parts.push((start as u32, samples as u32));
        start += samples;
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use ssct_ground::math::random::Stream;

    /// Returns the sums over random samples from `first` to before `end`, whose numbers differ so much in size that
    /// their sum depends on its grouping. `batch` samples are added at a time.
    fn summed(first: u32, end: u32, batch: u32) -> PartialSums<f64> {
        let mut sums = PartialSums::new(first, 3);
        while sums.end() < end {
            let batch_end = (sums.end() + batch).min(end);
            while let Some(stop) = sums.next_stop(batch_end) {
                let leaf_start = sums.end();
                for (pixel, sum) in sums.open().iter_mut().enumerate() {
                    let stream = Stream::new(5, pixel as u64);
                    for sample in leaf_start..stop {
                        *sum += (40.0 * stream.uniform(u64::from(sample))).exp();
                    }
                }
                sums.close(stop);
            }
        }
        sums
    }

    #[test]
    fn a_few_samples_are_added_one_after_the_other() {
        let stream = Stream::new(5, 1);
        let sequential_sum = (0..LEAF).fold(0.0, |sum, sample| sum + (40.0 * stream.uniform(u64::from(sample))).exp());
        assert_eq!(summed(0, LEAF, 7).total(1), sequential_sum);
        assert_eq!(PartialSums::<f64>::new(0, 2).total(1), 0.0);
    }

    #[test]
    fn parts_are_the_greatest_that_are_filled() {
        assert_eq!(parts(0, 64 * 7 + 5), [(0, 256), (256, 128), (384, 64), (448, 5)]);
        assert_eq!(parts(192, 512), [(192, 64), (256, 256)]);
        assert_eq!(parts(64, 64), []);
        let sums = summed(0, 64 * 7 + 5, 1000);
        let ranges: Vec<_> = sums.parts.iter().map(|part| (part.first, part.samples)).collect();
        assert_eq!(ranges, parts(0, 64 * 7 + 5));
    }

    proptest! {
        /// Tests that the sums have the same bits, however the samples are divided, interrupted and kept.
        #[test]
        fn divided_sums_are_the_undivided_ones(
            leaves in proptest::collection::vec(0_u32..9, 1..6),
            rest in 0_u32..LEAF,
            batch in 1_u32..200,
        ) {
            let end = LEAF * leaves.iter().sum::<u32>() + rest;
            let whole = summed(0, end, u32::MAX / 2);
            prop_assert_eq!(&summed(0, end, batch), &whole);
            let (mut merged, mut start) = (PartialSums::new(0, 3), 0);
            for (index, leaf_count) in leaves.iter().enumerate() {
                let stop = if index + 1 == leaves.len() { end } else { start + LEAF * leaf_count };
                let part = summed(start, stop, batch);
                let restored = PartialSums::from_file_order(start, stop, 3, part.in_file_order().copied());
                prop_assert!(merged.append(restored.expect("as many as there are")));
                start = stop;
            }
            prop_assert_eq!(&merged, &whole);
            prop_assert!(!merged.clone().append(summed(end / LEAF * LEAF + LEAF, end + 4 * LEAF, 64)), "a gap");
            let sums: Vec<_> = whole.in_file_order().copied().collect();
            let more = sums.iter().copied().chain([0.0]);
            prop_assert!(PartialSums::from_file_order(0, end, 3, more).is_none(), "one sum too many");
            let fewer = sums.into_iter().skip(1);
            prop_assert!(end == 0 || PartialSums::from_file_order(0, end, 3, fewer).is_none(), "one sum too few");
        }
    }
}
