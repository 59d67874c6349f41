//! The methods, one file each, and the table of all of them. A method chooses passes and wires
//! their outputs to their inputs; its `record` reads like the data flow. What all of them have around
//! them, down to the composite, is [`effect`].

pub mod area_light;
pub mod billboard;
pub mod capture;
pub mod effect;
pub mod environment;
pub mod hzct;
pub mod linear;
pub mod pccm;
pub mod planar;
pub mod poster;
pub mod ssct;
pub mod sslr;
pub mod ssr;
pub mod ssr_fast;
pub mod thesis;
pub mod unified;

use crate::error::{Error, Result};
use crate::gpu::{Frame, FrameContext, Gpu, Image};
use crate::math::OracleVersion;
use crate::passes::billboard::Billboards;
use crate::passes::color_chain::ChainFilter;
use crate::passes::linear_trace::March;
use crate::passes::planar::Mirrors;
use crate::passes::scene_data::SceneData;
use crate::passes::{Content, GBuffer, Hits, PosterFilter, Reflection};
use crate::scene::{Camera, Material};
pub use effect::{Effect, Output};
pub use thesis::{Preset, Tuning};

/// What a method is made for.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Setup {
    /// Width and height in pixels.
    pub extent: [u32; 2],
    /// Whose constants a published method uses.
    pub preset: Preset,
    /// Numbers that replace the preset's.
    pub tuning: Tuning,
    /// Ray trace and cone trace as two passes where a method has both; where it has hits, it gives them.
    pub split: bool,
    /// How the colour chain is filtered.
    pub chain_filter: ChainFilter,
    /// Which listing `linear` marches by.
    pub march: March,
    /// How `poster` pre-filters the G-buffer.
    pub poster_filter: PosterFilter,
    /// How `billboard` traces its quads.
    pub billboards: Billboards,
    /// Which planes `planar` mirrors, and how.
    pub mirrors: Mirrors,
    /// Whether reflections fade at the screen's border.
    pub fade: bool,
    /// Full pixels a side of a pixel that is traced: 1, or 2 for half resolution (thesis §4.4).
    /// [`Effect`] divides the size; a method knows only the size that it is made for.
    pub divisor: u32,
    /// Whether a method may make the composite along the way; [`Effect`] decides.
    pub composite: bool,
    /// Whether the reflection is wanted as an image of its own. A method that composites along the way
    /// leaves it out otherwise; [`Effect`] keeps what it needs itself.
    pub reflection: bool,
    /// What is seen behind a screen-space method's reflection where that fades out.
    pub fallback: Fallback,
    /// What `unified` hits, and the oracle that every method is held against.
    pub oracle: OracleVersion,
}

/// What is behind a screen-space method (thesis §4.2.11; Schmidt 2013, section 5.4.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fallback {
    /// Nothing: black.
    #[default]
    None,
    /// The method `environment`.
    Environment,
    /// The method `pccm`.
    Pccm,
}

impl Fallback {
    /// The method that is behind.
    pub fn method(self) -> Option<&'static MethodInfo> {
        match self {
            Self::None => None,
            Self::Environment => Some(&environment::INFO),
            Self::Pccm => Some(&pccm::INFO),
        }
    }

    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        *self == Self::None
    }
}

impl Setup {
    /// The defaults at a size.
    pub fn new(extent: [u32; 2]) -> Self {
        Self {
            extent,
            preset: Preset::default(),
            tuning: Tuning::default(),
            split: false,
            chain_filter: ChainFilter::default(),
            march: March::default(),
            poster_filter: PosterFilter::default(),
            billboards: Billboards::default(),
            mirrors: Mirrors::default(),
            fade: true,
            divisor: 1,
            composite: true,
            reflection: true,
            fallback: Fallback::None,
            oracle: OracleVersion::default(),
        }
    }

    /// Traced pixels a side over full pixels: 1, ½ or ¼.
    pub fn resolution_scale(&self) -> f32 {
        1.0 / self.divisor as f32
    }
}

/// What a method reads in a frame. What it makes may borrow the G-buffer (`'a`), not the scene (`'s`).
#[derive(Clone, Copy)]
pub struct Input<'a, 's> {
    /// What the scene passes left.
    pub gbuffer: GBuffer<'a>,
    /// Where it was seen from.
    pub camera: &'s Camera,
    /// The scene itself; `None` where only a G-buffer is known.
    pub scene: Option<SceneInput<'s>>,
}

impl<'s> Input<'_, 's> {
    /// The scene, for a method that can't do without.
    ///
    /// # Errors
    /// [`Error::Usage`] if there is none.
    pub fn scene(&self) -> Result<SceneInput<'s>> {
        self.scene.ok_or_else(|| Error::Usage("the method needs the scene; a G-buffer alone does not show it".into()))
    }
}

/// The scene on the device, for methods that draw it again or need more of it than the screen shows.
#[derive(Clone, Copy)]
pub struct SceneInput<'a> {
    /// Meshes, textures, lights.
    pub data: &'a SceneData,
    /// The materials of the view with the global factors.
    pub materials: &'a [Material],
}

/// An image that a method made along the way, for whoever looks inside.
#[derive(Clone, Copy)]
pub struct Intermediate<'a> {
    /// File stem; the number of a level, or of a volume's slice, follows it where there is more than one.
    pub name: &'static str,
    /// What its numbers are.
    pub content: Content,
    /// The image.
    pub image: &'a Image,
}

/// What a method made in a frame.
#[derive(Clone)]
pub struct Traced<'a> {
    /// Reflection colour and fade; `None` where nothing reflects, or where it is not wanted.
    pub reflection: Option<Reflection<'a>>,
    /// The finished image, linear, in level 0, if the method made it along the way.
    pub composite: Option<&'a Image>,
    /// Where each ray ended.
    pub hits: Option<Hits<'a>>,
    /// What else there is to see.
    pub intermediates: Vec<Intermediate<'a>>,
}

impl<'a> Traced<'a> {
    /// A reflection without intermediates.
    pub fn new(reflection: Reflection<'a>) -> Self {
        Self { reflection: Some(reflection), composite: None, hits: None, intermediates: Vec::new() }
    }

    /// No reflection: the image is the lit colour.
    pub fn nothing(gbuffer: &GBuffer<'a>) -> Self {
        Self { reflection: None, composite: Some(gbuffer.color), hits: None, intermediates: Vec::new() }
    }
}

/// A method of one size on one device.
pub trait Method {
    /// Makes what outlives frames (captured maps) from the scene. Called before the first frame and
    /// again when materials change; not part of any frame's time.
    fn prepare(&mut self, _context: &mut FrameContext, _scene: &SceneInput) -> Result<()> {
        Ok(())
    }

    /// Records every pass from the G-buffer to the reflection.
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<Traced<'a>>;
}

/// What a method needs to see.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sees {
    /// The G-buffer alone: a screen-space method.
    Screen,
    /// The scene too.
    Scene,
}

/// A row of the table.
pub struct MethodInfo {
    /// Name on the command line and in records.
    pub name: &'static str,
    /// One line on what it does.
    pub summary: &'static str,
    /// Where it is published.
    pub source: &'static str,
    /// What it needs to see.
    pub sees: Sees,
    /// The settings that the study of run time against error runs, around a base.
    pub settings: fn(Setup) -> Vec<Setup>,
    /// Makes it.
    pub create: fn(&Gpu, &Setup) -> Result<Box<dyn Method>>,
}

impl MethodInfo {
    /// Whether the method works on a G-buffer of any origin.
    pub fn is_screen_space(&self) -> bool {
        self.sees == Sees::Screen
    }
}

/// Settings for the study of run time against error of a method without parameters of its own: as
/// published, and at half resolution.
pub fn full_and_half(base: Setup) -> Vec<Setup> {
    let published = Setup { preset: Preset::Published, ..base };
    vec![published, Setup { divisor: 2, ..published }]
}

/// Every method.
pub const METHODS: &[MethodInfo] = &[
    ssct::INFO,
    hzct::INFO,
    sslr::INFO,
    linear::INFO,
    poster::INFO,
    ssr::INFO,
    ssr_fast::INFO,
    pccm::INFO,
    billboard::INFO,
    planar::INFO,
    area_light::INFO,
    environment::INFO,
    unified::INFO,
];

/// The methods of some names; without names, every method that can be set up so.
pub fn choose(names: &[String], setup: &Setup) -> Result<Vec<&'static MethodInfo>> {
    if names.is_empty() {
        return Ok(METHODS
            .iter()
            .filter(|m| (setup.fallback.is_none() && setup.divisor == 1) || m.is_screen_space())
            .collect());
    }
    names.iter().map(|name| find(name)).collect()
}

/// The method of a name, or an error that lists the names there are.
pub fn find(name: &str) -> Result<&'static MethodInfo> {
    METHODS.iter().find(|m| m.name == name).ok_or_else(|| {
        let names: Vec<_> = METHODS.iter().map(|m| m.name).collect();
        Error::Usage(format!("no method {name:?}; there is: {}", names.join(", ")))
    })
}
