//! The methods, one file each, and the table of all of them. The `record` of a method calls passes in the order of the
//! data flow, each with the outputs of earlier ones. The passes around every method, down to the composite, are in
//! [`effect`].

pub mod area_light;
mod beyond;
pub mod billboard;
pub mod capture;
pub mod captures;
pub mod dda;
pub mod effect;
pub mod environment;
pub mod exclusions;
pub mod hzct;
pub mod ibr;
pub mod layers;
pub mod linear;
pub mod local_map;
pub mod needs;
pub mod pccm;
pub mod planar;
pub mod poster;
pub mod setup;
pub mod ssct;
pub mod sslr;
pub mod ssr;
pub mod ssr_fast;
pub mod stochastic;
pub mod thesis;
pub mod traced;
pub mod unified;

use crate::error::{Error, Result};
use crate::gpu::{Frame, FrameContext, Gpu, Image};
use crate::passes::history::SurfaceMotion;
use crate::passes::scene_data::SceneData;
use crate::passes::trace_normals::TraceNormals;
use crate::passes::triangle_scene::{TriangleBuffers, TriangleReading};
use crate::passes::{Captures, Content, GBuffer, Hits, Pyramid, Reflection};
pub use effect::{Effect, Output, Prepared};
use layers::LayerParams;
use needs::Need;
pub use setup::{EffectParams, Fallback, Setup, Wants};
use ssct_ground::parameter::{Parameter, Parameters};
use ssct_ground::scene::{Camera, Material, Scene};
use std::collections::HashSet;
use std::sync::{PoisonError, RwLock};

/// The inputs of a method in a frame. The method's outputs may borrow the G-buffer (`'a`), but not the scene (`'s`).
#[derive(Clone, Copy)]
pub struct Input<'a, 's> {
    /// The images that the scene passes left.
    pub gbuffer: GBuffer<'a>,
    /// The camera that the G-buffer was drawn with.
    pub camera: &'s Camera,
    /// The scene itself; `None` where only a G-buffer is known.
    pub scene: Option<SceneInput<'s>>,
    /// The environment, as a cube map in world axes, where it is known.
    pub sky: Option<&'s Image>,
    /// Captures of the scene, where there are any.
    pub captures: Option<Captures<'a>>,
    /// The triangles of the scene, where rays are followed among them.
    pub triangles: Option<TriangleBuffers<'s>>,
    /// The second layer of depth, at the size of the G-buffer, if the method is set up for one ([`layers`]). A pixel
    /// without a second surface has depth 0 in it.
    pub second_layer: Option<GBuffer<'a>>,
    /// The reflection behind which this method's own reflection shows, if the method is a fallback.
    pub in_front: Option<Reflection<'a>>,
    /// The motion of surfaces since the frame before, for a history, if the caller knows it.
    pub motion: Option<SurfaceMotion<'s>>,
    /// Number of frames of a history before this one that had other directions of rays; 0 without a history.
    pub frame: u32,
    /// Number of frames with other directions of rays since the camera last moved; 0 while the camera moves.
    pub frames_at_rest: u32,
    /// Number of bounces before this one in the frame. From the second bounce on, the lit colour contains the
    /// reflections of the bounce before. Images that do not depend on this colour remain valid.
    pub bounce: u32,
}

impl<'a, 's> Input<'a, 's> {
    /// Makes the input for a G-buffer without its scene.
    pub fn of_screen(gbuffer: GBuffer<'a>, camera: &'s Camera) -> Self {
        Self {
            gbuffer,
            camera,
            scene: None,
            sky: None,
            captures: None,
            triangles: None,
            second_layer: None,
            in_front: None,
            motion: None,
            frame: 0,
            frames_at_rest: 0,
            bounce: 0,
        }
    }

    /// Returns the images of a pass that reads no colour, so that they are equal in all bounces. In the first bounce
    /// `record` runs the pass, and in later bounces `recorded` returns the images that it made.
    pub(crate) fn in_first_bounce<T>(
        &self,
        record: impl FnOnce() -> Result<T>,
        recorded: impl FnOnce() -> T,
    ) -> Result<T> {
        if self.bounce == 0 { record() } else { Ok(recorded()) }
    }

    /// Returns the scene, for a method that needs one.
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
    /// The materials of the view, with the factors that the user sets for all of them.
    pub materials: &'a [Material],
}

/// An image that a method made along the way, for inspection.
#[derive(Clone, Copy)]
pub struct Intermediate<'a> {
    /// File stem, to which the number of a level, or of a volume's slice, is added if there are several.
    pub name: &'static str,
    /// The meaning of the image's numbers.
    pub content: Content,
    /// The image.
    pub image: &'a Image,
}

impl<'a> Pyramid<'a> {
    /// Returns the pyramid as an intermediate; `extent` is the size of the picture in pixels.
    pub(crate) fn as_intermediate(self, extent: [u32; 2]) -> Intermediate<'a> {
        Intermediate { name: "pyramid", content: Content::Pyramid(extent), image: self.0 }
    }
}

/// The images that a method made in a frame.
#[derive(Clone)]
pub struct MethodOutput<'a> {
    /// Reflection colour and fade; `None` where nothing reflects, or where it is not wanted.
    pub reflection: Option<Reflection<'a>>,
    /// The finished image, linear, in level 0, if the method made it along the way.
    pub composite: Option<&'a Image>,
    /// Where each ray ended.
    pub hits: Option<Hits<'a>>,
    /// Where the rays of each pixel ended ([`ENDS`](crate::passes::lost::ENDS)), for a history; `None` if not known.
    pub ends: Option<&'a Image>,
    /// Other images that the method made.
    pub intermediates: Vec<Intermediate<'a>>,
}

impl<'a> MethodOutput<'a> {
    /// Makes an output that is a reflection without intermediates.
    pub fn new(reflection: Reflection<'a>) -> Self {
        Self { reflection: Some(reflection), composite: None, hits: None, ends: None, intermediates: Vec::new() }
    }

    /// Makes an output without a reflection, whose finished image is the lit colour.
    pub fn nothing(gbuffer: &GBuffer<'a>) -> Self {
        Self { reflection: None, composite: Some(gbuffer.color), hits: None, ends: None, intermediates: Vec::new() }
    }
}

/// A method for images of one size, on one device.
pub trait Method: Send {
    /// Makes the images that outlive frames, such as captured maps, from the scene. The effect calls this function
    /// before the first frame, and again when materials change. The call is not part of any frame's time.
    fn prepare(&mut self, _context: &mut FrameContext, _scene: &SceneInput) -> Result<()> {
        Ok(())
    }

    /// Records every pass from the G-buffer to the reflection.
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>>;
}

/// What a method needs to see.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MethodScope {
    /// The G-buffer alone: a screen-space method.
    Screen,
    /// The scene too.
    Scene,
}

/// The setup and the outputs that [`Effect`] makes a method for.
pub struct MethodRequest {
    /// The parameters, and the size that the method works at.
    pub setup: Setup,
    /// Whether the method must say where each ray ended, if it can.
    pub hits: bool,
    /// Whether the reflection must be an image of its own, even if the method composites along the way.
    pub reflection: bool,
    /// Whether the method may make the composite along the way.
    pub composite: bool,
    /// Width and height of the faces of the captures that the method gets; `None` if it gets none.
    pub captures: Option<[u32; 2]>,
    /// How shaders read the triangles that the method gets; `None` if it gets none.
    pub triangles: Option<TriangleReading>,
    /// Whether the method is a fallback, behind another reflection ([`Input::in_front`]).
    pub is_fallback: bool,
}

impl MethodRequest {
    /// Makes the request for a method that gets neither captures nor triangles, and is no fallback.
    pub fn new(setup: &Setup, Wants { hits, reflection, composite }: Wants) -> Self {
        let (setup, is_fallback) = (setup.clone(), false);
        Self { setup, hits, reflection, composite, captures: None, triangles: None, is_fallback }
    }
}

/// A method that is not in the table, but is added while the program runs.
pub trait Added: Send + Sync {
    /// The method's own parameters.
    fn parameters(&self) -> Vec<Parameter>;

    /// Makes the method.
    ///
    /// # Errors
    /// Errors of the device, and a sentence on parts of the method that do not fit together.
    fn create(&self, gpu: &Gpu, request: &MethodRequest) -> Result<Box<dyn Method>>;
}

/// A function that makes a method.
pub type CreateMethod = fn(&Gpu, &MethodRequest) -> Result<Box<dyn Method>>;

/// A row of the table of methods.
pub struct MethodInfo {
    /// Name on the command line and in records.
    pub name: &'static str,
    /// One line on what it does.
    pub summary: &'static str,
    /// Where it is published.
    pub source: &'static str,
    /// What the method needs to see.
    pub sees: MethodScope,
    /// The parts that the method needs a scene to have. If one of them is missing, the method shows nothing.
    pub needs: &'static [Need],
    /// Whether the method's reflections can fade at the screen's border.
    pub fades: bool,
    /// Whether the method finds the hits of the version of the oracle that the parameter `oracle` asks for.
    pub follows_oracle: bool,
    /// Whether the method follows rays in captures of the scene, if there are any.
    pub takes_captures: bool,
    /// Whether the method can follow rays among the triangles of the scene.
    pub takes_triangles: bool,
    /// Whether the method takes orthographic cameras.
    pub takes_orthographic: bool,
    /// Whether the method traces through the thesis's Hi-Z chain, whose steps a twin on the CPU can follow.
    pub traces_hi_z: bool,
    /// Returns the own parameters of a method of the table.
    pub parameters: fn() -> Vec<Parameter>,
    /// Makes a method of the table.
    pub create: CreateMethod,
    /// The implementation of a method that was added; `None` in the table.
    pub added: Option<&'static dyn Added>,
}

impl MethodInfo {
    /// Makes the row of a screen-space method that fades and has no own parameters. Methods override what differs.
    const fn screen(name: &'static str, summary: &'static str, source: &'static str, create: CreateMethod) -> Self {
        Self {
            name,
            summary,
            source,
            sees: MethodScope::Screen,
            needs: &[],
            fades: true,
            follows_oracle: false,
            takes_captures: false,
            takes_triangles: false,
            takes_orthographic: false,
            traces_hi_z: false,
            parameters: Vec::new,
            create,
            added: None,
        }
    }

    /// Makes the row of a method that needs the scene, does not fade and has no own parameters.
    const fn scene(name: &'static str, summary: &'static str, source: &'static str, create: CreateMethod) -> Self {
        Self { sees: MethodScope::Scene, fades: false, ..Self::screen(name, summary, source, create) }
    }

    /// Makes the method without the passes that [`Effect`] puts around it. The method may finish the image itself.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn make_alone(&self, gpu: &Gpu, setup: &Setup, wants: Wants) -> Result<Box<dyn Method>> {
        self.make(gpu, &MethodRequest::new(setup, wants))
    }

    /// Makes the row of a screen-space method that is not in the table. The strings live as long as the program.
    pub fn added(name: &'static str, summary: &'static str, source: &'static str, added: &'static dyn Added) -> Self {
        let refuse: CreateMethod = |_, _| Err(Error::Usage("this method is made by what added it".into()));
        // Orthographic cameras are not refused here; the method itself may refuse them.
        Self { added: Some(added), takes_orthographic: true, ..Self::screen(name, summary, source, refuse) }
    }

    /// Makes the method for one size on one device.
    ///
    /// # Errors
    /// Errors of the device, and of a method that does not fit the setup.
    pub fn make(&self, gpu: &Gpu, request: &MethodRequest) -> Result<Box<dyn Method>> {
        match self.added {
            Some(added) => added.create(gpu, request),
            None => (self.create)(gpu, request),
        }
    }

    /// Returns the method's own parameters.
    pub fn own_parameters(&self) -> Vec<Parameter> {
        self.added.map_or_else(self.parameters, |added| added.parameters())
    }

    /// Returns the parts that the method needs and a scene lacks.
    pub fn unmet_needs(&self, scene: &Scene) -> Vec<Need> {
        self.needs.iter().copied().filter(|need| !need.is_met(scene)).collect()
    }

    /// Whether the method needs no more than a G-buffer, wherever that comes from.
    pub fn is_screen_space(&self) -> bool {
        self.sees == MethodScope::Screen
    }

    /// Whether the method is set up for a second layer of depth.
    pub fn takes_second_layer(&self, setup: &Setup) -> bool {
        self.own_parameters().iter().any(|p| p.name == "layers") && setup.parameters::<LayerParams>().has_second()
    }

    /// Returns every parameter that the method reads: those of the effect around the method, then its own.
    pub fn read_parameters(&self) -> Vec<Parameter> {
        let is_read = |parameter: &Parameter| match parameter.name {
            "fade" => self.fades,
            "oracle" => self.follows_oracle,
            "beyond" => self.takes_captures && self.takes_triangles,
            "tracer" | "own_rays" => self.takes_triangles,
            "captures" | "capture_side" | "captures_per_frame" => self.takes_captures,
            "definitions" => true,
            // Methods that follow rays among triangles alone run in compute shaders only.
            "stage" => self.is_screen_space() || !self.takes_triangles,
            _ => self.is_screen_space(),
        };
        EffectParams::table().into_iter().filter(is_read).chain(self.own_parameters()).collect()
    }
}

/// The table of methods.
pub const METHODS: &[MethodInfo] = &[
    ssct::INFO,
    hzct::INFO,
    sslr::INFO,
    linear::INFO,
    poster::INFO,
    ssr::INFO,
    ssr_fast::INFO,
    dda::INFO,
    stochastic::INFO,
    local_map::INFO,
    pccm::INFO,
    billboard::INFO,
    ibr::INFO,
    planar::INFO,
    area_light::INFO,
    environment::INFO,
    captures::INFO,
    traced::INFO,
    unified::INFO,
];

/// Methods that were added while the program runs.
static ADDED: RwLock<Vec<&'static MethodInfo>> = RwLock::new(Vec::new());

/// Returns every method: the methods of the table, then the added ones.
pub fn all() -> Vec<&'static MethodInfo> {
    let added = ADDED.read().unwrap_or_else(PoisonError::into_inner);
    METHODS.iter().chain(added.iter().copied()).collect()
}

/// Adds a method, which stays as long as the program runs.
///
/// # Errors
/// [`Error::Usage`] if there is a method of this name already.
pub fn add(info: MethodInfo) -> Result<&'static MethodInfo> {
    let mut added = ADDED.write().unwrap_or_else(PoisonError::into_inner);
    if METHODS.iter().chain(added.iter().copied()).any(|m| m.name == info.name) {
        return Err(Error::Usage(format!("there is a method {} already", info.name)));
    }
    let info: &'static MethodInfo = Box::leak(Box::new(info));
    added.push(info);
    Ok(info)
}

/// Finds methods by their names. Without names, returns every method of the table that fits the setup.
///
/// # Errors
/// [`Error::Usage`] for a name that no method has, and for a given parameter that none of the methods reads.
pub fn choose(names: &[String], setup: &Setup) -> Result<Vec<&'static MethodInfo>> {
    if names.is_empty() {
        let effect = setup.effect();
        let suits_any_method = effect.fallback == Fallback::None
            && effect.divisor() == 1
            && effect.trace_normals == TraceNormals::Shading
            && effect.bounces == 1;
        return Ok(METHODS.iter().filter(|m| suits_any_method || m.is_screen_space()).collect());
    }
    let mut methods = names.iter().map(|name| find(name)).collect::<Result<Vec<_>>>()?;
    // A method that is named twice counts once.
    let mut seen = HashSet::new();
    methods.retain(|method| seen.insert(method.name));
    check_read(&methods, setup)?;
    Ok(methods)
}

/// Refuses a parameter that was given, if none of `methods` reads it.
///
/// # Errors
/// [`Error::Usage`] with the parameter and the methods that have it.
pub fn check_read(methods: &[&MethodInfo], setup: &Setup) -> Result<()> {
    // Parameters of the effect are taken even if no method reads them. The oracle judges every method, and a fallback
    // or a lower resolution that a method cannot have is refused when its effect is made.
    let effect_names: Vec<_> = EffectParams::table().iter().map(|p| p.name).collect();
    let has = |m: &MethodInfo, name: &str| m.own_parameters().iter().any(|p| p.name == name);
    for name in setup.values.given_names().filter(|name| !effect_names.contains(name)) {
        if !methods.iter().any(|m| has(m, name)) {
            let typed = name.replace('_', "-");
            let chosen: Vec<_> = methods.iter().map(|m| m.name).collect();
            let others: Vec<_> = all().into_iter().filter(|m| has(m, name)).map(|m| m.name).collect();
            return Err(Error::Usage(format!(
                "{typed} is no parameter of {}; it is one of {}",
                chosen.join(", "),
                others.join(", ")
            )));
        }
    }
    Ok(())
}

/// Returns the method of a name, or an error that lists the names of all methods.
pub fn find(name: &str) -> Result<&'static MethodInfo> {
    let all = all();
    all.iter().find(|m| m.name == name).copied().ok_or_else(|| {
        let names: Vec<_> = all.iter().map(|m| m.name).collect();
        Error::Usage(format!("no method {name:?}; there is: {}", names.join(", ")))
    })
}

/// Returns every parameter with the methods that read it, in the order of the tables. A name is listed again where
/// methods have other default values or texts for it; its domain is the same everywhere.
pub fn parameters() -> Vec<(Parameter, Vec<&'static MethodInfo>)> {
    let mut all: Vec<(Parameter, Vec<&'static MethodInfo>)> =
        EffectParams::table().into_iter().map(|p| (p, Vec::new())).collect();
    for method in self::all() {
        for parameter in method.read_parameters() {
            match all.iter_mut().find(|(p, _)| *p == parameter) {
                Some((_, methods)) => methods.push(method),
                None => all.push((parameter, vec![method])),
            }
        }
    }
    all
}

#[cfg(test)]
mod tests;
