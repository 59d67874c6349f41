//! The whole effect: a method, and the passes around every method, down to the composite.

use super::beyond::{CaptureSet, PreparedTriangles, captures_for, triangles_for};
use super::capture::{CaptureImages, Renewal, captured_materials};
use super::exclusions::{self, EffectRequest, GivenPart};
use super::layers::{LayerParams, SecondLayer};
use super::setup::{CaptureCount, HistoryUse};
use super::{Input, Method, MethodInfo, MethodOutput, MethodRequest, SceneInput, Setup, Wants};
use crate::error::{Error, Result};
use crate::gpu::{Frame, FrameContext, Gpu, Image};
use crate::passes::bump::BumpPass;
use crate::passes::composite::CompositePass;
use crate::passes::fallback::FallbackPass;
use crate::passes::history::HistoryPass;
use crate::passes::resolution::{self, DownsamplePass, UpsamplePass};
use crate::passes::scene_data::{DrawingCost, SceneData};
use crate::passes::trace_normals::{TraceNormals, TraceNormalsPass};
use crate::passes::triangle_scene::TriangleReading;
use crate::passes::{Captures, GBuffer};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use ssct_ground::scene::{Capture, ProjectionKind};

/// Faces of the capture at the camera, all of which each frame draws.
const FACES_OF_A_CUBE: u32 = 6;

/// The images that an effect made in a frame.
#[derive(Clone)]
pub struct Output<'a> {
    /// The method's intermediates and hits, and the reflection that was composited.
    pub traced: MethodOutput<'a>,
    /// The finished image, linear; the lit colour alone if no composite was wanted or nothing reflects.
    pub composite: &'a Image,
}

/// A method for images of one size, on one device, with the passes around it.
pub struct Effect {
    method: Box<dyn Method>,
    projection: ProjectionKind,
    /// Makes other normals for the rays; the bump displaces the reflections afterwards.
    trace_normals: Option<(TraceNormalsPass, Option<BumpPass>)>,
    /// Draws the second layer of depth, for a method that marches through two layers.
    second_layer: Option<SecondLayer>,
    /// Scale the G-buffer down and the reflection up, for a method that traces at a lower resolution.
    scaling: Option<(DownsamplePass, UpsamplePass)>,
    fallback: Option<(Box<dyn Method>, FallbackPass)>,
    history: Option<HistoryPass>,
    /// The number of bounces, and the pass that makes the image that the next bounce reflects; `None` for one bounce.
    bounces: Option<(u32, CompositePass)>,
    /// Makes the finished image; `None` if it is not wanted, or if the history makes it.
    composite: Option<CompositePass>,
    captures: Option<CaptureSet>,
    triangles: Option<PreparedTriangles>,
    prepared: Prepared,
}

/// The cost of what a method needs of its scene once, outside of any frame: captures, cube maps, skies, triangles. What
/// several methods share counts in full for each of them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Prepared {
    /// Milliseconds on the host until the device was done, with the search for places of captures.
    pub time_ms: f64,
    /// Bytes of device memory that all of this takes, without the images that every frame draws anew.
    pub device_bytes: u64,
    /// The places of the captures in which rays go on: x, y and z in world axes, in metres.
    pub captures: Vec<[f32; 3]>,
    /// Milliseconds, among those of `time_ms`, in which the device built the structure for ray queries; `None` without ray queries.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ray_structure_ms: Option<f64>,
}

impl Effect {
    /// Makes the method and the passes around it. A method that sees the screen alone needs no `scene`.
    ///
    /// # Errors
    /// [`Error::Usage`] for a request in [`EXCLUSIONS`](exclusions::EXCLUSIONS), or without a scene that is needed.
    pub fn new(
        context: &mut FrameContext,
        info: &MethodInfo,
        setup: &Setup,
        wants: Wants,
        scene: Option<&SceneInput>,
    ) -> Result<Self> {
        let effect = setup.effect();
        let (places, placement_ms) = captures_for(info, &effect, scene)?;
        let has_triangles = effect.is_among_triangles(info, scene.is_some());
        exclusions::check(&EffectRequest {
            info,
            setup,
            effect,
            has_scene: scene.is_some(),
            has_captures: !places.is_empty(),
            has_triangles,
            given_part: None,
        })?;
        let follows_camera = effect.captures_wanted() == CaptureCount::Camera && !places.is_empty();
        let faces = if follows_camera { FACES_OF_A_CUBE } else { effect.captures_per_frame };
        let is_renewed = faces > 0 && !places.is_empty();
        let renewal = is_renewed.then(|| Renewal::new(context.gpu(), &places, faces)).transpose()?;
        let face = places.first().map_or([1; 2], |c| [c.resolution; 2]);
        let captures = (!places.is_empty()).then(|| {
            let (images, materials) = (None, Vec::new());
            CaptureSet { places, face, images, materials, renewal, follows_camera }
        });
        let triangles = triangles_for(context, info, &effect, scene)?;
        let mut made = Self::with_parts(context, info, setup, wants, (captures, triangles))?;
        let Some(scene) = scene else { return Ok(made) };
        let (shared_captures, own) = DrawingCost::measure(context, |context| made.prepare_at_cost(context, scene))?;
        let of_triangles = triangles.iter().flat_map(|reading| scene.data.triangle_costs(reading.queries));
        let costs: Vec<_> = of_triangles.chain([own, shared_captures]).collect();
        made.prepared = Prepared {
            time_ms: placement_ms + costs.iter().map(|cost| cost.time_ms).sum::<f64>(),
            device_bytes: costs.iter().map(|cost| cost.device_bytes).sum(),
            captures: if follows_camera { Vec::new() } else { made.places().map(|c| c.position.to_array()).collect() },
            ray_structure_ms: triangles
                .filter(|reading| reading.queries)
                .and_then(|_| Some(scene.data.ray_structure()?.build_ms())),
        };
        Ok(made)
    }

    /// Makes the method and the passes around it for a G-buffer without its scene, and for given captures.
    ///
    /// # Errors
    /// [`Error::Usage`] for a request in [`EXCLUSIONS`](exclusions::EXCLUSIONS).
    pub fn with_captures(
        context: &mut FrameContext,
        info: &MethodInfo,
        setup: &Setup,
        wants: Wants,
        captures: CaptureImages,
    ) -> Result<Self> {
        exclusions::check(&EffectRequest::beside_gbuffer(info, setup, GivenPart::Captures))?;
        let captures = CaptureSet::from_caller(captures.extent(), Some(captures));
        Self::with_parts(context, info, setup, wants, (Some(captures), None))
    }

    /// Makes the method and the passes around it for captures that each input gives ([`Input::captures`]). `face` is
    /// the width and height of their faces in texels.
    ///
    /// # Errors
    /// Errors of [`Self::with_captures`].
    pub fn for_captures(
        context: &mut FrameContext,
        info: &MethodInfo,
        setup: &Setup,
        wants: Wants,
        face: [u32; 2],
    ) -> Result<Self> {
        exclusions::check(&EffectRequest::beside_gbuffer(info, setup, GivenPart::Captures))?;
        Self::with_parts(context, info, setup, wants, (Some(CaptureSet::from_caller(face, None)), None))
    }

    /// Makes the method and the passes around it for a G-buffer without its scene, and for triangles that each input
    /// gives ([`Input::triangles`]). `reading` says how shaders read the triangles.
    ///
    /// # Errors
    /// [`Error::Usage`] for a request in [`EXCLUSIONS`](exclusions::EXCLUSIONS).
    pub fn for_triangles(
        context: &mut FrameContext,
        info: &MethodInfo,
        setup: &Setup,
        wants: Wants,
        reading: TriangleReading,
    ) -> Result<Self> {
        exclusions::check(&EffectRequest::beside_gbuffer(info, setup, GivenPart::Triangles))?;
        Self::with_parts(context, info, setup, wants, (None, Some(reading)))
    }

    /// Makes the method and the passes around it, after all checks, for captures or triangles of any origin.
    fn with_parts(
        context: &mut FrameContext,
        info: &MethodInfo,
        setup: &Setup,
        wants: Wants,
        (captures, triangles): (Option<CaptureSet>, Option<TriangleReading>),
    ) -> Result<Self> {
        let effect = setup.effect();
        let Setup { extent, projection, .. } = *setup;
        let (divisor, stage) = (effect.divisor(), setup.stage());
        let other_normals = effect.trace_normals != TraceNormals::Shading;
        let is_bumped = effect.bump_after > 0.0;
        let gpu: Gpu = context.gpu_of_effect();
        let face = captures.as_ref().map(|c| c.face);
        let fallback = effect.fallback.method().map(|method| -> Result<_> {
            let wants = Wants { reflection: true, ..Wants::default() };
            let request = MethodRequest { captures: face, is_fallback: true, ..MethodRequest::new(setup, wants) };
            Ok((method.make(&gpu, &request)?, FallbackPass::new(&gpu, stage, extent)?))
        });
        let history = effect.history == HistoryUse::On && info.is_screen_space();
        let bounces = (effect.bounces > 1)
            .then(|| Ok::<_, Error>((effect.bounces, CompositePass::for_bounces(&gpu, stage, extent)?)))
            .transpose()?;
        // The method may composite along the way if no pass changes its reflection afterwards.
        let is_changed_later = fallback.is_some() || divisor != 1 || history || is_bumped || bounces.is_some();
        let composite = wants.composite && !is_changed_later;
        let mut scaling = None;
        // Hits of a lower resolution cannot be compared with hits of the full size.
        let hits = wants.hits && divisor == 1;
        let method_wants = Wants { hits, reflection: wants.reflection || !composite, composite };
        let mut request = MethodRequest { captures: face, triangles, ..MethodRequest::new(setup, method_wants) };
        if divisor != 1 {
            request.setup.extent = resolution::divided(extent, divisor);
            let downsample = DownsamplePass::new(&gpu, stage, extent, divisor)?;
            let is_numbered = triangles.is_some() && gpu.numbers_triangles();
            let downsample = if is_numbered { downsample.numbered(&gpu, stage)? } else { downsample };
            scaling = Some((downsample, UpsamplePass::new(&gpu, stage, extent, projection, divisor)?));
        }
        let effect = Self {
            method: info.make(&gpu, &request)?,
            projection,
            trace_normals: other_normals
                .then(|| -> Result<_> {
                    let bump = is_bumped.then(|| BumpPass::new(&gpu, stage, extent, effect.bump_after)).transpose()?;
                    Ok((TraceNormalsPass::new(&gpu, stage, extent, projection, effect.trace_normals)?, bump))
                })
                .transpose()?,
            second_layer: info
                .takes_second_layer(setup)
                .then(|| SecondLayer::new(&gpu, stage, extent, divisor, setup.parameters::<LayerParams>()))
                .transpose()?,
            scaling,
            fallback: fallback.transpose()?,
            history: history
                .then(|| {
                    let averaged = (effect.history_frames, effect.history_deviations);
                    let stage = effect.history_stage.on(&gpu, effect.stage);
                    HistoryPass::new(context.gpu(), (extent, projection), averaged, stage, wants.composite)
                })
                .transpose()?,
            bounces,
            composite: (wants.composite && !history).then(|| CompositePass::new(&gpu, stage, extent)).transpose()?,
            captures,
            triangles: triangles.map(|reading| PreparedTriangles { reading, table: None }),
            prepared: Prepared::default(),
        };
        Ok(effect)
    }

    /// Makes the images that outlive frames: those that are missing, and those that changed materials make invalid.
    pub fn prepare(&mut self, context: &mut FrameContext, scene: &SceneInput) -> Result<()> {
        self.prepare_at_cost(context, scene).map(drop)
    }

    /// Makes the images that outlive frames. Returns the cost of the images that another effect drew before, which [`Prepared`]
    /// counts as if this effect had drawn them.
    fn prepare_at_cost(&mut self, context: &mut FrameContext, scene: &SceneInput) -> Result<DrawingCost> {
        let mut cost = DrawingCost::default();
        if let Some(captured) = &mut self.captures {
            let materials = captured_materials(scene.materials);
            if captured.follows_camera {
                if captured.images.is_none() {
                    captured.images = Some(CaptureImages::undrawn(context.gpu(), &captured.places)?);
                }
            } else if captured.images.is_none() || captured.materials != materials {
                let images = match captured.renewal {
                    Some(_) => CaptureImages::new(context, scene, &captured.places)?,
                    None => {
                        let (images, earlier) = CaptureImages::shared(context, scene, &captured.places)?;
                        cost = earlier;
                        images
                    }
                };
                captured.images = Some(images);
                captured.materials = materials;
            }
        }
        if let Some(triangles) = &mut self.triangles {
            scene.data.prepare_triangles(context, triangles.reading.queries)?;
            let images = scene.data.triangles().map(|(_, images)| images);
            triangles.table = images.map(|images| images.table(context, scene.materials)).transpose()?;
        }
        if let Some((method, _)) = &mut self.fallback {
            method.prepare(context, scene)?;
        }
        self.method.prepare(context, scene)?;
        Ok(cost)
    }

    /// Makes the triangles of a scene ready for a frame, where its meshes stand now, if rays are traced among them.
    ///
    /// # Errors
    /// Errors of [`SceneData::prepare_triangles`].
    pub fn prepare_triangles(&self, context: &mut FrameContext, data: &SceneData) -> Result<()> {
        let Some(triangles) = &self.triangles else { return Ok(()) };
        data.prepare_triangles(context, triangles.reading.queries).map(drop)
    }

    /// Whether the G-buffer should say which triangle each pixel shows.
    pub fn wants_triangles(&self) -> bool {
        self.triangles.is_some()
    }

    /// Returns the number of frames for an image of a camera at rest: as many as a history averages, or one without it.
    pub fn frames_at_rest(&self) -> u32 {
        self.history.as_ref().map_or(1, HistoryPass::averaged)
    }

    /// Forgets the frames that the history averages, so that the next frame is the first.
    pub fn restart_history(&self) {
        self.history.iter().for_each(HistoryPass::restart);
    }

    /// Returns time and memory of the images that were made before the first frame, and the places of captures.
    pub fn prepared(&self) -> &Prepared {
        &self.prepared
    }

    /// Returns the captures in which rays go on, once they are made, and where they stand. A capture at the camera
    /// stands where the camera was when the last frame was recorded.
    pub fn captures(&self) -> Option<(Captures<'_>, Vec<Capture>)> {
        let images = self.captures.as_ref()?.images.as_ref()?.captures();
        Some((images, self.places().collect()))
    }

    /// Returns the captures with the places where they stand now; none before their images are made.
    fn places(&self) -> impl Iterator<Item = Capture> {
        let mut placed = Vec::new();
        if let Some(CaptureSet { places, images: Some(images), .. }) = &self.captures {
            let pairs = places.iter().zip(images.captures().places);
            placed.extend(pairs.map(|(capture, place)| Capture { position: place.get(), ..*capture }));
        }
        placed.into_iter()
    }

    /// Returns the number of faces of the captures in which rays go on; 0 without captures.
    pub fn capture_faces(&self) -> u32 {
        let images = self.captures.as_ref().and_then(|c| c.images.as_ref());
        images.map_or(0, CaptureImages::faces)
    }

    /// Moves the n-th capture to the n-th place, and draws the scene around it. Spare places are ignored. Captures
    /// without a place stay, and so does the capture at the camera. The call is not part of any frame's time.
    pub fn move_captures(&mut self, context: &mut FrameContext, scene: &SceneInput, places: &[Vec3]) -> Result<()> {
        let Some(captured) = self.captures.as_mut().filter(|c| !c.follows_camera) else { return Ok(()) };
        for (capture, place) in captured.places.iter_mut().zip(places) {
            capture.position = *place;
        }
        let Some(images) = &mut captured.images else { return self.prepare(context, scene) };
        // Images that other effects may look into stay as they are, and this effect gets its own.
        if images.is_shared() {
            *images = CaptureImages::undrawn(context.gpu(), &captured.places)?;
        }
        // The passes that draw captures are kept, since a caller that moves captures once most likely does so again.
        let renewal = match &mut captured.renewal {
            Some(renewal) => renewal,
            empty => empty.insert(Renewal::new(context.gpu(), &captured.places, 0)?),
        };
        let places: Vec<Vec3> = captured.places.iter().map(|c| c.position).collect();
        renewal.move_to(context, scene, images, &places)?;
        captured.materials = captured_materials(scene.materials);
        Ok(())
    }

    /// Records every pass after lighting. The first passes draw captures anew, if each frame does so, or the capture at
    /// the camera.
    ///
    /// # Errors
    /// [`Error::Usage`] if the input has no scene, but the method needs one or captures are drawn anew; and for a
    /// camera of another projection than the setup's.
    pub fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<Output<'a>> {
        input.camera.check_kind(self.projection)?;
        let images = self.captures.as_ref().and_then(|c| c.images.as_ref());
        if let (Some(CaptureSet { renewal: Some(renewal), follows_camera, .. }), Some(images)) =
            (&self.captures, images)
        {
            let scene = input.scene()?;
            if *follows_camera {
                images.place_at(0, input.camera.eye());
            }
            renewal.record(frame, &scene, images)?;
        }
        let captures = images.map(CaptureImages::captures).or(input.captures);
        let shading = input.gbuffer;
        let gbuffer = match &self.trace_normals {
            None => shading,
            Some((pass, _)) => pass.record(frame, shading, input.camera)?,
        };
        let objects = || input.scene.map_or(Vec::new(), |scene| scene.data.movable_objects());
        let begin = |history: &HistoryPass| history.begin(input.camera, objects(), input.motion.is_some());
        let turns = self.history.as_ref().map(begin).unwrap_or_default();
        let second_layer = match &self.second_layer {
            Some(layer) => Some(layer.record(frame, input.scene()?, &shading, input.camera)?),
            None => None,
        };
        let triangles = match (&self.triangles, input.triangles) {
            (Some(prepared), None) => {
                let data = input.scene()?.data;
                data.copy_moving(frame)?;
                Some(prepared.buffers(data)?)
            }
            (_, given) => given,
        };
        let (frame_number, frames_at_rest) = (turns.total, turns.at_rest);
        let mut input =
            Input { captures, triangles, gbuffer, second_layer, frame: frame_number, frames_at_rest, ..*input };
        let mut traced = self.reflect(frame, &input, &shading)?;
        for bounce in 1..self.bounces.as_ref().map_or(1, |(bounces, _)| *bounces) {
            let (Some(reflection), Some((_, pass))) = (traced.reflection, &self.bounces) else { break };
            // The image that the next bounce reflects is the lit colour without reflections, plus this reflection.
            let color = pass.record(frame, &gbuffer, reflection)?;
            frame.set_prefix(Some(&format!("bounce {}", bounce + 1)));
            input = Input { bounce, gbuffer: GBuffer { color, ..gbuffer }, ..input };
            traced = self.reflect(frame, &input, &shading)?;
        }
        if let (Some(history), Some(reflection)) = (&self.history, traced.reflection) {
            // Ends of rays at a lower resolution have other pixels than the history, and are not used.
            let ends = traced.ends.filter(|_| self.scaling.is_none());
            let (averaged, composite) =
                history.record(frame, &gbuffer, input.camera, reflection, (ends, input.motion))?;
            traced = MethodOutput { reflection: Some(averaged), composite, ..traced };
        }
        let composite = match (traced.composite, traced.reflection, &self.composite) {
            (Some(made), ..) => made,
            (None, Some(reflection), Some(pass)) => pass.record(frame, &gbuffer, reflection)?,
            _ => gbuffer.color,
        };
        frame.set_prefix(None);
        Ok(Output { traced, composite })
    }

    /// Records one bounce: the passes of the method, then those that scale its reflection up, displace it, and add the
    /// fallback. `shading` has the shading normals, and `input.gbuffer` the normals that rays are reflected at.
    fn reflect<'a>(
        &'a self,
        frame: &mut Frame,
        input: &Input<'a, '_>,
        shading: &GBuffer<'a>,
    ) -> Result<MethodOutput<'a>> {
        let mut traced = match &self.scaling {
            None => self.method.record(frame, input)?,
            Some((downsample, upsample)) => {
                let gbuffer = downsample.record(frame, &input.gbuffer)?;
                let small = self.method.record(frame, &Input { gbuffer, ..*input })?;
                let reflection =
                    small.reflection.map(|r| upsample.record(frame, &input.gbuffer, input.camera, r)).transpose()?;
                MethodOutput { reflection, composite: None, hits: None, ..small }
            }
        };
        if let (Some((_, Some(bump))), Some(reflection)) = (&self.trace_normals, traced.reflection) {
            traced.reflection = Some(bump.record(frame, shading, &input.gbuffer, reflection)?);
            traced.composite = None;
        }
        if let (Some((method, pass)), Some(reflection)) = (&self.fallback, traced.reflection) {
            let fallback = method.record(frame, &Input { in_front: Some(reflection), ..*input })?;
            if let Some(fallback_reflection) = fallback.reflection {
                traced.reflection = Some(pass.record(frame, reflection, fallback_reflection)?);
                traced.composite = None;
            }
            traced.intermediates.extend(fallback.intermediates);
        }
        Ok(traced)
    }
}
