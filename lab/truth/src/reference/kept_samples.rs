//! Samples of a world reference and of the screen's floor that other runs left in folders. A reference takes those of
//! its own samples that follow each other, and the rest are sampled. The result is that of sampling all of them, to the
//! bit.

use super::floor::ScreenFloor;
use super::partial_sums::PartialSums;
use super::world::WorldReference;
use super::world_state::{Fingerprint, Sums, WorldState, read_state, write_state};
use crate::error::{Error, Result};
use glam::DVec3;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// What the file names of references end with.
const WORLD: &str = ".world";
/// What the file names of floors end with.
const FLOOR: &str = ".floor";

/// The files of some samples, whose numbers begin with `first`.
struct KeptFiles {
    first: u32,
    world: PathBuf,
    floor: PathBuf,
}

/// The file in a folder that keeps all samples of a reference, by the [`short`] name of its fingerprint.
pub fn whole_file(folder: &Path, short: &str) -> PathBuf {
    folder.join(format!("{short}{WORLD}"))
}

/// The file in a folder that keeps some samples of a reference, by the [`short`] name of its fingerprint.
pub fn part_file(folder: &Path, short: &str, samples: &Range<u32>) -> PathBuf {
    folder.join(format!("{short}-{}-{}{WORLD}", samples.start, samples.end))
}

/// A short name of a fingerprint, for file names.
pub fn short(of: &Fingerprint) -> String {
    of.iter().take(16).map(|b| format!("{b:02x}")).collect()
}

/// Takes the samples of a range that a folder lacks, and keeps them there after each step. `go_on` is called between two
/// steps, and its error ends the sampling. If there is a floor, it takes the same samples.
///
/// # Errors
/// Errors of `go_on`, and [`Error::Io`] for files that cannot be written.
pub fn sample(
    reference: &WorldReference,
    mut floor: Option<&mut ScreenFloor>,
    samples: &Range<u32>,
    folder: &Path,
    go_on: &mut dyn FnMut() -> Result<()>,
) -> Result<()> {
    let world = part_file(folder, &short(&reference.fingerprint()), samples);
    let kept = KeptFiles { first: samples.start, floor: floor_beside(&world), world };
    // Samples that the folder lacks, or that cannot be read, are taken anew.
    let (mut state, sums) =
        load(reference, floor.as_deref(), &kept).unwrap_or_else(|_| (reference.start_at(samples.start), None));
    if let Some(floor) = floor.as_deref_mut() {
        floor.sums = sums.unwrap_or_else(|| PartialSums::new(samples.start, floor.sums.pixels()));
    }
    while let Some(stop) = state.sums.next_stop(samples.end) {
        go_on()?;
        let more = stop - state.samples();
        match floor.as_deref_mut() {
            Some(floor) => {
                floor.add(reference, &mut state, more);
                let sums = floor.sums.map(|sum| Sums::of_color(*sum));
                write_state(&kept.floor, &floor.fingerprint(reference), state.extent, &sums)?;
            }
            None => reference.add(&mut state, more),
        }
        state.save(&kept.world)?;
    }
    Ok(())
}

/// The floor's file beside that of its reference.
fn floor_beside(world: &Path) -> PathBuf {
    world.with_extension(&FLOOR[1..])
}

/// The state of a reference with the samples that some folders have of it, from number 0 as far as they follow each
/// other. If there is a floor, the same samples are added to it.
///
/// # Errors
/// [`Error::Io`] for a folder that cannot be read.
pub fn resume(
    reference: &WorldReference,
    mut floor: Option<&mut ScreenFloor>,
    folders: &[PathBuf],
) -> Result<WorldState> {
    let name = format!("{}-", short(&reference.fingerprint()));
    let mut files = Vec::new();
    for folder in folders {
        for entry in std::fs::read_dir(folder).map_err(|e| Error::io("read", folder, e))? {
            let path = entry.map_err(|e| Error::io("read", folder, e))?.path();
            let text = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
            let range = text.strip_prefix(&name).and_then(|rest| rest.strip_suffix(WORLD));
            if let Some(first) = range.and_then(|range| range.split_once('-')?.0.parse().ok()) {
                files.push(KeptFiles { first, floor: floor_beside(&path), world: path });
            }
        }
    }
    files.sort_by(|a, b| (a.first, &a.world).cmp(&(b.first, &b.world)));
    let mut state = reference.start();
    for kept in files {
        if kept.first != state.samples() {
            continue;
        }
        // Files that belong to another device's picture or that are damaged are left out; their samples are taken anew.
        let Ok((next, sums)) = load(reference, floor.as_deref(), &kept) else { continue };
        if !state.append(next) {
            continue;
        }
        if let (Some(floor), Some(sums)) = (floor.as_deref_mut(), sums)
            && !floor.sums.append(sums)
        {
            return Err(Error::malformed(&kept.floor, None, "has other samples than the file beside it"));
        }
    }
    Ok(state)
}

/// The samples in files: the state of the reference, and the sums of the floor if there is one.
fn load(
    reference: &WorldReference,
    floor: Option<&ScreenFloor>,
    kept: &KeptFiles,
) -> Result<(WorldState, Option<PartialSums<DVec3>>)> {
    let state = reference.load(&kept.world)?;
    let Some(floor) = floor else { return Ok((state, None)) };
    let read = read_state(&kept.floor)?;
    let of_the_same = read.fingerprint == floor.fingerprint(reference) && read.extent == state.extent;
    if !of_the_same || read.sums.first() != state.first() || read.sums.end() != state.samples() {
        return Err(Error::malformed(&kept.floor, None, "is of another picture or of other samples"));
    }
    Ok((state, Some(read.sums.map(Sums::color))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DefinitionsVersion;
    use crate::reference::first_hits::FirstHits;
    use crate::reference::surface::World;
    use crate::reference::testing;
    use crate::reference::world::Escape;
    use crate::scene::library;

    #[test]
    fn samples_of_other_runs_are_taken_up_and_change_no_bit() {
        let scene = library::scene("corridor").expect("built in");
        let view = &scene.views[0];
        let (materials, camera) = (scene.materials_in(view), view.camera(&scene, [12, 8]));
        let world = World::new(&scene, &materials);
        let data = testing::traced(&world, &camera, [12, 8]);
        let first_hits = FirstHits::from_gbuffer(&data);
        let of = |seed| WorldReference::by(DefinitionsVersion::V2, &world, &first_hits, &camera, Escape::Black, seed);
        let (reference, folder) = (of(3), tempfile::tempdir().expect("a folder"));
        let floor = || ScreenFloor::new(&data, &first_hits);
        let (mut whole, mut whole_floor) = (reference.start(), floor());
        whole_floor.add(&reference, &mut whole, 200);

        let folders: Vec<PathBuf> = ["a", "b"].map(|name| folder.path().join(name)).to_vec();
        let stop_after = |most: u32| {
            let mut steps = 0;
            move || {
                steps += 1;
                if steps > most { Err(Error::Stopped { signal: 15, kept: None }) } else { Ok(()) }
            }
        };
        let sampled = |n: usize, samples: Range<u32>, go_on: &mut dyn FnMut() -> Result<()>| {
            sample(&reference, Some(&mut floor()), &samples, &folders[n], go_on)
        };
        assert!(sampled(0, 0..128, &mut stop_after(1)).is_err(), "it was stopped");
        sampled(0, 0..128, &mut stop_after(1)).expect("one step is left");
        sampled(1, 192..200, &mut || Ok(())).expect("sampled");
        // Samples 128 to 191 are missing: everything from there on is sampled.
        let mut found = floor();
        let mut state = resume(&reference, Some(&mut found), &folders).expect("read");
        assert_eq!(state.samples(), 128);
        let more = 200 - state.samples();
        found.add(&reference, &mut state, more);
        assert_eq!((&state, found.image(&state)), (&whole, whole_floor.image(&whole)));
        sampled(1, 128..192, &mut || Ok(())).expect("sampled");
        let mut found = floor();
        let state = resume(&reference, Some(&mut found), &folders).expect("read");
        assert_eq!((&state, found.image(&state)), (&whole, whole_floor.image(&whole)));

        // The samples of another seed and the floor of another picture are not taken.
        assert_eq!(resume(&of(4), Some(&mut floor()), &folders).expect("read").samples(), 0);
        let mut darker = data.clone();
        darker.color.iter_mut().for_each(|c| *c *= 0.5);
        let mut other = ScreenFloor::new(&darker, &first_hits);
        assert_eq!(resume(&reference, Some(&mut other), &folders).expect("read").samples(), 0);
        assert_eq!(resume(&reference, None, &folders).expect("read"), whole);
    }
}
