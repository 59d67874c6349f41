//! An entry in the list of figures: what the printed figure shows, what differs here, which renders the figure is
//! made of, and how they are composed.

use super::workshop::Workshop;
use crate::report::images::Rgb;

/// The document of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Document {
    /// Hermanns 2015.
    Thesis,
    /// Hermanns and Franke 2014.
    Poster,
    /// Schmidt 2013.
    Schmidt,
}

impl Document {
    /// The beginning of file names.
    pub fn stem(self) -> &'static str {
        match self {
            Self::Thesis => "thesis",
            Self::Poster => "poster",
            Self::Schmidt => "schmidt",
        }
    }
}

/// The size of a figure's renders in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// The printed size, which the option `--size` replaces.
    Print([u32; 2]),
    /// Determined by the figure's subject, so it cannot be changed.
    Fixed([u32; 2]),
}

/// A finished figure.
pub enum FinishedFigure {
    /// A picture, written as PNG.
    Picture(Rgb),
    /// A drawing, as SVG.
    Drawing(String),
}

/// A function that makes a figure from the arguments of its renders, including the size.
pub type MakeFigure = fn(&mut Workshop, &[String]) -> anyhow::Result<FinishedFigure>;

/// A figure.
pub struct Plate {
    /// The document.
    pub source: Document,
    /// The number in print.
    pub number: &'static str,
    /// The subject.
    pub title: &'static str,
    /// What the printed figure shows.
    pub print: &'static str,
    /// What differs here.
    pub differs: &'static str,
    /// The size of its renders.
    pub size: Size,
    /// For each render: what it shows, and the arguments of `ssct render` without size and file.
    pub panels: &'static [(&'static str, &'static str)],
    /// The function that composes the figure.
    pub make: MakeFigure,
}

/// 1920 × 1080 pixels, if the size is not overridden.
pub const HD: Size = Size::Print([1920, 1080]);
/// 960 × 540 pixels, if the size is not overridden.
pub const QHD: Size = Size::Print([960, 540]);

impl Plate {
    /// The file name without its extension.
    pub fn stem(&self) -> String {
        format!("{}-{}", self.source.stem(), self.number)
    }

    /// The arguments of its renders at its own size, or at the requested size if the figure allows that.
    pub fn arguments(&self, wanted: Option<[u32; 2]>) -> Vec<String> {
        let [width, height] = match self.size {
            Size::Print(own) => wanted.unwrap_or(own),
            Size::Fixed(own) => own,
        };
        self.panels.iter().map(|(_, arguments)| format!("{arguments} --size {width}x{height}")).collect()
    }
}
