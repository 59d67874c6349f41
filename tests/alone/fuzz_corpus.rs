//! Gives every input that fuzzing has kept (`make fuzz`), and seeded mutations of them, to the entries of the fuzz
//! targets. No entry may panic, or take more memory than an input of its length may take. Headers that claim more than
//! their files can hold must each be refused in a sentence.

#[path = "../../fuzz/src/entry.rs"]
mod entry;

use crate::common::repository;
use crate::is_alone;
use crate::memory::bounded;
use ssct_geometry::texture;
use ssct_scenes::{Encoding, gbuffer_file, path};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The number of mutations that each target gets, over all of its inputs.
const MUTATIONS: u64 = 2000;

/// A random number generator: SplitMix64 (Steele et al. 2014), with its state.
struct Random(u64);

impl Random {
    /// Returns a random number below `n`, or 0 if `n` is 0.
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n.max(1) as u64) as usize
    }
}

/// Returns an input changed in one to four places: bits, bytes or runs of extreme values are set, and runs are removed,
/// repeated or replaced by some of the input `other`.
fn mutate(input: &[u8], other: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = input.to_vec();
    for _ in 0..=random.below(4) {
        let start = random.below(bytes.len());
        let end = (start + 1 + random.below(16)).min(bytes.len());
        match random.below(6) {
            _ if bytes.is_empty() => bytes.push(random.below(256) as u8),
            0 => bytes[start] ^= 1 << random.below(8),
            1 => bytes[start] = random.below(256) as u8,
            2 => bytes[start..end].fill([0, 0x7f, 0x80, 0xff][random.below(4)]),
            3 => drop(bytes.drain(start..end)),
            4 => drop(bytes.splice(start..start, bytes[start..end].to_vec())),
            _ => {
                let from = random.below(other.len());
                let run = &other[from..(from + 1 + random.below(32)).min(other.len())];
                drop(bytes.splice(start..end, run.iter().copied()));
            }
        }
    }
    bytes
}

/// Returns the inputs that the archive of a fuzz target in `fuzz/corpus` keeps, in the archive's order.
fn kept_inputs(target: &str) -> Vec<Vec<u8>> {
    let file = File::open(repository().join("fuzz/corpus").join(format!("{target}.tar.gz"))).unwrap();
    let mut archive = tar::Archive::new(flate2::read::GzDecoder::new(file));
    let read = |entry: std::io::Result<tar::Entry<_>>| {
        let mut input = Vec::new();
        entry.unwrap().read_to_end(&mut input).unwrap();
        input
    };
    archive.entries().unwrap().map(read).collect()
}

/// No entry of the fuzz targets panics or exceeds its bound of memory, whether it gets a kept input or a mutation of
/// one. Fuzzing runs rarely, so that a change could bring back what it once found.
#[test]
fn kept_inputs_and_their_mutations_are_loaded_or_refused() {
    if !is_alone() {
        return;
    }
    for (name, entry) in entry::ENTRIES {
        let inputs = kept_inputs(name);
        let loaded = inputs.iter().filter(|input| bounded(entry, input)).count();
        assert!(loaded > 0 && loaded < inputs.len(), "{name}: {loaded} of {} inputs are loaded", inputs.len());
        let mut random = Random(7);
        for _ in 0..MUTATIONS {
            let [input, other] = [0, 1].map(|_| &inputs[random.below(inputs.len())]);
            bounded(entry, &mutate(input, other, &mut random));
        }
    }
}

/// Loads an input, which must fail within the memory that an input of its length may take, and returns the error's
/// text. `load` returns `None` if the input is loaded.
fn refused(bytes: &[u8], load: impl FnOnce(&[u8]) -> Option<String>) -> String {
    bounded(load, bytes).expect("an error")
}

/// Decodes an image, whose format the extension of `name` says. Returns the error's text, if there is an error.
fn texture(name: &'static str, bytes: &[u8]) -> Option<String> {
    texture::from_bytes(bytes, Path::new(name), Encoding::Srgb).err().map(|e| e.to_string())
}

/// Returns the CRC-32 of a PNG chunk.
fn crc(bytes: &[u8]) -> u32 {
    let step = |crc: u32, byte: &u8| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { c >> 1 ^ 0xedb8_8320 } else { c >> 1 })
    };
    !bytes.iter().fold(!0, step)
}

/// Returns a PNG file whose header claims a width and a height in pixels, with an empty stream of pixels.
fn png(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
    let header = [&b"IHDR"[..], &width.to_be_bytes(), &height.to_be_bytes(), &[8, 6, 0, 0, 0]].concat();
    for chunk in [&header[..], b"IDAT\x78\x9c\x03\x00\x00\x00\x00\x01", b"IEND"] {
        bytes.extend(u32::to_be_bytes(chunk.len() as u32 - 4));
        bytes.extend(chunk);
        bytes.extend(crc(chunk).to_be_bytes());
    }
    bytes
}

/// Returns a TGA file whose header claims a width, a height and a kind of image, with five bytes of pixels. Kind 2 is
/// uncompressed, kind 10 run-length encoded.
fn tga(width: u16, height: u16, kind: u8) -> Vec<u8> {
    let [w, h] = [width, height].map(u16::to_le_bytes);
    [&[0, 0, kind, 0, 0, 0, 0, 0, 0, 0, 0, 0][..], &w, &h, &[32, 0x20], &[0x81, 1, 2, 3, 4]].concat()
}

/// Returns an OpenEXR header that claims a number of float channels and a size in pixels, in ZIP-compressed scan lines,
/// with no pixels.
fn exr(width: u32, height: u32, channels: usize) -> Vec<u8> {
    let mut bytes = [&[0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0][..]].concat();
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        let length = (value.len() as u32).to_le_bytes();
        bytes.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &length, value].concat());
    };
    let channel =
        |n: usize| [format!("c{n:06}\0").as_bytes(), &[2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]].concat();
    let list: Vec<u8> = (0..channels).flat_map(channel).chain([0]).collect();
    let window: Vec<u8> =
        [0, 0, width.wrapping_sub(1), height.wrapping_sub(1)].iter().flat_map(|v| v.to_le_bytes()).collect();
    attribute("channels", "chlist", &list);
    attribute("compression", "compression", &[3]);
    attribute("dataWindow", "box2i", &window);
    attribute("displayWindow", "box2i", &window);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1_f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1_f32.to_le_bytes());
    bytes.push(0);
    bytes
}

/// A PNG of 65 bytes that claims huge sides is refused before memory for its texels is allocated.
#[test]
fn a_png_that_claims_a_billion_squared_is_refused() {
    if !is_alone() {
        return;
    }
    let load = |bytes: &[u8]| texture("a.png", bytes);
    let message = refused(&png(1_000_000_000, 1_000_000_000), load);
    assert!(message.starts_with("a.png: "), "{message}");
    let message = refused(&png(16_384, 16_384), load);
    assert_eq!(message, "a.png: an image of 16384 x 16384 texels cannot come from only 65 bytes");
}

/// A TGA of 23 bytes that claims the greatest sides is refused, compressed or not, before memory for its texels is
/// allocated.
#[test]
fn a_tga_that_claims_all_that_it_can_is_refused() {
    if !is_alone() {
        return;
    }
    for kind in [2, 10] {
        let load = |bytes: &[u8]| texture("a.tga", bytes);
        let message = refused(&tga(65_535, 65_535, kind), load);
        assert!(message.starts_with("a.tga: "), "{message}");
        let message = refused(&tga(16_384, 16_384, kind), load);
        assert_eq!(message, "a.tga: an image of 16384 x 16384 texels cannot come from only 23 bytes");
    }
}

/// An OpenEXR header that claims huge sides, or thousands of channels, is refused before memory for its pixels is
/// allocated.
#[test]
fn an_exr_that_claims_a_billion_squared_is_refused() {
    if !is_alone() {
        return;
    }
    let load = |bytes: &[u8]| gbuffer_file::decode(bytes, Path::new("a.exr")).err().map(|e| e.to_string());
    let message = refused(&exr(1_000_000_000, 1_000_000_000, 10), load);
    assert_eq!(
        message,
        "a.exr: the G-buffer has 1000000000x1000000000 pixels; at most 16384 on each side are supported"
    );
    for (side, channels) in [(16_384, 10), (1024, 3000)] {
        let message = refused(&exr(side, side, channels), load);
        assert!(message.contains("too many for a file of"), "{message}");
    }
}

/// A TOML text nested 100 000 deep is refused with a short message, where a recursive parser would overflow its stack.
/// An OBJ face is refused whose indices exceed what the loader counts in.
#[test]
fn deep_nesting_and_huge_indices_are_refused() {
    if !is_alone() {
        return;
    }
    let nested = |open: &str, close: &str| format!("name = {}{}\n", open.repeat(100_000), close.repeat(100_000));
    for text in [nested("[", "]"), nested("{a=", "}"), format!("{}\n", "a.".repeat(100_000) + "b = 1")] {
        let load = |bytes: &[u8]| {
            let text = std::str::from_utf8(bytes).unwrap();
            path::parse(text, Path::new("a.toml")).err().map(|e| e.to_string())
        };
        let message = refused(text.as_bytes(), load);
        assert!(message.starts_with("a.toml") && message.len() < 500, "{message}");
    }
    for index in ["4294967296", "9223372036854775807", "-9223372036854775808"] {
        assert!(!bounded(entry::obj, format!("v 0 0 0\nf 1 1 {index}\n").as_bytes()));
    }
}
