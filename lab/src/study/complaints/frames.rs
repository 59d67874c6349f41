//! Draws the frames of a case: the camera's G-buffer, the reflection by every variant, and the true reflection.

use crate::error::Result;
use crate::stage::gbuffer::{read, reflection};
use crate::stage::{Shot, Stage};
use crate::study::error::Variant;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use ssct::gpu::frame::Mode;
use ssct::gpu::{Gpu, Pixels};
use ssct::methods::{Effect, Input, SceneInput, Setup, Wants};
use ssct::passes::gbuffer::GBufferImages;
use ssct_geometry::bvh::WorldRay;
use ssct_scenes::{Camera, GBufferData, Scene, View};
use ssct_truth::reference::first_hits::{FirstHits, Receiver};
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world::{RAY_START_M, WorldReference};
use ssct_truth::reference::world_hits::world_hits;

/// The seed of the true reflections, equal for all frames, so that a change from frame to frame is no noise.
const SEED: u64 = 5;

/// Scene and frames of a case.
pub struct CaseInput {
    /// The scene.
    pub scene: Scene,
    /// View and moved meshes of each frame.
    pub frames: Vec<Frame>,
    /// Changes the setup of every method for the case.
    pub change_setup: fn(Setup) -> Setup,
    /// Number of bounces in the true reflection.
    pub bounces: u32,
    /// Rays a pixel of the true reflection.
    pub rays: u32,
    /// Changes the G-buffer that methods see, given the frame's number; the true reflection is not changed.
    pub spoil: Option<fn(&mut GBufferData, usize)>,
}

/// A frame of a case.
#[derive(Debug, Clone)]
pub struct Frame {
    /// The camera's place, with its lens.
    pub view: View,
    /// Width and height in pixels.
    pub extent: [u32; 2],
    /// Shift of the image by the projection, in pixels to the right and up.
    pub jitter_px: [f32; 2],
    /// Meshes that have moved, by name, with their offsets in metres.
    pub moved: Vec<(&'static str, Vec3)>,
}

impl Frame {
    /// Makes a frame of a scene in which nothing has moved.
    pub fn still(view: View, extent: [u32; 2]) -> Self {
        Self { view, extent, jitter_px: [0.0; 2], moved: Vec::new() }
    }

    /// Returns the camera of the frame, with its image shifted by the jitter.
    fn camera(&self, scene: &Scene) -> Camera {
        let [right, up] = self.jitter_px;
        self.view.camera(scene, self.extent).jittered([right, -up], self.extent)
    }
}

/// Results of a frame. Lists of pixels have the rows from the top.
pub struct SeenFrame {
    /// G-buffer of the frame, before a case spoils it.
    pub screen: GBufferData,
    /// True reflection of each pixel.
    pub truth: Vec<Vec3>,
    /// Name of the mesh where each pixel's mirror ray ends; empty if it meets no mesh or there is no ray.
    pub end_meshes: Vec<String>,
    /// Whether the screen shows the point where each pixel's mirror ray ends.
    pub end_is_shown: Vec<bool>,
    /// Place of each reflecting pixel's surface in the world, in metres; `None` for any other pixel.
    pub places: Vec<Option<DVec3>>,
    /// Reflection of each pixel by each variant, in the order of the variants.
    pub reflections: Vec<Vec<Vec3>>,
}

/// Draws every frame of a case by every variant, and traces its true reflection. `step` is called after each frame, and
/// its error ends the work.
///
/// # Errors
/// Errors of the device, and of `step`.
pub fn show_frames(
    gpu: &Gpu,
    input: &CaseInput,
    variants: &[Variant],
    step: &mut dyn FnMut() -> Result<()>,
) -> Result<Vec<SeenFrame>> {
    let mut stage = Stage::new(gpu, &input.scene)?;
    let mut last_methods: Option<CaseMethods> = None;
    let mut seen_frames = Vec::new();
    for (frame_index, frame) in input.frames.iter().enumerate() {
        for (name, offset) in &frame.moved {
            stage.scene_mut().place_meshes(name, *offset)?;
        }
        // A renderer that changes its size makes new images, and loses the contents of earlier frames.
        let methods = match last_methods.take().filter(|methods| methods.extent == frame.extent) {
            Some(methods) => methods,
            None => CaseMethods::new(&mut stage, input, frame, variants)?,
        };
        let methods = last_methods.insert(methods);
        if frame_index == 0 {
            methods.settle(&mut stage)?;
        }
        let screen = methods.draw(&mut stage, frame.camera(&input.scene))?;
        let spoilt_screen = input.spoil.map(|spoil| {
            let mut data = screen.clone();
            spoil(&mut data, frame_index);
            data
        });
        let images = methods.reflect(&mut stage, input, spoilt_screen.as_ref())?;
        seen_frames.push(seen_frame(input, frame, screen, images));
        step()?;
    }
    Ok(seen_frames)
}

/// The variants, made for frames of one size.
struct CaseMethods {
    extent: [u32; 2],
    /// Shots that draw the G-buffer and reflect it: one for each variant, or a single one that draws the G-buffer for
    /// `effects`.
    shots: Vec<Shot>,
    /// Variants as effects, for a G-buffer that is changed on the host; empty without such changes.
    effects: Vec<Effect>,
}

impl CaseMethods {
    /// Makes the variants for the size of a frame. If the G-buffer is changed on the host, one shot is made that draws
    /// it, and all variants are made as effects.
    fn new(stage: &mut Stage, input: &CaseInput, frame: &Frame, variants: &[Variant]) -> Result<Self> {
        let camera = frame.camera(&input.scene);
        let materials = &input.scene.materials;
        let setup =
            |variant: &Variant| (input.change_setup)(variant.setup.with_extent(frame.extent)).seen_by(camera.kind());
        let mut effects = Vec::new();
        if input.spoil.is_some() {
            let (context, data) = stage.parts();
            for variant in variants {
                let scene = SceneInput { data, materials };
                effects.push(Effect::new(context, variant.method, &setup(variant), Wants::REFLECTION, Some(&scene))?);
            }
        }
        let shot_variants = if effects.is_empty() { variants } else { &variants[..1] };
        let mut shots = Vec::new();
        for variant in shot_variants {
            let wants = Wants::REFLECTION;
            shots.push(Shot::new(stage, variant.method, &setup(variant), wants, camera, materials.clone())?);
        }
        Ok(Self { extent: frame.extent, shots, effects })
    }

    /// Begins the histories anew, and draws all but the last of the frames that an image at rest takes.
    fn settle(&self, stage: &mut Stage) -> Result<()> {
        Ok(self.shots.iter().try_for_each(|shot| stage.settle(shot))?)
    }

    /// Sets the camera of every shot, draws the G-buffer, and reads it back.
    fn draw(&mut self, stage: &mut Stage, camera: Camera) -> Result<GBufferData> {
        self.shots.iter_mut().for_each(|shot| shot.camera = camera);
        let shot = &self.shots[0];
        stage.draw(shot)?;
        Ok(read(&mut stage.context, shot)?)
    }

    /// Draws the reflection by each variant: on the G-buffer `spoilt`, if one is given, else on the G-buffer that each
    /// variant draws itself.
    fn reflect(&self, stage: &mut Stage, input: &CaseInput, spoilt: Option<&GBufferData>) -> Result<Vec<Pixels>> {
        let mut reflections = Vec::new();
        let Some(data) = spoilt else {
            for shot in &self.shots {
                let (_, _, output) = stage.output(shot)?;
                reflections.push(reflection(&mut stage.context, &output)?);
            }
            return Ok(reflections);
        };
        let (context, scene) = stage.parts();
        let images = GBufferImages::upload(context, data)?;
        for effect in &self.effects {
            let scene = SceneInput { data: scene, materials: &input.scene.materials };
            let screen_input = Input::of_screen(images.gbuffer(), &data.camera);
            let mut frame = context.begin(Mode::Plain)?;
            frame.begin_effect();
            let effect_input = Input { scene: Some(scene), sky: Some(scene.data.sky()), ..screen_input };
            let output = effect.record(&mut frame, &effect_input)?;
            frame.finish()?;
            reflections.push(reflection(context, &output)?);
        }
        Ok(reflections)
    }
}

/// Traces the true reflection of a frame, and puts it together with the reflections `images` by the variants. `screen`
/// is the frame's G-buffer.
fn seen_frame(input: &CaseInput, frame: &Frame, screen: GBufferData, images: Vec<Pixels>) -> SeenFrame {
    let mut scene = input.scene.clone();
    for (name, offset) in &frame.moved {
        scene.meshes.iter_mut().filter(|mesh| mesh.name == *name).for_each(|mesh| mesh.translate(*offset));
    }
    let world = World::new(&scene, &scene.materials);
    let first_hits = FirstHits::shown(&world, &screen);
    let reference = WorldReference::new(&world, &first_hits, &screen.camera, SEED).with_bounces(input.bounces);
    let mut state = reference.start();
    reference.add(&mut state, input.rays);
    let truth = reference.image(&state).reflection;
    let colors = |pixels: &Pixels| pixels.texels().map(|t| Vec3::new(t[0], t[1], t[2])).collect();
    let places = first_hits.receivers.iter().map(|receiver| receiver.map(|r| r.position)).collect();
    let end_is_shown = world_hits(&world, &screen, &first_hits).iter().map(|hit| hit.visible_at().is_some()).collect();
    SeenFrame {
        end_is_shown,
        end_meshes: end_meshes(&world, &first_hits),
        places,
        truth,
        reflections: images.iter().map(colors).collect(),
        screen,
    }
}

/// Returns for each pixel the name of the mesh where its mirror ray ends; an empty name if it meets no mesh, or if the
/// pixel has no mirror ray.
fn end_meshes(world: &World, first_hits: &FirstHits) -> Vec<String> {
    let end = |receiver: &Option<Receiver>| {
        let receiver = receiver.as_ref()?;
        let (origin, direction) = (receiver.position, receiver.mirror());
        let hit = world.closest(&WorldRay { origin, direction, t_min: RAY_START_M, t_max: f64::INFINITY })?;
        Some(world.scene.meshes[world.triangle(&hit).mesh as usize].name.clone())
    };
    first_hits.receivers.par_iter().map(|receiver| end(receiver).unwrap_or_default()).collect()
}
