//! Renders the frames that the state asks for, keeps the pictures that are shown, and analyses a frame at rest.

use super::cubes::CubeImage;
use super::history::History;
use super::state::{InnerImage, STEPS, Side, State};
use glam::Vec3;
use ssct::gpu::frame::Mode;
use ssct::gpu::timing::PassWork;
use ssct::gpu::{FrameReport, Gpu, Image, Pixels};
use ssct::methods::setup::CaptureCount;
use ssct::methods::{Intermediate, Wants};
use ssct::passes::Content;
use ssct::passes::look::KeepPass;
use ssct_lab::error::Result;
use ssct_lab::stage::{Shot, Stage, gbuffer, image};
use ssct_lab::study::inspect::Inspection;
use ssct_scenes::capture::face_camera;
use ssct_scenes::{Camera, Capture, Lens, Material, Scene};
use std::time::Instant;

/// Everything that a rendered frame depends on.
#[derive(Clone, PartialEq)]
pub struct FrameRequest {
    /// The camera.
    pub camera: Camera,
    /// The view's materials, with the global factors applied.
    pub materials: Vec<Material>,
    /// Width and height in pixels.
    pub extent: [u32; 2],
    /// The methods to render: one or two.
    pub sides: Vec<Side>,
    /// An intermediate that is shown instead of the finished image.
    pub inside: Option<InnerImage>,
    /// Captures that replace the scene's, if the user changed them.
    pub captures: Option<Vec<Capture>>,
}

/// An image of a frame that can be shown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImageInfo {
    /// Its name.
    pub name: String,
    /// Mip levels, or slices of a volume.
    pub levels: u32,
    /// Width and height of level 0.
    pub extent: [u32; 2],
}

/// A method that is shown.
pub struct ShownMethod {
    side: Side,
    /// The method with its pipelines and images.
    shot: Shot,
    /// Keeps a copy of the picture that is shown.
    kept: KeepPass,
    /// The meaning of the kept picture's numbers.
    pub content: Content,
    /// The method's pass times.
    pub history: History,
    /// The images that the method made.
    pub images: Vec<ImageInfo>,
    /// The lens of the kept picture, if it is not the camera's.
    pub lens: Option<Lens>,
    /// The image of a capture, with its level, if it is the kept picture. It need not be made anew when the camera
    /// moves.
    kept_cube: Option<(CubeImage, u32)>,
}

/// The analysis of a frame at rest.
#[derive(Default)]
pub struct FrameAnalysis {
    /// Label and counted work of each pass of the first method; empty if the device does not count.
    pub work: Vec<(String, PassWork)>,
    /// Reflection colours of each method, before fade and reflectivity.
    pub reflections: Vec<Vec<[f32; 3]>>,
    /// The data of the first method's frame that were read back.
    pub inspection: Option<Inspection>,
    /// The reflection with its fade, and the finished image, of the first method.
    pub reflection_and_composite: Option<[Pixels; 2]>,
    /// The number of steps of each pixel's ray, for methods that traverse a Hi-Z chain.
    pub steps: Option<Vec<u32>>,
}

/// The pictures of the shown methods in one scene.
pub struct Pictures {
    /// The scene on the device.
    pub stage: Stage,
    /// The first and the second method that are shown.
    shown: [Option<ShownMethod>; 2],
    /// The first method as a shot that also writes the ends of its rays.
    shot_with_hits: Option<(Side, Shot)>,
    /// The request that the pictures show; `None` if something made them stale.
    shown_request: Option<FrameRequest>,
    /// The number of further frames until an image at rest is final, since histories average over frames.
    frames_to_settle: u32,
    /// The last request that was rendered, even if the pictures are stale.
    last_request: Option<FrameRequest>,
    /// The materials of the last frame.
    materials: Vec<Material>,
    /// The captures of the scene's file.
    scene_captures: Vec<Capture>,
    /// The captures of the user that replace them on the stage, if any.
    captures: Option<Vec<Capture>>,
}

impl Pictures {
    /// Uploads a scene.
    pub fn new(gpu: &Gpu, scene: &Scene) -> Result<Self> {
        Ok(Self {
            stage: Stage::new(gpu, scene)?,
            shown: [None, None],
            shot_with_hits: None,
            shown_request: None,
            frames_to_settle: 0,
            last_request: None,
            materials: Vec::new(),
            scene_captures: scene.captures.clone(),
            captures: None,
        })
    }

    /// Returns whether a request differs from the one rendered last, or whether its history is not complete yet.
    pub fn needs_rendering(&self, request: &FrameRequest) -> bool {
        self.frames_to_settle > 0 || self.shown_request.as_ref() != Some(request)
    }

    /// Forces the next frame to be rendered, even if nothing changed.
    pub fn invalidate(&mut self) {
        self.shown_request = None;
    }

    /// Discards all pipelines, which the next frame makes anew, and all measured times.
    pub fn discard_pipelines(&mut self) {
        self.shown = [None, None];
        self.shot_with_hits = None;
        self.shown_request = None;
    }

    /// Makes the pipelines of the last frame and discards them, to test whether they can be made.
    pub fn try_pipelines(&mut self) -> Result<()> {
        let Some(request) = self.last_request.clone() else { return Ok(()) };
        request.sides.iter().try_for_each(|side| self.make_shot(side, Wants::REFLECTION, &request).map(|_| ()))
    }

    /// Returns the first (0) or second (1) method that is shown; `None` before it was rendered.
    pub fn shown(&self, index: usize) -> Option<&ShownMethod> {
        self.shown[index].as_ref()
    }

    /// Returns the stage, the two pictures, and the meaning of the first one's numbers. If only one picture is shown,
    /// it is returned twice. `None` before the first frame.
    pub fn parts(&mut self) -> Option<(&mut Stage, [&Image; 2], Content)> {
        let Self { stage, shown: [first, second], shown_request, .. } = self;
        let first = first.as_ref()?;
        let has_two = shown_request.as_ref().is_some_and(|request| request.sides.len() > 1);
        let second = second.as_ref().filter(|_| has_two).unwrap_or(first);
        Some((stage, [first.kept.image(), second.kept.image()], first.content))
    }

    /// Renders a frame of each method of a request, and keeps the pictures.
    pub fn render(&mut self, request: &FrameRequest) -> Result<()> {
        let materials_changed = self.materials != request.materials;
        self.shown_request = None;
        if self.captures != request.captures {
            // The methods keep images whose number and size follow from the captures.
            self.discard_pipelines();
            self.stage.set_captures(request.captures.clone().unwrap_or_else(|| self.scene_captures.clone()));
            self.captures.clone_from(&request.captures);
        }
        if request.sides.len() < 2 {
            self.shown[1] = None;
        }
        for (i, side) in request.sides.iter().enumerate() {
            let fits = |s: &ShownMethod| s.side == *side && s.kept.image().extent() == request.extent;
            if !self.shown[i].as_ref().is_some_and(fits) {
                // The old images are freed before the new ones are allocated.
                let history = self.shown[i].take().map(|s| s.history).unwrap_or_default();
                self.shown[i] = Some(ShownMethod {
                    shot: self.make_shot(side, Wants::REFLECTION, request)?,
                    side: side.clone(),
                    kept: KeepPass::new(self.stage.context.gpu(), request.extent)?,
                    content: Content::Color,
                    history,
                    images: Vec::new(),
                    lens: None,
                    kept_cube: None,
                });
                if let Some(shown) = &mut self.shown[i] {
                    shown.history.clear();
                }
            } else if let (true, Some(shown)) = (materials_changed, &mut self.shown[i]) {
                shown.shot.set_materials(&mut self.stage, request.materials.clone())?;
                shown.kept_cube = None;
            }
            if let Some(shown) = &mut self.shown[i] {
                shown.render(&mut self.stage, request)?;
            }
        }
        if materials_changed {
            self.shot_with_hits = None;
            self.materials.clone_from(&request.materials);
        }
        // A request that is repeated brings the histories a frame further; another one begins them anew.
        self.frames_to_settle = if self.last_request.as_ref() == Some(request) {
            self.frames_to_settle.saturating_sub(1)
        } else {
            let further_frames = |shown: &ShownMethod| shown.shot.frames_at_rest() - 1;
            self.shown.iter().flatten().map(further_frames).max().unwrap_or_default()
        };
        self.shown_request = Some(request.clone());
        self.last_request = Some(request.clone());
        Ok(())
    }

    /// Renders the last frame again, with counters, and reads it back. Returns the reflections of each method, and the
    /// counted work, ray ends and steps of the first.
    pub fn analyse(&mut self) -> Result<FrameAnalysis> {
        let Some(request) = self.shown_request.clone() else { return Ok(FrameAnalysis::default()) };
        let mut analysis = FrameAnalysis::default();
        let (mut hits, mut recorded) = (None, Vec::new());
        for (i, shown) in self.shown.iter().flatten().enumerate() {
            let (report, _, output) = self.stage.output_in(Mode::Counted, &shown.shot)?;
            let reflection = gbuffer::reflection(&mut self.stage.context, &output)?;
            analysis.reflections.push(reflection.texels().map(|t| [t[0], t[1], t[2]]).collect());
            if i == 0 {
                analysis.work = labelled_work(&report);
                recorded.clone_from(&report.recorded);
                let composite = self.stage.context.read(output.composite.level(0))?;
                analysis.reflection_and_composite = Some([reflection, composite]);
                hits = output.traced.hits.map(|h| self.stage.context.read(h.0.all())).transpose()?;
            }
        }
        let Some(first) = &self.shown[0] else { return Ok(analysis) };
        // A method that did not write the ends of its rays is rendered once more to get them, if it runs at full
        // resolution.
        if hits.is_none() && first.side.setup.effect().divisor() == 1 {
            hits = self.render_hits(&request)?;
        }
        let Some(first) = &self.shown[0] else { return Ok(analysis) };
        let gbuffer = gbuffer::read(&mut self.stage.context, &first.shot)?;
        let inspection = Inspection::new(gbuffer, hits, (first.side.method, &first.side.setup), &recorded);
        analysis.steps = inspection.steps();
        analysis.inspection = Some(inspection);
        if let (Some(steps), true) = (&analysis.steps, request.inside.as_ref().is_some_and(|i| i.name == STEPS)) {
            self.show_steps(request.extent, steps)?;
        }
        Ok(analysis)
    }

    /// Renders the first method with the ends of its rays, and returns these; `None` if the method does not write them.
    fn render_hits(&mut self, request: &FrameRequest) -> Result<Option<Pixels>> {
        let side = &request.sides[0];
        // Whether a shot that was made before has the same method and size.
        let fits = |(shot_side, shot): &(Side, Shot)| {
            shot_side == side && shot.gbuffer.gbuffer().depth.extent() == request.extent
        };
        if !self.shot_with_hits.as_ref().is_some_and(fits) {
            self.shot_with_hits = None;
            let shot = self.make_shot(side, Wants::HITS, request)?;
            self.shot_with_hits = Some((side.clone(), shot));
        }
        let Some((_, shot)) = &mut self.shot_with_hits else { return Ok(None) };
        shot.camera = request.camera;
        let (_, _, output) = self.stage.output(shot)?;
        Ok(output.traced.hits.map(|h| self.stage.context.read(h.0.all())).transpose()?)
    }

    /// Replaces the first picture by the number of steps of each pixel's ray.
    fn show_steps(&mut self, extent: [u32; 2], steps: &[u32]) -> Result<()> {
        let texels: Vec<[f32; 4]> = steps.iter().map(|n| [*n as f32, 0.0, 0.0, 1.0]).collect();
        let image = Image::from_texels(&mut self.stage.context, "steps", extent, &texels)?;
        let Some(shown) = &mut self.shown[0] else { return Ok(()) };
        (shown.content, shown.kept_cube) = (Content::Steps, None);
        Ok(self.stage.context.once(|frame| shown.kept.record(frame, image.all()))?)
    }

    /// Makes a method with its pipelines and images for a request; `wants` says which outputs it writes.
    fn make_shot(&mut self, side: &Side, wants: Wants, request: &FrameRequest) -> Result<Shot> {
        let setup = side.setup.with_extent(request.extent);
        Ok(Shot::new(&mut self.stage, side.method, &setup, wants, request.camera, request.materials.clone())?)
    }
}

impl ShownMethod {
    /// Renders a frame of the method, and keeps the picture that the request asks for.
    fn render(&mut self, stage: &mut Stage, request: &FrameRequest) -> Result<()> {
        self.shot.camera = request.camera;
        let (report, _, output) = stage.output_in(Mode::Timed, &self.shot)?;
        self.history.add(&report, Instant::now());
        // A cube map cannot be shown as a plane image.
        let mut images = image::intermediates(&self.shot, &output);
        images.extend(output.traced.reflection.map(|r| Intermediate {
            name: "reflection",
            content: Content::Color,
            image: r.0,
        }));
        // The levels of a pyramid lie in strips, which show nothing as a picture.
        images.retain(|i| !matches!(i.content, Content::Pyramid(_)));
        images.retain(|i| i.image.layers() == 1);
        // The intermediate that the request asks for, with its content; a level beyond the last one means the last one.
        let inside = request.inside.as_ref().and_then(|inside| {
            let image = images.iter().find(|i| i.name == inside.name)?;
            let parts = image.image.parts();
            parts.get(inside.level as usize).or(parts.last()).map(|part| (image.content, *part))
        });
        let (content, slice) = match inside {
            Some(content_and_slice) => content_and_slice,
            None => (Content::Color, output.composite.level(0)),
        };
        let info = |i: &Intermediate| ImageInfo {
            name: i.name.to_owned(),
            levels: i.image.parts().len() as u32,
            extent: i.image.extent(),
        };
        self.images = images.iter().map(info).collect();
        let captures = self.shot.captures().map(|(images, _)| images);
        self.images.extend(captures.iter().flat_map(|captures| {
            CubeImage::all(captures.places.len()).map(move |cube| ImageInfo {
                name: cube.name(),
                levels: cube.levels(captures),
                extent: captures.color.extent(),
            })
        }));
        let cube = request.inside.as_ref().and_then(|i| Some((CubeImage::find(&i.name)?, i.level)));
        let Some(((cube, level), captures)) =
            cube.zip(captures).filter(|((cube, _), captures)| cube.capture < captures.places.len())
        else {
            (self.content, self.lens, self.kept_cube) = (content, None, None);
            stage.context.once(|frame| self.kept.record(frame, slice))?;
            return Ok(());
        };
        // The picture is a capture's. It is made anew only if it changed or another one was kept.
        let effect = self.side.setup.effect();
        let is_renewed = effect.captures == CaptureCount::Camera || effect.captures_per_frame > 0;
        if is_renewed || self.kept_cube != Some((cube, level)) {
            let texels = cube.read(&mut stage.context, &captures, level, request.extent)?;
            let image = Image::from_texels(&mut stage.context, "capture", request.extent, &texels)?;
            stage.context.once(|frame| self.kept.record(frame, image.all()))?;
        }
        let near_m = self.captures().iter().map(|c| c.near_m).fold(f32::INFINITY, f32::min);
        (self.content, self.kept_cube) = (cube.content(), Some((cube, level)));
        self.lens = Some(face_camera(Vec3::ZERO, 0, near_m).lens);
        Ok(())
    }

    /// Returns the captures in which the method's rays go on; empty if the method takes no captures.
    pub fn captures(&self) -> Vec<Capture> {
        self.shot.captures().map_or(Vec::new(), |(_, places)| places)
    }
}

/// Returns the label and the counted work of each pass.
fn labelled_work(report: &FrameReport) -> Vec<(String, PassWork)> {
    report.recorded.iter().cloned().zip(report.work.iter().copied()).collect()
}

impl State {
    /// Returns the request for the frame that the state asks for, in a scene and at a size in pixels.
    pub fn frame_request(&self, scene: &Scene, extent: [u32; 2]) -> FrameRequest {
        let lens = self.view.lens.unwrap_or(scene.lens);
        FrameRequest {
            camera: self.camera.camera(lens, extent[0] as f32 / extent[1] as f32),
            materials: self.globals.materials(scene, &self.view),
            extent,
            sides: self.rendered().to_vec(),
            inside: self.inside.clone(),
            captures: None,
        }
    }
}
