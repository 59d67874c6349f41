//! An entry in the list of figures: what the printed figure shows, what differs here, which renders the figure is
//! made of, and how they are composed.

use super::renderer::FigureRenderer;
use crate::app::printed::quote_word;
use crate::report::images::Rgb;
use ssct_scenes::Scene;

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
    /// The word with which the names of the files of the document's figures begin.
    pub fn stem(self) -> &'static str {
        match self {
            Self::Thesis => "thesis",
            Self::Poster => "poster",
            Self::Schmidt => "schmidt",
        }
    }
}

/// A scene that the documents print and this project does not have; a user who has its file can draw the printed picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PrintedScene {
    /// The two rooms of the thesis's author.
    Rooms,
    /// The Sponza atrium.
    Sponza,
}

impl PrintedScene {
    /// The built-in scene that takes the place of the printed scene.
    pub fn stand_in(self) -> &'static str {
        match self {
            Self::Rooms => "rooms",
            Self::Sponza => "atrium",
        }
    }

    /// The names of views by which a file is recognized as this scene; the stand-in has views of the same names.
    pub fn views(self) -> &'static [&'static str] {
        match self {
            Self::Rooms => &["window-floor", "corridor", "two-cylinders", "window"],
            Self::Sponza => &["atrium", "lion", "hall"],
        }
    }

    /// The printed scene whose views a scene from a file has; `None` if the scene lacks views of both printed scenes.
    pub fn from_scene(scene: &Scene) -> Option<Self> {
        let has = |name: &&str| scene.views.iter().any(|v| v.name == *name);
        [Self::Rooms, Self::Sponza].into_iter().find(|printed| printed.views().iter().all(&has))
    }
}

/// The size of a figure's renders in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// The printed size, which the option `--size` replaces.
    Print([u32; 2]),
    /// A size that the figure's subject determines, so that `--size` does not change it.
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
pub type MakeFigure = fn(&mut FigureRenderer, &[String]) -> anyhow::Result<FinishedFigure>;

/// An entry in the list of figures.
pub struct Plate {
    /// The document.
    pub source: Document,
    /// The number in print.
    pub number: &'static str,
    /// The subject.
    pub title: &'static str,
    /// What the printed figure shows.
    pub print: &'static str,
    /// The differences between the figure made here and the printed one.
    pub differs: &'static str,
    /// The printed scene, if a user can bring it as a file, and the differences that then remain.
    pub prints: Option<(PrintedScene, &'static str)>,
    /// The size of the figure's renders.
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
    /// The name of the figure's file without its extension, such as `thesis-4.5`.
    pub fn stem(&self) -> String {
        format!("{}-{}", self.source.stem(), self.number)
    }

    /// Returns the arguments of `ssct render` for each of the figure's renders. Their size is `wanted`, if it is given
    /// and the figure's size is not fixed, or else the figure's own. If a file is given and the figure prints a scene
    /// that a file can hold, the arguments name the file in place of the built-in scene.
    pub fn arguments(&self, wanted: Option<[u32; 2]>, file: Option<&str>) -> Vec<String> {
        let [width, height] = match self.size {
            Size::Print(printed) => wanted.unwrap_or(printed),
            Size::Fixed(fixed) => fixed,
        };
        let with_file = |arguments: &str| match (self.prints, file) {
            (Some((printed, _)), Some(file)) => {
                arguments.replace(&format!("--scene {}", printed.stand_in()), &format!("--scene {}", quote_word(file)))
            }
            _ => arguments.to_owned(),
        };
        self.panels.iter().map(|(_, arguments)| format!("{} --size {width}x{height}", with_file(arguments))).collect()
    }

    /// The differences from print: those of the built-in scene or, if `in_file`, those of a file of the printed scene.
    pub fn differs(&self, in_file: bool) -> &'static str {
        match self.prints {
            Some((_, differs_in_file)) if in_file => differs_in_file,
            _ => self.differs,
        }
    }
}
