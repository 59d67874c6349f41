//! A scene on a device, and a shot of it: one camera, one size, one method.

pub mod gbuffer;
pub mod image;
mod shared;

pub use image::{Intermediates, RenderedImage};
pub use shared::{SharedImages, span_ms};

use glam::Vec3;
use ssct::error::Result;
use ssct::gpu::frame::Mode;
use ssct::gpu::{Frame, FrameContext, FrameReport, Gpu};
use ssct::methods::{Effect, Input, MethodInfo, Output, Prepared, SceneInput, Setup, Wants, unified};
use ssct::passes::gbuffer::{DrawnCounts, GBufferPass};
use ssct::passes::lighting::LightingPass;
use ssct::passes::scene_data::SceneData;
use ssct::passes::{Captures, GBuffer};
use ssct_geometry::placement;
use ssct_scenes::tree::Trees;
use ssct_scenes::{Camera, Capture, Material, Scene, View};
use std::rc::Rc;

/// The global factors of the command line; they replace or scale every material's values
/// (docs/definitions.md, "Surfaces").
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Globals {
    /// Replaces every roughness, also in materials with a roughness map. Reflectivities stay as they are.
    pub roughness: Option<f32>,
    /// Scales every reflectivity.
    pub reflectivity: f32,
    /// Replaces every normal deviation.
    pub normal_deviation: Option<f32>,
}

impl Default for Globals {
    fn default() -> Self {
        Self { roughness: None, reflectivity: 1.0, normal_deviation: None }
    }
}

impl Globals {
    /// Returns the scene's materials in a view, changed by these factors.
    pub fn materials(&self, scene: &Scene, view: &View) -> Vec<Material> {
        let mut materials = scene.materials_in(view);
        for material in &mut materials {
            if let Some(roughness) = self.roughness {
                (material.roughness, material.roughness_map) = (roughness, None);
            }
            material.normal_deviation = self.normal_deviation.unwrap_or(material.normal_deviation);
            material.reflectivity *= self.reflectivity;
        }
        materials
    }
}

/// A scene on a device, with the context that records its frames.
pub struct Stage {
    /// The context, which records frames, submits them and reads images back.
    pub context: FrameContext,
    /// The scene on the device.
    data: SceneData,
}

impl Stage {
    /// Uploads a scene to a device. Captures and trees over triangles are made when an effect first needs them.
    pub fn new(gpu: &Gpu, scene: &Scene) -> Result<Self> {
        let mut context = FrameContext::new(gpu)?;
        let mut data = SceneData::upload(&mut context, scene)?;
        data.set_capture_finder(placement::finder(scene));
        data.set_tree_builder(Trees::new(scene));
        Ok(Self { context, data })
    }

    /// The scene on the device.
    pub fn scene(&self) -> &SceneData {
        &self.data
    }

    /// The scene on the device, to change what moves in it between frames.
    pub fn scene_mut(&mut self) -> &mut SceneData {
        &mut self.data
    }

    /// Replaces the captures of the scene's file for shots that are made from now on; if the list is empty, captures are placed.
    pub fn set_captures(&mut self, captures: Vec<Capture>) {
        self.data.set_captures(captures);
    }

    /// The context that records frames, and the scene on the device.
    pub(crate) fn parts(&mut self) -> (&mut FrameContext, &SceneData) {
        (&mut self.context, &self.data)
    }

    /// Begins a frame of a shot. If the shot's method asks for the scene's triangles, the triangles are first put where
    /// the meshes stand now.
    fn begin(&mut self, shot: &Shot, mode: Mode) -> Result<(Frame<'_>, &SceneData)> {
        let Self { context, data } = self;
        shot.effect.prepare_triangles(context, data)?;
        Ok((context.begin(mode)?, data))
    }

    /// Draws one frame of a shot: the scene, and the method on it. Returns the report of the frame, and the counts of
    /// drawn meshes.
    pub fn run(&mut self, shot: &Shot, mode: Mode) -> Result<(FrameReport, DrawnCounts)> {
        self.output_in(mode, shot).map(|(report, drawn, _)| (report, drawn))
    }

    /// Draws the scene of a shot into its G-buffer, without running the method.
    pub fn draw(&mut self, shot: &Shot) -> Result<DrawnCounts> {
        Ok(self.draw_in(Mode::Plain, shot)?.1)
    }

    /// Draws the scene of a shot in a mode into its G-buffer, without running the method.
    fn draw_in(&mut self, mode: Mode, shot: &Shot) -> Result<(FrameReport, DrawnCounts)> {
        let mut frame = self.context.begin(mode)?;
        let drawn = shot.draw(&mut frame, &self.data)?;
        Ok((frame.finish()?, drawn))
    }

    /// Draws one frame of a shot in the plain mode, and also returns the images that the method made.
    pub fn output<'s>(&mut self, shot: &'s Shot) -> Result<(FrameReport, DrawnCounts, Output<'s>)> {
        self.output_in(Mode::Plain, shot)
    }

    /// Draws one frame of a shot in a mode, and also returns the images that the method made.
    pub fn output_in<'s>(&mut self, mode: Mode, shot: &'s Shot) -> Result<(FrameReport, DrawnCounts, Output<'s>)> {
        let (mut frame, data) = self.begin(shot, mode)?;
        let (drawn, output) = shot.record(&mut frame, data)?;
        Ok((frame.finish()?, drawn, output))
    }

    /// Draws the image of a camera at rest ([`SharedImages::output_at_rest`]).
    pub fn output_at_rest<'s>(&mut self, shot: &'s Shot) -> Result<(FrameReport, DrawnCounts, Output<'s>)> {
        SharedImages::default().output_at_rest(self, shot)
    }

    /// Begins the history of a shot anew, and runs all but the last of the frames that an image at rest takes, so that
    /// the next frame shows this image.
    pub fn settle(&mut self, shot: &Shot) -> Result<()> {
        SharedImages::default().settle(self, shot)
    }

    /// Runs the method of a shot alone, on the G-buffer that another shot of its scene and size drew last. `drawn` has
    /// the counts that this drawing returned.
    pub fn output_on<'s>(
        &mut self,
        mode: Mode,
        shot: &'s Shot,
        (other, drawn): (&'s Shot, &DrawnCounts),
    ) -> Result<(FrameReport, Output<'s>)> {
        let (mut frame, data) = self.begin(shot, mode)?;
        frame.begin_effect();
        let output = shot.reflect(&mut frame, data, (other, drawn))?;
        Ok((frame.finish()?, output))
    }
}

/// One camera, one size and one method, with the scene passes and the method's own passes.
pub struct Shot {
    /// The G-buffer pass and its images, which other shots may share.
    pub gbuffer: Rc<GBufferPass>,
    /// The pass that lights the G-buffer.
    lighting: LightingPass,
    /// The method, with all that surrounds it.
    effect: Effect,
    /// The camera of the shot.
    pub camera: Camera,
    /// The materials with which the scene is drawn.
    materials: Vec<Material>,
}

impl Shot {
    /// Makes pipelines and images, and prepares what the method needs of the scene, such as captures. `wants` says
    /// which images of the method are read later.
    pub fn new(
        stage: &mut Stage,
        method: &MethodInfo,
        setup: &Setup,
        wants: Wants,
        camera: Camera,
        materials: Vec<Material>,
    ) -> Result<Self> {
        SharedImages::default().shot(stage, method, setup, wants, camera, materials)
    }

    /// Makes a shot that serves to draw a scene's G-buffer from any camera. Its method is one that takes every camera,
    /// and is not meant to be run.
    pub fn of_scene(stage: &mut Stage, extent: [u32; 2], camera: Camera, materials: Vec<Material>) -> Result<Self> {
        Self::new(stage, &unified::INFO, &Setup::on_screen(extent), Wants::IMAGE, camera, materials)
    }

    /// The captures in which rays go on, with their places; `None` if the method takes no captures.
    pub fn captures(&self) -> Option<(Captures<'_>, Vec<Capture>)> {
        self.effect.captures()
    }

    /// The data that the method prepared from the scene before the first frame.
    pub fn prepared(&self) -> &Prepared {
        self.effect.prepared()
    }

    /// Replaces the materials, and prepares again what the method takes from the scene.
    pub fn set_materials(&mut self, stage: &mut Stage, materials: Vec<Material>) -> Result<()> {
        self.materials = materials;
        let Stage { context, data } = stage;
        self.effect.prepare(context, &SceneInput { data, materials: &self.materials })
    }

    /// Gives the shot other materials and another camera with the same kind of projection, and begins its history anew.
    pub fn turn_to(&mut self, stage: &mut Stage, camera: Camera, materials: Vec<Material>) -> Result<()> {
        self.camera = camera;
        self.effect.restart_history();
        self.set_materials(stage, materials)
    }

    /// Number of frames that an image of a camera at rest takes: 1 without a history.
    pub fn frames_at_rest(&self) -> u32 {
        self.effect.frames_at_rest()
    }

    /// Number of faces of the captures that the method looks into; 0 without captures.
    pub fn capture_faces(&self) -> u32 {
        self.effect.capture_faces()
    }

    /// Moves the method's captures to other places in the scene, at most as many as there are captures, and draws them anew there.
    pub fn move_captures(&mut self, stage: &mut Stage, places: &[Vec3]) -> Result<()> {
        let Stage { context, data } = stage;
        self.effect.move_captures(context, &SceneInput { data, materials: &self.materials }, places)
    }

    /// Records the scene passes, which draw the G-buffer and light it.
    fn draw(&self, frame: &mut Frame, data: &SceneData) -> Result<DrawnCounts> {
        let drawn = self.gbuffer.record(frame, data, &self.materials, &self.camera)?;
        let gbuffer = GBuffer { reflectors: drawn.reflectors, ..self.gbuffer.gbuffer() };
        self.lighting.record(frame, &gbuffer, self.gbuffer.albedo(), data, &self.camera)?;
        Ok(drawn)
    }

    /// Records the scene passes of a frame, and the method's passes after them.
    fn record<'s>(&'s self, frame: &mut Frame, data: &SceneData) -> Result<(DrawnCounts, Output<'s>)> {
        let drawn = self.draw(frame, data)?;
        frame.begin_effect();
        let output = self.reflect(frame, data, (self, &drawn))?;
        Ok((drawn, output))
    }

    /// Records the method's passes on the G-buffer of `shot`, seen from the camera of `shot`. `drawn` has the counts of
    /// the frame that drew this G-buffer.
    fn reflect<'s>(
        &'s self,
        frame: &mut Frame,
        data: &SceneData,
        (shot, drawn): (&'s Shot, &DrawnCounts),
    ) -> Result<Output<'s>> {
        let gbuffer = GBuffer { reflectors: drawn.reflectors, ..shot.gbuffer.gbuffer() };
        let scene = SceneInput { data, materials: &self.materials };
        self.effect.record(
            frame,
            &Input { scene: Some(scene), sky: Some(data.sky()), ..Input::of_screen(gbuffer, &shot.camera) },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_global_roughness_replaces_numbers_and_maps() {
        let mapped = Material { roughness: 1.0, roughness_map: Some(3), reflectivity: 0.7, ..Material::default() };
        let scene = Scene { materials: vec![mapped.clone(), Material::default()], ..Scene::default() };
        let changed = Globals { roughness: Some(0.3), ..Globals::default() }.materials(&scene, &View::default());
        let roughnesses: Vec<_> = changed.iter().map(|m| (m.roughness, m.roughness_map)).collect();
        assert_eq!(roughnesses, [(0.3, None); 2]);
        assert_eq!(changed[0].reflectivity, 0.7, "what a material reflects stays");
        assert_eq!(Globals::default().materials(&scene, &View::default())[0], mapped);
    }
}
