//! The methods, one file each, and the table of all of them. A method chooses passes and wires
//! their outputs to their inputs; its `record` reads like the data flow.

pub mod hzct;
pub mod ssct;
pub mod thesis;
pub mod unified;

use crate::error::{Error, Result};
use crate::gpu::{Frame, Gpu, Image};
use crate::passes::color_chain::ChainFilter;
use crate::passes::{ColorChain, GBuffer, HiZ, Hits, Reflection, Visibility};
use crate::scene::Camera;
pub use thesis::{Preset, Tuning};

/// What a method is made for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    /// Width and height in pixels.
    pub extent: [u32; 2],
    /// Whose constants a published method uses.
    pub preset: Preset,
    /// Numbers that replace the preset's.
    pub tuning: Tuning,
    /// Ray trace and cone trace as two passes, which also gives the hits.
    pub split: bool,
    /// How the colour chain is filtered.
    pub chain_filter: ChainFilter,
    /// Whether reflections fade at the screen's border.
    pub fade: bool,
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
            fade: true,
        }
    }
}

/// What a method made in a frame; intermediates that it does not have are `None`.
#[derive(Clone, Copy)]
pub struct Output<'a> {
    /// Reflection colour and fade; `None` where nothing reflects.
    pub reflection: Option<Reflection<'a>>,
    /// The finished image, linear.
    pub composite: &'a Image,
    /// Where each ray ended.
    pub hits: Option<Hits<'a>>,
    /// Depth chain.
    pub hi_z: Option<HiZ<'a>>,
    /// Visibility chain.
    pub visibility: Option<Visibility<'a>>,
    /// Colour chain.
    pub color: Option<ColorChain<'a>>,
}

/// A method of one size on one device.
pub trait Method {
    /// Records every pass from the G-buffer to the composite.
    fn record<'a>(&'a self, frame: &mut Frame, gbuffer: &GBuffer<'a>, camera: &Camera) -> Result<Output<'a>>;
}

/// A row of the table.
pub struct MethodInfo {
    /// Name on the command line and in records.
    pub name: &'static str,
    /// One line on what it does.
    pub summary: &'static str,
    /// Where it is published.
    pub source: &'static str,
    /// Makes it.
    pub create: fn(&Gpu, &Setup) -> Result<Box<dyn Method>>,
}

/// Every method.
pub const METHODS: &[MethodInfo] = &[ssct::INFO, hzct::INFO, unified::INFO];

/// The method of a name, or an error that lists the names there are.
pub fn find(name: &str) -> Result<&'static MethodInfo> {
    METHODS.iter().find(|m| m.name == name).ok_or_else(|| {
        let names: Vec<_> = METHODS.iter().map(|m| m.name).collect();
        Error::Usage(format!("no method {name:?}; there is: {}", names.join(", ")))
    })
}
