//! The figures, one entry each: what it shows in print, what it shows here, the renders it is made of,
//! and how they are put together. The entries lie in a file a document.

mod schmidt;
mod thesis;

use super::workshop::Workshop;
use crate::report::images::Rgb;

/// The document that a figure is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Hermanns 2015.
    Thesis,
    /// Hermanns and Franke 2014.
    Poster,
    /// Schmidt 2013.
    Schmidt,
}

impl Source {
    /// What file names begin with.
    pub fn stem(self) -> &'static str {
        match self {
            Self::Thesis => "thesis",
            Self::Poster => "poster",
            Self::Schmidt => "schmidt",
        }
    }
}

/// Pixels of a figure's renders.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// As printed; `--size` replaces it.
    Print([u32; 2]),
    /// The figure is about this size.
    Fixed([u32; 2]),
}

/// A finished figure.
pub enum Made {
    /// To be written as PNG.
    Picture(Rgb),
    /// SVG.
    Drawing(String),
}

/// How a figure is made of the arguments of its renders, size included.
pub type Make = fn(&mut Workshop, &[String]) -> anyhow::Result<Made>;

/// A figure.
pub struct Plate {
    /// Document.
    pub source: Source,
    /// Number in print.
    pub number: &'static str,
    /// Subject.
    pub title: &'static str,
    /// What the print shows.
    pub print: &'static str,
    /// What differs here.
    pub differs: &'static str,
    /// Pixels.
    pub size: Size,
    /// Its renders: what each shows, and the arguments of `ssct render` without size and file.
    pub panels: &'static [(&'static str, &'static str)],
    /// How it is put together.
    pub make: Make,
}

const HD: Size = Size::Print([1920, 1080]);
const QHD: Size = Size::Print([960, 540]);

/// Every figure, in the order of the documents.
pub fn plates() -> impl Iterator<Item = &'static Plate> {
    [thesis::PLATES, thesis::POSTER, schmidt::PLATES].into_iter().flatten()
}

impl Plate {
    /// File name without its extension.
    pub fn stem(&self) -> String {
        format!("{}-{}", self.source.stem(), self.number)
    }

    /// The arguments of its renders at its own size, or at the one asked for where that may be.
    pub fn arguments(&self, wanted: Option<[u32; 2]>) -> Vec<String> {
        let [width, height] = match self.size {
            Size::Print(own) => wanted.unwrap_or(own),
            Size::Fixed(own) => own,
        };
        self.panels.iter().map(|(_, arguments)| format!("{arguments} --size {width}x{height}")).collect()
    }
}
