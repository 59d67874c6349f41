//! Merges parts of a world reference's samples, which different machines took. The result is the state that one machine
//! would have sampled, to the bit. Merging needs neither the scene nor the camera.

use super::partial_sums::LEAF;
use super::world::state::{StoredState, read_state, write_state};
use ssct_ground::{Error, Result};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Some samples of a reference, read from a file.
#[derive(Debug, Clone)]
pub struct WorldPart {
    /// The file.
    pub path: PathBuf,
    /// The content of the file.
    stored: StoredState,
}

/// Returns the numbers of the samples, out of `samples`, that shard `index` (from 1 to `shards`) takes. Shards take
/// whole leaves of [`super::partial_sums`], as evenly divided as possible; some take none if there are more shards than
/// leaves.
pub fn samples_of(index: u32, shards: u32, samples: u32) -> Range<u32> {
    let leaves = u64::from(samples.div_ceil(LEAF));
    // The number of the first sample after shard number `shard`.
    let shard_end = |shard: u32| {
        let leaf = leaves * u64::from(shard) / u64::from(shards.max(1));
        (leaf * u64::from(LEAF)).min(u64::from(samples)) as u32
    };
    shard_end(index.saturating_sub(1))..shard_end(index)
}

impl WorldPart {
    /// Reads a part from its file.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read. [`Error::Malformed`] if it is not the state of a reference, or is
    /// damaged.
    pub fn read(path: &Path) -> Result<Self> {
        Ok(Self { path: path.to_owned(), stored: read_state(path)? })
    }

    /// Returns the range of the numbers of the samples.
    pub fn samples(&self) -> Range<u32> {
        self.stored.sums.first()..self.stored.sums.end()
    }

    /// Writes the part as a state from which sampling can be continued.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        write_state(path, &self.stored.fingerprint, self.stored.extent, &self.stored.sums)
    }
}

/// The result of merging parts.
#[derive(Debug)]
pub struct MergedParts {
    /// The samples from number 0 to before the first missing one, as one part; `None` if number 0 is missing.
    pub merged: Option<WorldPart>,
    /// The samples that no part has.
    pub missing: Vec<Range<u32>>,
}

/// Merges parts of one reference, which has `samples` samples in all.
///
/// # Errors
/// [`Error::Malformed`] for parts of different references, for parts that overlap only partly, and for parts with
/// different sums of the same samples.
pub fn merge(mut parts: Vec<WorldPart>, samples: u32) -> Result<MergedParts> {
    parts.retain(|part| !part.samples().is_empty());
    // If two parts begin with the same sample, the longer part comes first.
    parts.sort_by_key(|part| (part.samples().start, u32::MAX - part.samples().end));
    let mut merged: Option<WorldPart> = None;
    // `covered_end` is the number of the first sample after the parts so far, and `previous_part` is their last one.
    let (mut missing, mut covered_end): (Vec<Range<u32>>, u32) = (Vec::new(), 0);
    let mut previous_part: Option<WorldPart> = None;
    for part in parts {
        let range = part.samples();
        if let Some(previous_part) = &previous_part {
            let malformed = |message: String| Err(Error::malformed(&part.path, None, message));
            if previous_part.stored.fingerprint != part.stored.fingerprint
                || previous_part.stored.extent != part.stored.extent
            {
                return malformed(format!("is of another reference than {}", previous_part.path.display()));
            }
            if previous_part.samples() == range {
                if previous_part.stored.sums == part.stored.sums {
                    continue;
                }
                return malformed(format!("has other sums of the same samples than {}", previous_part.path.display()));
            }
            if range.start < covered_end {
                let [part_text, previous_text] = [range, previous_part.samples()].map(|numbers| samples_text(&numbers));
                return malformed(format!(
                    "has {part_text}, and {} has {previous_text}: they are of two divisions",
                    previous_part.path.display()
                ));
            }
        }
        if range.start > covered_end {
            missing.push(covered_end..range.start);
        }
        covered_end = range.end;
        previous_part = Some(part.clone());
        // Parts after a gap cannot be merged.
        if !missing.is_empty() {
            continue;
        }
        let Some(whole) = &mut merged else {
            merged = Some(part);
            continue;
        };
        if !whole.stored.sums.append(part.stored.sums) {
            return Err(Error::malformed(&part.path, None, "does not begin with a whole group of samples"));
        }
    }
    if covered_end < samples {
        missing.push(covered_end..samples);
    }
    Ok(MergedParts { merged, missing })
}

/// Returns a text that names samples by their numbers, such as "samples 3 to 7".
pub fn samples_text(samples: &Range<u32>) -> String {
    format!("samples {} to {}", samples.start, samples.end.saturating_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::first_hits::FirstHits;
    use crate::reference::surface::World;
    use crate::reference::world::WorldReference;
    use ssct_scenes::library;

    #[test]
    fn every_sample_is_in_one_shard() {
        for (shards, samples) in [(1, 1024), (3, 1024), (8, 1000), (5, 130), (7, 64), (4, 1), (1000, 1_048_576)] {
            let ranges: Vec<_> = (1..=shards).map(|index| samples_of(index, shards, samples)).collect();
            assert!(ranges.windows(2).all(|pair| pair[0].end == pair[1].start && pair[0].start.is_multiple_of(LEAF)));
            assert_eq!((ranges[0].start, ranges[ranges.len() - 1].end), (0, samples));
            let longest = ranges.iter().map(|range| range.len()).max().unwrap_or(0);
            assert!(
                longest <= (samples.div_ceil(LEAF).div_ceil(shards) * LEAF) as usize,
                "{shards} of {samples}: {longest}"
            );
        }
    }

    /// Calls `check` with two references that differ in their seed, for a few pixels, and with a temporary folder.
    fn with_references(check: impl Fn(&WorldReference, &WorldReference, &Path)) {
        let scene = library::scene("corridor").expect("built in");
        let view = &scene.views[0];
        let (materials, camera) = (scene.materials_in(view), view.camera(&scene, [12, 8]));
        let world = World::new(&scene, &materials);
        let first_hits = FirstHits::trace(&world, &camera, [12, 8]);
        let reference = |seed| WorldReference::new(&world, &first_hits, &camera, seed);
        let folder = tempfile::tempdir().expect("a folder");
        check(&reference(1), &WorldReference { seed: 2, ..reference(1) }, folder.path());
    }

    /// Takes a range of samples of a reference, saves them in a file in the folder, and returns the part that is read
    /// from it.
    fn part(reference: &WorldReference, folder: &Path, samples: Range<u32>) -> WorldPart {
        let path = folder.join(format!("{}-{}-{}", reference.seed, samples.start, samples.end));
        let mut state = reference.start_at(samples.start);
        // The steps do not divide the number of samples or the size of a leaf.
        while state.samples() < samples.end {
            let step = 37.min(samples.end - state.samples());
            reference.add(&mut state, step);
        }
        state.save(&path).expect("a file");
        WorldPart::read(&path).expect("a part")
    }

    #[test]
    fn merged_parts_are_the_reference_to_the_bit() {
        with_references(|reference, _, folder| {
            let mut whole = reference.start();
            reference.add(&mut whole, 300);
            for shards in [1, 2, 3, 7] {
                let parts =
                    (1..=shards).rev().map(|index| part(reference, folder, samples_of(index, shards, 300))).collect();
                let MergedParts { merged, missing } = merge(parts, 300).expect("one reference");
                assert_eq!(missing, []);
                let path = folder.join("merged");
                merged.expect("all of it").save(&path).expect("a file");
                let merged = reference.load(&path).expect("a state");
                assert_eq!(merged, whole, "{shards} parts");
                assert_eq!(reference.image(&merged), reference.image(&whole));
            }
            assert!(whole.overall_standard_error() > 0.0);
            // A part alone is an estimate, with a standard error of its own.
            let (last_part, refusal) = reference.resume_at(&folder.join("1-128-300"), 128);
            assert!(refusal.is_none() && last_part.sample_counts().max() == Some(172) && last_part.samples() == 300);
            assert!(last_part.overall_standard_error() > whole.overall_standard_error());
            assert!(reference.resume(&folder.join("1-128-300")).1.is_some(), "a part is not taken for all of it");
        });
    }

    #[test]
    fn what_is_missing_is_named_and_what_does_not_fit_is_refused() {
        with_references(|reference, other, folder| {
            let part_with = |range| part(reference, folder, range);
            let merged_parts = merge(vec![part_with(0..64), part_with(128..200)], 300).expect("with gaps");
            assert_eq!(merged_parts.missing, [64..128, 200..300]);
            assert_eq!(merged_parts.merged.expect("the first").samples(), 0..64);
            let merged_parts = merge(vec![part_with(64..128)], 128).expect("with gaps");
            assert!(merged_parts.merged.is_none());
            assert_eq!(merged_parts.missing.first(), Some(&(0..64)));
            let refusal = |parts| merge(parts, 300).expect_err("refused").to_string();
            assert!(refusal(vec![part_with(0..128), part_with(64..128)]).contains("of two divisions"));
            assert!(refusal(vec![part_with(0..64), part(other, folder, 64..128)]).contains("another reference"));
            let mut changed = part_with(0..64);
            changed.stored = StoredState { sums: part_with(0..64).stored.sums, ..changed.stored };
            assert!(merge(vec![part_with(0..64), changed.clone()], 64).expect("the same twice").missing.is_empty());
            let mut sums = crate::reference::partial_sums::PartialSums::new(0, 12 * 8);
            sums.open();
            sums.close(64);
            changed.stored.sums = sums;
            assert!(refusal(vec![part_with(0..64), changed]).contains("other sums"));
        });
    }
}
