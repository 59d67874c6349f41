//! The list of figures, with one file of entries per document.

mod schmidt;
mod thesis;

use super::plate::Plate;

/// Every figure, in the order of the documents.
pub fn plates() -> impl Iterator<Item = &'static Plate> {
    [thesis::PLATES, thesis::POSTER, schmidt::PLATES].into_iter().flatten()
}
