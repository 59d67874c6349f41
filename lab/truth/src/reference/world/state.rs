//! The sums of a world reference and their file. A long run can stop and continue later with a result that is identical
//! to the bit. A file contains a fingerprint of the inputs of the reference and is rejected for any other inputs.

use super::{EscapeRadiance, WorldReference};
use crate::reference::partial_sums::{LEAF, PartialSums, parts};
use glam::DVec3;
use sha2::{Digest, Sha256};
use ssct_ground::{Error, Result};
use ssct_scenes::inside::PathInFolder;
use ssct_scenes::{Encoding, Light, Surface};
use std::io::Read;
use std::ops::AddAssign;
use std::path::Path;

/// The file's first bytes.
const MAGIC: &[u8; 8] = b"ssctwrld";
/// The version of the samples. The number must change whenever the sampling or the shading changes.
const SAMPLING: u32 = 1;
/// The version of the file's layout. The number must change whenever the meaning of the numbers in a file changes.
const LAYOUT: u32 = 2;
/// The layout of older files, which have one sum a pixel and do not record the number of the first sample.
const LAYOUT_OF_ONE_SUM: u32 = 1;
/// Bytes of the head: magic, layout, fingerprint, width, height, number of the first sample, number after the last.
const HEAD_BYTES: usize = 8 + 4 + 32 + 4 + 4 + 4 + 4;
/// Bytes of a pixel in each part of the sums: six f64.
const PIXEL_BYTES: usize = 48;
/// Bytes of the SHA-256 hash of all preceding bytes.
const CHECK_BYTES: usize = 32;

/// A hash of all inputs of a state.
pub type Fingerprint = [u8; 32];

/// Sums over the samples of every pixel; rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldState {
    /// Hash of the inputs of the reference.
    fingerprint: Fingerprint,
    /// Width and height in pixels.
    pub extent: [u32; 2],
    pub(crate) sums: PartialSums<Sums>,
    /// The samples that each pixel takes.
    pub(crate) kinds: Vec<Kind>,
}

/// The sums of one pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Sums {
    /// Sum of the samples' linear colours.
    color: DVec3,
    /// Sum of the squares of the colours, channel by channel, for the standard error.
    squares: DVec3,
}

/// The samples that a pixel takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// No samples, because the pixel does not reflect.
    None,
    /// A single sample, for a mirror without a footprint.
    Single,
    /// All samples, and at least `least` as soon as there are any.
    Sampled { least: u32 },
}

impl Kind {
    /// Returns the number of samples that a pixel of this kind has taken, in a state with `state_samples` samples.
    pub(crate) fn samples(self, state_samples: u32) -> u32 {
        match self {
            Self::None => 0,
            Self::Single => state_samples.min(1),
            Self::Sampled { least } if state_samples > 0 => state_samples.max(least),
            Self::Sampled { .. } => 0,
        }
    }
}

impl Sums {
    /// Adds a sample's colour.
    pub(crate) fn add(&mut self, color: DVec3) {
        self.color += color;
        self.squares += color * color;
    }
}

impl AddAssign for Sums {
    fn add_assign(&mut self, other: Self) {
        self.color += other.color;
        self.squares += other.squares;
    }
}

impl WorldState {
    /// Makes a state without samples, whose first sample will have the number `first`.
    pub(crate) fn new(fingerprint: Fingerprint, extent: [u32; 2], first: u32, kinds: Vec<Kind>) -> Self {
        Self { fingerprint, extent, sums: PartialSums::new(first, kinds.len()), kinds }
    }

    /// Returns the number of the first sample: 0, except in a part of the samples.
    pub fn first(&self) -> u32 {
        self.sums.first()
    }

    /// Returns one more than the number of the last sample. In a whole state, whose first sample has the number 0, this
    /// is the number of samples that each glossy pixel has so far.
    pub fn samples(&self) -> u32 {
        self.sums.end()
    }

    /// Returns the number of pixels that need more than one sample.
    pub fn sampled_pixels(&self) -> usize {
        self.kinds.iter().filter(|kind| matches!(kind, Kind::Sampled { .. })).count()
    }

    /// Returns the number of samples of each pixel.
    pub fn sample_counts(&self) -> impl Iterator<Item = u32> {
        self.kinds.iter().map(|kind| self.count(*kind))
    }

    /// Returns the number of samples that a pixel of a kind has in this state.
    fn count(&self, kind: Kind) -> u32 {
        kind.samples(self.samples()) - kind.samples(self.first())
    }

    /// Returns the sums of each pixel over all samples.
    fn totals(&self) -> impl Iterator<Item = Sums> {
        (0..self.sums.pixels()).map(|pixel| self.sums.total(pixel))
    }

    /// Returns the mean linear colour of each pixel; black without samples.
    pub fn means(&self) -> impl Iterator<Item = DVec3> {
        self.totals().zip(self.sample_counts()).map(|(sums, count)| sums.color / f64::from(count.max(1)))
    }

    /// Returns the standard error of each pixel's mean, per channel: √(sample variance / count). It is 0 for a mirror's
    /// single ray and where nothing reflects, and infinite for any other pixel with fewer than two samples.
    pub fn standard_errors(&self) -> impl Iterator<Item = DVec3> {
        self.totals().zip(&self.kinds).map(move |(sums, kind)| {
            let count = f64::from(self.count(*kind));
            match kind {
                Kind::Sampled { .. } if count < 2.0 => DVec3::INFINITY,
                Kind::Sampled { .. } => {
                    let variance = ((sums.squares - sums.color * sums.color / count) / (count - 1.0)).max(DVec3::ZERO);
                    (variance / count).map(f64::sqrt)
                }
                _ => DVec3::ZERO,
            }
        })
    }

    /// Returns the root mean square of the standard errors over all channels of all reflecting pixels; 0 if nothing
    /// reflects. By the square of this number the noise of the reference raises the square of an RMSE that is measured
    /// against it.
    pub fn overall_standard_error(&self) -> f64 {
        let reflecting = self.kinds.iter().filter(|kind| **kind != Kind::None).count();
        let squared_errors: f64 = self.standard_errors().map(|error| error.length_squared()).sum();
        if reflecting == 0 { 0.0 } else { (squared_errors / (3 * reflecting) as f64).sqrt() }
    }

    /// Writes the state atomically: to a temporary file in the target's folder, which is then renamed.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        write_state(path, &self.fingerprint, self.extent, &self.sums)
    }
}

/// The content of a state's file, whichever reference it belongs to.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StoredState {
    pub(crate) fingerprint: Fingerprint,
    pub(crate) extent: [u32; 2],
    pub(crate) sums: PartialSums<Sums>,
}

/// Writes the file of a state, as [`WorldState::save`] does.
pub(crate) fn write_state(
    path: &Path,
    fingerprint: &Fingerprint,
    extent: [u32; 2],
    sums: &PartialSums<Sums>,
) -> Result<()> {
    let mut bytes = Vec::with_capacity(HEAD_BYTES + PIXEL_BYTES * sums.in_file_order().count() + CHECK_BYTES);
    bytes.extend(MAGIC);
    bytes.extend(LAYOUT.to_le_bytes());
    bytes.extend(fingerprint);
    for v in [extent[0], extent[1], sums.first(), sums.end()] {
        bytes.extend(v.to_le_bytes());
    }
    for v in sums.in_file_order().flat_map(|s| [s.color.to_array(), s.squares.to_array()]).flatten() {
        bytes.extend(v.to_le_bytes());
    }
    let check = Sha256::digest(&bytes);
    bytes.extend(check);
    PathInFolder::file(path).write(&bytes)
}

/// Reads the file of a state, whichever reference it belongs to.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`] if the file is not a state, is damaged or truncated,
/// or was made by another version.
pub(crate) fn read_state(path: &Path) -> Result<StoredState> {
    let unreadable = |e| Error::io("read", path, e);
    let file = PathInFolder::file(path).open()?.ok_or_else(|| unreadable(std::io::ErrorKind::NotFound.into()))?;
    let length = file.metadata().map_err(unreadable)?.len();
    let malformed = |message: &str| Error::malformed(path, None, message);
    // At most as many bytes are read as the file has now.
    let mut file = file.take(length);
    let mut bytes = Vec::new();
    (&mut file).take(HEAD_BYTES as u64).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() < HEAD_BYTES || !bytes.starts_with(MAGIC) {
        return Err(malformed("this is not a state of a world reference"));
    }
    // The number at an offset in bytes; HEAD_BYTES lists the fields of the head.
    let number_at = |offset: usize| u32::from_le_bytes(std::array::from_fn(|i| bytes[offset + i]));
    let (extent, layout) = ([number_at(44), number_at(48)], number_at(8));
    let (first, end, head) = match layout {
        LAYOUT => (number_at(52), number_at(56), HEAD_BYTES),
        // The single sum of an older file has the fixed grouping only if all its samples fit into one leaf.
        LAYOUT_OF_ONE_SUM if number_at(52) <= LEAF => (0, number_at(52), HEAD_BYTES - 4),
        _ => return Err(malformed("the state was written by another version")),
    };
    let damaged = || malformed("the state is damaged or cut off");
    let pixels = extent[0] as usize * extent[1] as usize;
    // An older file has one sum a pixel even without samples.
    let part_count = if layout == LAYOUT { parts(first, end).len() } else { 1 };
    let expected = pixels.checked_mul(part_count * PIXEL_BYTES).and_then(|n| n.checked_add(head));
    // The sums are read only if the file is as long as its head says.
    if expected.and_then(|n| n.checked_add(CHECK_BYTES)).map(|n| n as u64) != Some(length) {
        return Err(damaged());
    }
    file.read_to_end(&mut bytes).map_err(unreadable)?;
    let (content, check) = bytes.split_at(bytes.len().saturating_sub(CHECK_BYTES));
    let is_aligned = first.is_multiple_of(LEAF) && first <= end;
    if !is_aligned || expected != Some(content.len()) || Sha256::digest(content)[..] != *check {
        return Err(damaged());
    }
    // A pixel has the three channels of the colours' sum, and then those of the squares' sum.
    let sums = content[head..].as_chunks::<PIXEL_BYTES>().0.iter().map(|bytes| {
        let channel_sums: [f64; 6] =
            std::array::from_fn(|i| f64::from_le_bytes(std::array::from_fn(|k| bytes[8 * i + k])));
        Sums { color: DVec3::from_slice(&channel_sums[..3]), squares: DVec3::from_slice(&channel_sums[3..]) }
    });
    // The sums of an older file without samples are skipped.
    let used_sums = if end > first { pixels * part_count } else { 0 };
    let sums = PartialSums::from_file_order(first, end, pixels, sums.take(used_sums)).ok_or_else(damaged)?;
    Ok(StoredState { fingerprint: std::array::from_fn(|i| bytes[12 + i]), extent, sums })
}

impl WorldReference<'_> {
    /// Reads a state of this reference from its file.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read. [`Error::Malformed`] if the file is not a state, is damaged or
    /// truncated, or was made from another scene, camera, size, seed or version.
    pub fn load(&self, path: &Path) -> Result<WorldState> {
        let stored = read_state(path)?;
        let state = self.start_at(stored.sums.first());
        if stored.fingerprint != state.fingerprint || stored.extent != state.extent {
            let message = "the state belongs to another scene, camera, size, seed or material";
            return Err(Error::malformed(path, None, message));
        }
        Ok(WorldState { sums: stored.sums, ..state })
    }

    /// Returns the state that a file has, if it belongs to this reference, and otherwise a state without samples. The
    /// error, if there is one, says why an existing file was not used.
    pub fn resume(&self, path: &Path) -> (WorldState, Option<Error>) {
        self.resume_at(path, 0)
    }

    /// Does the same as [`Self::resume`] for a part of the samples that begins with number `first`.
    pub fn resume_at(&self, path: &Path, first: u32) -> (WorldState, Option<Error>) {
        match self.load(path) {
            Ok(state) if state.first() == first => (state, None),
            Ok(state) => {
                let message = format!("the state begins with sample {} and not with {first}", state.first());
                (self.start_at(first), Some(Error::malformed(path, None, message)))
            }
            Err(Error::Io { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => {
                (self.start_at(first), None)
            }
            Err(error) => (self.start_at(first), Some(error)),
        }
    }

    /// Returns a hash of everything that a sample depends on: geometry, textures, materials, lights, first hits (and
    /// with them camera and size), escape, footprint, bounces, seed and version.
    pub fn fingerprint(&self) -> Fingerprint {
        let mut hash = Hash(Sha256::new());
        hash.numbers(&[u64::from(SAMPLING), self.seed, u64::from(self.escape == EscapeRadiance::Environment)]);
        if self.bounces > 1 {
            hash.numbers(&[u64::from(self.bounces)]);
        }
        for mesh in &self.world.scene.meshes {
            hash.block(bytemuck::cast_slice(&mesh.vertices));
            hash.block(bytemuck::cast_slice(&mesh.indices));
            hash.numbers(&[mesh.material as u64]);
        }
        for texture in &self.world.scene.textures {
            let encoding = u64::from(texture.encoding == Encoding::Srgb);
            hash.numbers(&[u64::from(texture.width), u64::from(texture.height), encoding]);
            hash.block(&texture.rgba);
        }
        for material in self.world.materials {
            hash.floats(&material.albedo.to_array());
            hash.floats(&[material.reflectivity, material.roughness, material.normal_deviation]);
            for map in [material.albedo_map, material.normal_map, material.alpha_mask, material.reflectivity_map] {
                hash.numbers(&[map.map_or(u64::MAX, |texture| texture as u64)]);
            }
            hash.numbers(&[u64::from(material.surface == Surface::Sky)]);
            // Values that few materials have are hashed for these alone, so that states that are older than the values
            // still fit.
            if material.roughness_map.is_some() || material.emission > 0.0 || material.single_sided {
                hash.block(b"roughness map, emission, sides");
                hash.numbers(&[
                    material.roughness_map.map_or(u64::MAX, |texture| texture as u64),
                    u64::from(material.single_sided),
                ]);
                hash.floats(&[material.emission]);
            }
        }
        for light in &self.world.scene.lights {
            let (kind, place, energy) = match *light {
                Light::Point { position, energy } => (0, position, energy),
                Light::Directional { direction, energy } => (1, direction, energy),
            };
            hash.numbers(&[kind]);
            hash.floats(&place.extend(energy).to_array());
        }
        // A missing footprint is not hashed, so that states that are older than footprints still fit.
        if let Some(rays) = &self.footprint {
            hash.block(b"footprint");
            hash.numbers(&rays.numbers().into_iter().map(f64::to_bits).collect::<Vec<_>>());
        }
        hash.numbers(&[u64::from(self.first_hits.width), u64::from(self.first_hits.height)]);
        for receiver in &self.first_hits.receivers {
            hash.numbers(&[u64::from(receiver.is_some())]);
            if let Some(receiver) = receiver {
                for v in [receiver.position, receiver.incoming, receiver.normal, receiver.geometric_normal] {
                    hash.numbers(&v.to_array().map(f64::to_bits));
                }
                hash.numbers(&[receiver.roughness.to_bits()]);
            }
        }
        hash.0.finalize().into()
    }
}

/// A hash of numbers and of blocks of bytes. It includes the lengths of the blocks, so that different inputs never give
/// the same bytes to hash.
struct Hash(Sha256);

impl Hash {
    /// Hashes whole numbers.
    fn numbers(&mut self, values: &[u64]) {
        for value in values {
            self.0.update(value.to_le_bytes());
        }
    }

    /// Hashes floats by their bits.
    fn floats(&mut self, values: &[f32]) {
        for value in values {
            self.0.update(value.to_le_bytes());
        }
    }

    /// Hashes the length of a block, and then its bytes.
    fn block(&mut self, bytes: &[u8]) {
        self.numbers(&[bytes.len() as u64]);
        self.0.update(bytes);
    }
}
