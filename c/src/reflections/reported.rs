//! Keeps the texts and arrays to which structs in the caller's memory point.

use super::{SsctOutputImage, SsctPassTime, SsctRecorded, SsctSkipped};
use crate::border::to_c_text;
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
    pub(super) fn new(frame: &Recorded) -> Self {
        let skipped = frame.skipped.iter().flat_map(|skip| [&skip.pass, &skip.why]);
        let texts: Vec<_> = frame.passes.iter().chain(skipped).map(|words| to_c_text(words)).collect();
        let (passes, skipped) = texts.split_at(frame.passes.len());
        let passes = passes.iter().map(|pass| pass.as_ptr()).collect();
        let to_row = |[pass, why]: &[CString; 2]| SsctSkipped { pass: pass.as_ptr(), why: why.as_ptr() };
        let skipped = skipped.as_chunks::<2>().0.iter().map(to_row).collect();
        Self { _texts: texts, passes, skipped }
    }

    /// Returns the struct for the caller, whose pointers lead into this report.
    pub(super) fn to_c_struct(&self, frame: &Recorded, struct_size: usize) -> SsctRecorded {
        SsctRecorded {
            struct_size,
            composite: to_c_image(frame.composite),
            reflection: to_c_image(frame.reflection),
            hits: to_c_image(frame.hits),
            passes: self.passes.as_ptr(),
            pass_count: self.passes.len() as u32,
            skipped_count: self.skipped.len() as u32,
            skipped: self.skipped.as_ptr(),
        }
    }
}

/// Converts an output to the header's type; null handles for `None`.
fn to_c_image(output: Option<OutputImage>) -> SsctOutputImage {
    let no_image =
        OutputImage { image: VkImage::null(), view: VkImageView::null(), format: VkFormat::UNDEFINED, extent: [0, 0] };
    let OutputImage { image, view, format, extent: [width, height] } = output.unwrap_or(no_image);
    SsctOutputImage { image, view, format, extent: VkExtent2D { width, height } }
}

/// The array of times that `ssct_reflections_times` returns, with the texts to which its rows point.
#[derive(Default)]
pub(super) struct Times {
    pub(super) _names: Vec<CString>,
    pub(super) rows: Vec<SsctPassTime>,
}
