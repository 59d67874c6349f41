//! The rates of the passes that make a pyramid of depth: the bytes that a pass must at least read and write, divided by its
//! time. Beside these rates stands the rate of a plain copy of an image.

use super::columns::{columns, figure, time};
use super::exhibit::Table;
use super::record::{Provenance, Stats, TimeRecord};
use crate::error::Result;
use ash::vk;
use ssct::gpu::frame::Mode;
use ssct::gpu::{FrameContext, Gpu, Image, ImageDesc, image};
use ssct::passes::pyramid;

/// The pass of `unified` that builds its pyramid.
const PYRAMID: &str = "pyramid";
/// The beginning of the labels of the passes of the thesis's Hi-Z chain; the number of the level follows.
const HI_Z: &str = "hi-z/";

/// Bytes of a texel in R32F, the format of the copied image, of depth, and of a Hi-Z chain without maxima.
const R32F_BYTES: u64 = 4;
/// Bytes of a cell of the pyramid: front and back (RG32F).
const RG32F_BYTES: u64 = 8;

columns! {
    /// The rate of a pass, or of the copy.
    pub struct BandwidthRecord {
        /// Kind of the record, which is always `bandwidth`.
        pub kind: String,
        /// Definitions, version, commit and device.
        #[serde(flatten)]
        pub program: Provenance,
        /// The pass: `copy`, `pyramid`, or `hi-z`, which stands for the passes of all levels of the Hi-Z chain
        /// together.
        pub pass: String = figure("pass"),
        /// Method that the pass belongs to; null for the copy.
        pub method: Option<String> = figure("method"),
        /// Scene and view that the pass was timed on; null for the copy.
        pub view: Option<String> = figure("view"),
        /// Width of the image in pixels.
        pub width: u32 = figure("width"),
        /// Height of the image in pixels.
        pub height: u32 = figure("height"),
        /// Bytes that the pass must at least read and write, each texel once.
        pub bytes: u64 = figure("bytes"),
        /// Median time of the pass in milliseconds.
        pub median_ms: f64 = time("median ms").digits(4),
        /// Bytes divided by the median time, in 10⁹ bytes a second.
        pub gb_per_s: f64 = time("GB/s").digits(2),
        /// Rate of the pass divided by the rate of the copy.
        pub of_copy: f64 = time("of a copy").digits(2),
    }
}

const ABOUT: &str = "For the passes that make a pyramid of depth: the bytes that a pass reads and writes at least, divided by its \
    time; first the same for a plain copy of an image. Each level of the Hi-Z buffer is a pass; the small ones take their time \
    for other things than bytes.";

impl BandwidthRecord {
    /// Makes the table of the rates.
    pub fn table(rows: &[Self]) -> Table {
        Table { title: "Rates".to_owned(), about: ABOUT.to_owned(), ..Table::of_rows("rates", rows) }
    }

    /// Makes the record of a pass that reads and writes `bytes` bytes in `median_ms` milliseconds. `copy_gb_per_s` is
    /// the rate of the copy in 10⁹ bytes a second; 0 makes the record of the copy itself. The record has no method and
    /// no view; [`pass_rates`] sets those of a pass.
    fn new(
        program: Provenance,
        pass: &str,
        [width, height]: [u32; 2],
        bytes: u64,
        median_ms: f64,
        copy_gb_per_s: f64,
    ) -> Self {
        let gb_per_s = if median_ms > 0.0 { bytes as f64 / (median_ms * 1e6) } else { 0.0 };
        let of_copy = if copy_gb_per_s > 0.0 { gb_per_s / copy_gb_per_s } else { 1.0 };
        Self {
            kind: "bandwidth".into(),
            program,
            pass: pass.into(),
            method: None,
            view: None,
            width,
            height,
            bytes,
            median_ms,
            gb_per_s,
            of_copy,
        }
    }
}

/// Times `samples` copies of an image of R32F texels, `side` on each side, into another, and makes the record of the
/// copy.
///
/// # Errors
/// Errors of the device.
pub fn time_copy(gpu: &Gpu, side: u32, samples: usize) -> Result<BandwidthRecord> {
    use vk::ImageUsageFlags as U;
    let (extent, usage) = ([side; 2], U::TRANSFER_SRC | U::TRANSFER_DST);
    let desc = |name| ImageDesc { name, format: vk::Format::R32_SFLOAT, extent, levels: 1, layers: 1, usage };
    let [source, target] = [Image::new(gpu, &desc("copied"))?, Image::new(gpu, &desc("copy"))?];
    let mut context = FrameContext::new(gpu)?;
    context.once(|frame| frame.clear("copied", source.all(), [0.5; 4]))?;
    let mut times = Vec::new();
    // The first copy, numbered 0, warms up and is not counted.
    for sample in 0..=samples {
        let mut frame = context.begin(Mode::Timed)?;
        frame.copy("copy", source.all(), target.all())?;
        let report = frame.finish()?;
        times.extend(report.passes.iter().filter(|_| sample > 0).map(|p| p.ms));
    }
    // Each texel is read once and written once.
    let bytes = 2 * R32F_BYTES * u64::from(side) * u64::from(side);
    Ok(BandwidthRecord::new(Provenance::on(gpu), "copy", extent, bytes, Stats::from_samples(&times).median_ms, 0.0))
}

/// Returns the rates of those passes of a time record that build a pyramid of depth: the pyramid of `unified`, and the
/// Hi-Z chain as a whole. `copy` is the rate that they are compared with, and is not among the result.
pub fn pass_rates(record: &TimeRecord, copy: &BandwidthRecord) -> Vec<BandwidthRecord> {
    let extent = [record.head.width, record.head.height];
    let pass_rate = |pass: &str, bytes: u64, median_ms: f64| BandwidthRecord {
        method: Some(record.head.variant()),
        view: Some(format!("{} {}", record.head.scene, record.head.view)),
        ..BandwidthRecord::new(record.head.program.clone(), pass, extent, bytes, median_ms, copy.gb_per_s)
    };
    let pyramid_pass = record.passes.iter().find(|p| p.name == PYRAMID);
    let pyramid = pyramid_pass.map(|p| pass_rate(PYRAMID, pyramid_bytes(extent), p.stats.median_ms));
    let hi_z_levels = record.passes.iter().filter(|p| p.name.starts_with(HI_Z));
    let hi_z_ms: f64 = hi_z_levels.map(|p| p.stats.median_ms).sum();
    let hi_z = (hi_z_ms > 0.0).then(|| pass_rate("hi-z", hi_z_bytes(extent), hi_z_ms));
    pyramid.into_iter().chain(hi_z).collect()
}

/// Counts the bytes that the pass of a pyramid reads and writes for an image of a width and height in pixels. Each
/// depth is read once, and each cell of every level is written once.
fn pyramid_bytes(extent: [u32; 2]) -> u64 {
    let area = |[w, h]: [u32; 2]| u64::from(w) * u64::from(h);
    let padded = pyramid::padded(extent);
    let cells: u64 = (0..=pyramid::top_level(extent)).map(|level| area(padded.map(|side| side >> level))).sum();
    R32F_BYTES * area(extent) + RG32F_BYTES * cells
}

/// Counts the bytes that the passes of a Hi-Z chain read and write for an image of a width and height in pixels. For
/// each level above 0, all texels of the finer level are read once, and all texels of the level are written once.
fn hi_z_bytes(extent: [u32; 2]) -> u64 {
    let area = |level: u32| extent.map(|side| u64::from((side >> level).max(1))).iter().product::<u64>();
    (1..image::full_chain(extent)).map(|level| R32F_BYTES * (area(level - 1) + area(level))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_those_of_a_count_by_hand() {
        // 4 x 2, 2 x 1, 1 x 1: reads 8 + 2 texels, writes 2 + 1.
        assert_eq!(hi_z_bytes([4, 2]), 4 * 13);
        // 3 x 5 is padded to 8 x 8: 64 + 16 + 4 + 1 cells.
        assert_eq!(pyramid_bytes([3, 5]), 4 * 15 + 8 * 85);
    }
}
