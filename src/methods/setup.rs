//! The setup of methods: the size of images, and the values of parameters. Every record contains the whole setup.

use super::MethodInfo;
use crate::gpu::{Gpu, ShaderStage};
use crate::passes::trace_normals::TraceNormals;
use ssct_ground::math::OracleVersion;
use ssct_ground::parameter::{
    Choice, Choices, Domain, Field, Parameter, Parameters, Preset, Value, Values, choices, parameters,
};
use ssct_ground::scene::ProjectionKind;
use ssct_ground::scene::capture::{MAX_CAPTURES, WantedCaptures};
use std::collections::BTreeMap;

choices! {
    /// What is behind a screen-space method (thesis §4.2.11; Schmidt 2013, section 5.4.2).
    pub enum Fallback {
        /// Nothing: black.
        None = "none",
        /// The method `environment`.
        Environment = "environment",
        /// The method `pccm`.
        Pccm = "pccm",
        /// The method `captures`: exact rays through captures of the scene.
        Captures = "captures",
        /// The method `planar` with one plane: a mirror where the plane that covers most of the screen reflects (thesis §3.2).
        Planar = "planar",
    }
}

choices! {
    /// Whether reflections are averaged over frames.
    pub enum HistoryUse {
        /// Each frame by itself.
        Off = "off",
        /// With those before it.
        On = "on",
    }
}

choices! {
    /// The shaders in which passes run that exist for two stages: those of `unified`, and the history.
    pub enum StageChoice {
        /// Fragment shaders on a device that is a CPU, compute shaders on any other.
        Auto = "auto",
        /// Fragment shaders, drawn over tiles as points or over the whole image.
        Fragment = "fragment",
        /// Compute shaders, in workgroups over tiles or over the whole image.
        Compute = "compute",
    }
}

impl StageChoice {
    /// Returns the stage in which passes run on a device. `all` is the stage that the user chose for all passes.
    pub(super) fn on(self, gpu: &Gpu, all: Stage) -> ShaderStage {
        match (self, all) {
            (Self::Fragment, _) | (Self::Auto, Stage::Fragment) => ShaderStage::Fragment,
            (Self::Compute, _) | (Self::Auto, Stage::Compute) => ShaderStage::Compute,
            (Self::Auto, Stage::Published) if gpu.info().is_cpu() => ShaderStage::Fragment,
            (Self::Auto, Stage::Published) => ShaderStage::Compute,
        }
    }
}

choices! {
    /// The shaders in which the passes over the whole image run.
    pub enum Stage {
        /// Fragment shaders in published methods and around every method; the passes of `unified` and the history as their own
        /// parameters say.
        Published = "published",
        /// Fragment shaders.
        Fragment = "fragment",
        /// Compute shaders, a thread a pixel.
        Compute = "compute",
    }
}

impl Stage {
    /// Returns the stage of the passes that are published as fragment shaders.
    pub fn of_pixels(self) -> ShaderStage {
        match self {
            Self::Published | Self::Fragment => ShaderStage::Fragment,
            Self::Compute => ShaderStage::Compute,
        }
    }
}

choices! {
    /// Where rays go on that the screen loses.
    pub enum BeyondScreen {
        /// In captures where some are asked for; else nowhere with a fallback, which shows there, and with several bounces,
        /// which end on the screen; else among the triangles of the scene, where there is one.
        Auto = "auto",
        /// Nowhere: the screen is all there is.
        None = "none",
        /// Among the triangles of the scene.
        Triangles = "triangles",
        /// In captures of the scene.
        Captures = "captures",
    }
}

choices! {
    /// What finds the triangle that a ray meets.
    pub enum Tracer {
        /// The tree.
        Auto = "auto",
        /// A walk through a tree in compute shaders, on any device.
        Tree = "tree",
        /// Ray queries, on a device that has them.
        Query = "query",
    }
}

choices! {
    /// How many rays of its own a pixel gets whose neighbours' rays say little of its reflection.
    pub enum OwnRays {
        /// Among triangles 8 on a GPU and none on a CPU, where they take up to twice the time of all else; none on the screen alone.
        Auto = "auto",
        /// None.
        None = "none",
        /// 4.
        Four = "4",
        /// 8.
        Eight = "8",
        /// 16.
        Sixteen = "16",
    }
}

impl OwnRays {
    /// Returns the number of own rays of a pixel on a device, for rays among triangles or on the screen alone.
    pub fn on(self, gpu: &Gpu, among_triangles: bool) -> i32 {
        match self {
            Self::Auto if !among_triangles || gpu.info().is_cpu() => 0,
            Self::None => 0,
            Self::Four => 4,
            Self::Auto | Self::Eight => 8,
            Self::Sixteen => 16,
        }
    }
}

/// The number of captures in which lost rays go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CaptureCount {
    /// None: the screen is all there is.
    #[default]
    None,
    /// All captures of the scene file, or as many as the scene needs.
    Auto,
    /// A single capture at the camera, drawn anew in each frame.
    Camera,
    /// This number of captures, from 1 to [`MAX_CAPTURES`]; the scene file's come first.
    Number(u32),
}

choices! {
    /// Width and height of the faces of captures, in texels.
    pub enum CaptureSide {
        /// The side that the scene file says, else 512.
        Scene = "scene",
        /// 128.
        Side128 = "128",
        /// 256.
        Side256 = "256",
        /// 512.
        Side512 = "512",
        /// 1024.
        Side1024 = "1024",
    }
}

impl CaptureSide {
    /// Returns the side in texels; `None` if the scene decides.
    pub fn texels(self) -> Option<u32> {
        self.name().parse().ok()
    }
}

impl CaptureCount {
    const NAMED: &'static [Choice] = &[
        Choice { name: "none", help: "No captures: the screen is all there is." },
        Choice { name: "auto", help: "All captures of the scene file, or as many as the scene needs." },
        Choice { name: "camera", help: "A single capture at the camera, drawn anew in each frame." },
    ];

    /// Returns which captures are wanted at places of the scene; `None` if there are none, or only one at the camera.
    pub fn wanted(self) -> Option<WantedCaptures> {
        match self {
            Self::None | Self::Camera => None,
            Self::Auto => Some(WantedCaptures::Auto),
            Self::Number(count) => Some(WantedCaptures::Count(count as usize)),
        }
    }
}

impl Field for CaptureCount {
    fn domain() -> Domain {
        Domain::ChoicesOrCount(Self::NAMED, 1, MAX_CAPTURES as u32)
    }

    fn value(self) -> Value {
        match self {
            Self::None => Value::Choice("none"),
            Self::Auto => Value::Choice("auto"),
            Self::Camera => Value::Choice("camera"),
            Self::Number(count) => Value::Count(count),
        }
    }

    fn from_value(value: Value) -> Option<Self> {
        match value {
            Value::Choice("none") => Some(Self::None),
            Value::Choice("auto") => Some(Self::Auto),
            Value::Choice("camera") => Some(Self::Camera),
            Value::Count(count) => Some(Self::Number(count)),
            _ => None,
        }
    }
}

parameters! {
    /// Parameters of what surrounds every method.
    pub struct EffectParams {
        /// Reflections fade at the screen's border.
        fade: bool = Parameter::new(true).source("Hermanns 2015, Eq. 4.7"),
        /// Trace at a lower resolution and bring the reflection back to full size: traced pixels a side over pixels.
        resolution_scale: f32 =
            Parameter::new(1.0).one_of(&[1.0, 0.5, 0.25]).sweep(Preset::Published, &[0.5]).source("Hermanns 2015, §4.4"),
        /// The shaders in which all passes over the whole image run, of the method and around it. The image is the same, and a
        /// GPU runs the two at different speeds: methods are compared fairly in one stage. As published, all methods but unified,
        /// traced and captures run in fragment shaders. With a stage, the trace-stage, resolve-stage and history-stage that are auto
        /// are that stage. What draws triangles stays as it is (docs/devices.md).
        stage: Stage = Parameter::new(Stage::Published).source("as published: fragment shaders"),
        /// What rays of screen-space methods are reflected at: the normals of shading, those of the geometry, or the
        /// world's up.
        trace_normals: TraceNormals = Parameter::new(TraceNormals::Shading).source("Hermanns 2015, §4.4"),
        /// How far reflections are displaced after the tracing where the normals of shading deviate from those that rays
        /// were reflected at, for a deviation of 1. With 0 they are not.
        bump_after: f32 =
            Parameter::new(0.0).between(0.0, 4.0).unit("screen heights").source("Hermanns 2015, §4.4; no number there"),
        /// What shows where a screen-space reflection fades out.
        fallback: Fallback = Parameter::new(Fallback::None).source("Hermanns 2015, §4.2.11; Schmidt 2013, §5.4.2"),
        /// How often light is reflected in screen-space methods: with each bounce the reflections are made again, from the
        /// image with those of the bounce before in it (docs/definitions.md, "Bounces"). With 1, what is reflected does not
        /// reflect. The references follow rays over as many bounces.
        bounces: u32 = Parameter::new(1).within(1, 8).unit("bounces").source("Hermanns 2015, §4.2.11"),
        /// Reflections are averaged over frames. What a pixel reflects is looked for where the frame before showed it, taken
        /// over as far as it agrees, and clamped to what the pixels around show now (docs/definitions.md, "Histories"). Mirrors
        /// have no history. An image at rest is shown after `history_frames` frames.
        history: HistoryUse = Parameter::new(HistoryUse::Off).source("Hermanns 2015, §4.2.11; Salvi 2016"),
        /// Frames that the history averages at most while the camera moves, and that bring other rays once it rests.
        history_frames: u32 = Parameter::new(16).within(1, 256).unit("frames").source("tuned (docs/findings.md)"),
        /// How far from the mean of what the pixels around show the history may lie where what is reflected is not known: four times
        /// as far where it is known to agree, and eight times where nothing moves.
        history_deviations: f32 =
            Parameter::new(1.0).between(0.0, 100.0).unit("standard deviations").source("Salvi 2016"),
        /// The shaders of the history. The image is the same, and which is faster depends on the device.
        history_stage: StageChoice = Parameter::new(StageChoice::Auto).source("this project"),
        /// What unified hits on the screen alone, and the oracle that methods are held against: 1, any block that a ray meets; 2, only
        /// those that it can have come to from in front.
        oracle: OracleVersion = Parameter::new(OracleVersion::V1).source("this project"),
        /// Where unified follows the rays that the screen loses. Where they go on, it hits what version 2 of the oracle says,
        /// and its reflections do not fade at the screen's border.
        beyond: BeyondScreen = Parameter::new(BeyondScreen::Auto)
            .sweep(Preset::Published, &[BeyondScreen::None])
            .source("this project"),
        /// What finds the triangle that a ray meets, where rays go among the triangles of the scene. The rays end alike
        /// but where triangles are equally near within rounding.
        tracer: Tracer = Parameter::new(Tracer::Auto).source("this project (docs/unified.md)"),
        /// Rays of its own that a pixel with a lobe gets, among the triangles or on the screen alone, where the rays of its
        /// neighbours say little of its reflection: where they disagree, are of another surface, or where it stands close to
        /// what it shows.
        own_rays: OwnRays = Parameter::new(OwnRays::Auto).source("tuned (docs/unified.md)"),
        /// Captures of the scene for rays that the screen loses. The methods unified and captures follow these rays in
        /// them. With captures, unified hits what version 2 of the oracle says, and its reflections do not fade at the
        /// screen's border.
        captures: CaptureCount = Parameter::new(CaptureCount::None)
            .source("this project; camera: Hermanns and Franke 2014, Conclusion"),
        /// Width and height of the faces of captures.
        capture_side: CaptureSide = Parameter::new(CaptureSide::Scene).unit("texels").source("this project"),
        /// Faces of captures that each frame draws anew, in turn over all faces of all captures, so that what moves is
        /// seen in them: at most all of them. Passes of the frame, which count. With 0 captures stay as they are; the
        /// capture at the camera is always drawn anew, and takes no such number.
        captures_per_frame: u32 =
            Parameter::new(0).within(0, 6 * MAX_CAPTURES as u32).unit("faces").source("this project"),
    }
}

impl EffectParams {
    /// Returns where lost rays go on in a method that can follow them in captures and among triangles. `has_scene` says
    /// whether the scene is known.
    pub fn beyond(&self, has_scene: bool) -> BeyondScreen {
        match self.beyond {
            BeyondScreen::Auto if self.captures != CaptureCount::None => BeyondScreen::Captures,
            BeyondScreen::Auto if has_scene && self.fallback == Fallback::None && self.bounces == 1 => {
                BeyondScreen::Triangles
            }
            BeyondScreen::Auto => BeyondScreen::None,
            chosen => chosen,
        }
    }

    /// Whether a method traces rays among the scene's triangles: its lost rays, or all rays if it sees nothing else.
    pub fn is_among_triangles(&self, method: &MethodInfo, has_scene: bool) -> bool {
        let sees_only_triangles = !method.is_screen_space();
        method.takes_triangles && (sees_only_triangles || self.beyond(has_scene) == BeyondScreen::Triangles)
    }

    /// Returns the captures that are wanted: the value of the parameter `captures`, or as many as the scene needs if lost rays
    /// are to go on in captures and no value is given.
    pub fn captures_wanted(&self) -> CaptureCount {
        match (self.beyond, self.captures) {
            (BeyondScreen::Captures, CaptureCount::None) => CaptureCount::Auto,
            (_, captures) => captures,
        }
    }

    /// Returns the number of full pixels along a side of one traced pixel: 1, 2 or 4.
    pub fn divisor(&self) -> u32 {
        (1.0 / self.resolution_scale).round() as u32
    }
}

/// The setup of methods. One setup may serve several methods, each of which reads the parameters that it has.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// Width and height in pixels.
    pub extent: [u32; 2],
    /// The projection of the cameras.
    pub projection: ProjectionKind,
    /// The values of the parameters.
    pub values: Values,
}

impl Setup {
    /// Makes a setup of the published values at a size, for perspective cameras.
    pub fn new(extent: [u32; 2]) -> Self {
        Self { extent, projection: ProjectionKind::Perspective, values: Values::default() }
    }

    /// Returns this setup for another kind of projection.
    #[must_use]
    pub fn seen_by(&self, projection: ProjectionKind) -> Self {
        Self { projection, ..self.clone() }
    }

    /// Makes a setup of the published values at a size, in which no ray goes on beyond the screen.
    pub fn on_screen(extent: [u32; 2]) -> Self {
        Self::new(extent).with(|p: &mut EffectParams| p.beyond = BeyondScreen::None)
    }

    /// Returns this setup at another size.
    #[must_use]
    pub fn with_extent(&self, extent: [u32; 2]) -> Self {
        Self { extent, ..self.clone() }
    }

    /// Returns this setup with another preset; values that were given stay.
    #[must_use]
    pub fn of_preset(&self, preset: Preset) -> Self {
        let mut setup = self.clone();
        setup.values.preset = preset;
        setup
    }

    /// Returns this setup after a function changed values of [`EffectParams`] or of a method's own parameters.
    #[must_use]
    pub fn with<P: Parameters>(&self, change: impl FnOnce(&mut P)) -> Self {
        Self { values: self.values.with(change), ..*self }
    }

    /// Returns the values of a group of parameters, for example those of a method.
    pub fn parameters<P: Parameters>(&self) -> P {
        P::from_values(&self.values)
    }

    /// Returns the parameters of the effect around a method.
    pub fn effect(&self) -> EffectParams {
        self.parameters()
    }

    /// Returns the stage of the passes that are published as fragment shaders.
    pub fn stage(&self) -> ShaderStage {
        self.effect().stage.of_pixels()
    }

    /// Returns the setup as in records: size, preset, and the value of every parameter of the effect and of a method.
    pub fn recorded(&self, method: Option<&MethodInfo>) -> BTreeMap<&'static str, Value> {
        let own = method.map(MethodInfo::own_parameters).unwrap_or_default();
        let rows = EffectParams::table().into_iter().chain(own);
        let [width, height] = self.extent;
        let size = [("width", width.value()), ("height", height.value()), ("preset", self.values.preset.value())];
        size.into_iter().chain(rows.map(|row| (row.name, self.values.value(&row)))).collect()
    }
}

/// The outputs that an effect is to make.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Wants {
    /// Where each ray ended, if the method can say so. The program that traces the rays is the same with or without it.
    pub hits: bool,
    /// The reflection as an image of its own.
    pub reflection: bool,
    /// Lit colour with the reflection in it.
    pub composite: bool,
}

impl Wants {
    /// The composite alone: what is timed.
    pub const IMAGE: Self = Self { hits: false, reflection: false, composite: true };
    /// The composite and the reflection.
    pub const REFLECTION: Self = Self { hits: false, reflection: true, composite: true };
    /// All outputs.
    pub const HITS: Self = Self { hits: true, reflection: true, composite: true };
}
