//! Keeps the texts and arrays to which structs in the caller's memory point.

use super::{SsctOutputImage, SsctPassTime, SsctRecorded, SsctSkipped};
use crate::border::text;
use crate::vulkan::{VkExtent2D, VkFormat, VkImage, VkImageView};
use ssct::{OutputImage, Recorded};
use std::ffi::{CString, c_char};

/// The arrays to which `SsctRecorded` points, with the texts to which the arrays point.
#[derive(Default)]
pub(super) struct Report {
    /// The texts, which nothing reads here: they only have to live.
    _texts: Vec<CString>,
    passes: Vec<*const c_char>,
    skipped: Vec<SsctSkipped>,
}

impl Report {
    /// Copies the names of a recorded frame's passes, and of the passes that it leaves out with the reasons.
    pub(super) fn new(made: &Recorded) -> Self {
        let skipped = made.skipped.iter().flat_map(|s| [&s.pass, &s.why]);
        let texts: Vec<_> = made.passes.iter().chain(skipped).map(|words| text(words)).collect();
        let (passes, skipped) = texts.split_at(made.passes.len());
        let passes = passes.iter().map(|pass| pass.as_ptr()).collect();
        let row = |[pass, why]: &[CString; 2]| SsctSkipped { pass: pass.as_ptr(), why: why.as_ptr() };
        let skipped = skipped.as_chunks::<2>().0.iter().map(row).collect();
        Self { _texts: texts, passes, skipped }
    }

    /// Returns the struct for the caller, whose pointers lead into this report.
    pub(super) fn shown(&self, made: &Recorded, struct_size: usize) -> SsctRecorded {
        SsctRecorded {
            struct_size,
            composite: output(made.composite),
            reflection: output(made.reflection),
            hits: output(made.hits),
            passes: self.passes.as_ptr(),
            pass_count: self.passes.len() as u32,
            skipped_count: self.skipped.len() as u32,
            skipped: self.skipped.as_ptr(),
        }
    }
}

/// Converts an output to the header's type; null handles for `None`.
fn output(made: Option<OutputImage>) -> SsctOutputImage {
    let none =
        OutputImage { image: VkImage::null(), view: VkImageView::null(), format: VkFormat::UNDEFINED, extent: [0, 0] };
    let OutputImage { image, view, format, extent: [width, height] } = made.unwrap_or(none);
    SsctOutputImage { image, view, format, extent: VkExtent2D { width, height } }
}

/// The array of times that `ssct_reflections_times` returns, with the texts to which its rows point.
#[derive(Default)]
pub(super) struct Times {
    pub(super) _names: Vec<CString>,
    pub(super) rows: Vec<SsctPassTime>,
}
