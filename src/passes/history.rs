//! Temporal filtering (thesis §4.2.11): finds each pixel's reflection in earlier frames, and averages over frames.

use super::scene_data::MovableObject;
use super::{GBuffer, LIT_COLOR, Reflection, stored_target};
use crate::error::Result;
use crate::gpu::programs::{History, HistoryConstants};
use crate::gpu::shader::{HistoryBlock, MoverData};
use crate::gpu::{Frame, Gpu, Image, PixelPipeline, Sampled, ShaderStage, Target};
use crate::passes::lost::{ENDS, view_unit_m};
use ash::vk;
use glam::{DMat4, Vec2, Vec4Swizzles};
use ssct_ground::math::constants::{BEYOND, MOST_MOVERS, NO_TRIANGLE};
use ssct_ground::scene::{Camera, Projection, ProjectionKind};
use std::cell::{Cell, OnceCell, RefCell};

/// Format of the guide of the search: `Guide` of `shaders-glsl/history/guide.glsl`, packed.
const GUIDE: vk::Format = vk::Format::R32G32B32A32_UINT;

/// The most frames that are averaged at rest.
const MOST_AT_REST: f32 = 128.0;

/// Pipelines, and the images of two frames of one size.
pub struct HistoryPass {
    gpu: Gpu,
    variant: Variant,
    /// The program for a frame in which nothing has moved, so that each pixel's history lies in the same pixel.
    at_rest: Pipeline,
    /// The programs for other frames, by [`HistorySearch::index`]. The one for a moving camera alone is made at once,
    /// the others when a frame first needs them.
    searching: [OnceCell<Pipeline>; 4],
    history_images: [HistoryImages; 2],
    composite: Option<Image>,
    /// An image of one texel, bound if the method does not know the ends of rays.
    no_ends: Image,
    /// An image of one texel, `NO_TRIANGLE`, bound if the G-buffer has no triangle numbers.
    no_triangle: Image,
    last_frames: RefCell<LastFrames>,
    /// The number of recorded frames, which write the two history images in turn.
    frames: Cell<u32>,
    /// The most frames that are averaged.
    averaged: u32,
    /// How many standard deviations a history may lie from the mean around its pixel.
    deviations: f32,
}

/// The history's program in the chosen stage. The program makes the same images in both stages.
type Pipeline = PixelPipeline<History<'static>>;

/// The variant of the history's program.
#[derive(Clone, Copy)]
struct Variant {
    stage: ShaderStage,
    is_orthographic: bool,
    composite: bool,
}

/// What may have moved since the frame before, apart from the camera.
#[derive(Clone, Copy, Default)]
struct HistorySearch {
    /// Whether objects of the scene moved.
    movers: bool,
    /// Whether the caller gives the motion of surfaces.
    motion: bool,
}

impl HistorySearch {
    /// Returns the index of the program for this case, 0 to 3.
    fn index(self) -> usize {
        usize::from(self.movers) | usize::from(self.motion) << 1
    }
}

/// The motion of the surfaces that pixels show since the frame before, as the caller knows it.
#[derive(Clone, Copy)]
pub struct SurfaceMotion<'a> {
    /// The vectors, in red and green, from where a surface is seen on the screen to where it was seen.
    pub image: &'a Image,
    /// Factors from the image's values to pixels, x to the right and y down.
    pub scale: [f32; 2],
    /// Whether the motion includes the change of the projection's shift (jitter) between the two frames.
    pub shifted: bool,
}

/// The images of a frame that the next frame reads.
struct HistoryImages {
    reflection: Image,
    guide: Image,
}

/// Camera and objects of the frame that began last, and how they differ from those of the frame before.
#[derive(Default)]
struct LastFrames {
    camera: Option<Camera>,
    objects: Vec<MovableObject>,
    /// Whether an object moved.
    has_movers: bool,
    turns: Turns,
    movers: Vec<Mover>,
    camera_change: CameraChange,
    /// Whether camera and turns are those of the frame before.
    is_repetition: bool,
    camera_before: Option<Camera>,
}

/// An object that moved since the frame before.
struct Mover {
    /// The number of the object's first triangle, and that after its last one.
    triangles: [u32; 2],
    /// The matrix from where the object stands now to where it stood, in the world.
    back: DMat4,
}

/// Counts of frames that decide in which directions of their lobes the rays of a frame leave.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Turns {
    /// Number of frames with other directions before this one since the history began. The number stops growing once
    /// the picture has been at rest for as many frames as are averaged.
    pub total: u32,
    /// Number of frames with other directions since the camera last moved; 0 while the camera moves.
    pub at_rest: u32,
    /// Number of frames with other directions that are still to come if nothing moves.
    remaining: u32,
}

impl Turns {
    /// Returns the turns of the next frame, if at most `averaged` frames are averaged. `has_stopped` says whether the
    /// last moving object came to rest.
    fn next(self, change: CameraChange, has_stopped: bool, averaged: u32) -> Self {
        let Self { total, at_rest, remaining } = self;
        let starts_again = change != CameraChange::None || has_stopped;
        let remaining = if starts_again { averaged.saturating_sub(1) } else { remaining };
        let turned = Self { total: total.wrapping_add(1), at_rest: at_rest.wrapping_add(1), remaining };
        match (change, remaining) {
            (CameraChange::Moves, _) => Self { at_rest: 0, ..turned },
            (_, 0) => self, // all directions have been averaged
            // Under a jittered camera no frame repeats the one before, so that the directions never stop changing.
            (CameraChange::Shifts, _) => turned,
            (CameraChange::None, _) => Self { remaining: remaining - 1, ..turned },
        }
    }
}

/// How a camera differs from that of the frame before.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
enum CameraChange {
    None,
    /// Nothing differs except the shift of the projection, as in jittered cameras.
    Shifts,
    #[default]
    Moves,
}

impl CameraChange {
    /// Compares the cameras of two frames. Only the shift of the projection may differ for [`Self::Shifts`].
    fn between(before: &Camera, now: &Camera) -> Self {
        let unshifted = |camera: &Camera| Projection { shift: [0.0; 2], ..camera.projection_numbers() };
        let is_seen_alike = before.world_to_view == now.world_to_view && before.near_plane == now.near_plane;
        match before == now {
            true => Self::None,
            false if is_seen_alike && unshifted(before) == unshifted(now) => Self::Shifts,
            false => Self::Moves,
        }
    }
}

impl LastFrames {
    /// Returns what may have moved, so that histories must be searched for; `None` in the first frame and if nothing
    /// moved. `motion` says whether the caller gives the motion of surfaces.
    fn search(&self, motion: bool) -> Option<HistorySearch> {
        let movers = !self.movers.is_empty();
        let may_have_moved = self.camera_change == CameraChange::Moves || motion || movers;
        (self.camera_before.is_some() && may_have_moved).then_some(HistorySearch { movers, motion })
    }
}

impl HistoryPass {
    /// Makes the pass for a size in pixels and a projection. At most `averaged` frames are averaged. A history may lie
    /// `deviations` standard deviations from the mean of the reflections around its pixel. With `composite` the pass
    /// also makes the finished image.
    pub fn new(
        gpu: &Gpu,
        (extent, kind): ([u32; 2], ProjectionKind),
        (averaged, deviations): (u32, f32),
        stage: ShaderStage,
        composite: bool,
    ) -> Result<Self> {
        let variant = Variant { stage, is_orthographic: kind.is_orthographic(), composite };
        let image = |name, format| Image::target_in(gpu, stage, name, format, extent);
        let make_images = || -> Result<HistoryImages> {
            Ok(HistoryImages { reflection: image("history", LIT_COLOR)?, guide: image("history guide", GUIDE)? })
        };
        let pass = Self {
            gpu: gpu.clone(),
            variant,
            at_rest: compile(gpu, variant, None)?,
            searching: Default::default(),
            history_images: [make_images()?, make_images()?],
            composite: composite.then(|| image("composite", LIT_COLOR)).transpose()?,
            no_ends: stored_target(gpu, "no ends", ENDS, [1, 1])?,
            no_triangle: stored_target(gpu, "no triangle", vk::Format::R32_UINT, [1, 1])?,
            last_frames: RefCell::default(),
            frames: Cell::new(0),
            averaged,
            deviations,
        };
        pass.pipeline_for(HistorySearch::default())?;
        Ok(pass)
    }

    /// Returns the most frames that are averaged.
    pub fn averaged(&self) -> u32 {
        self.averaged
    }

    /// Forgets all frames, so that the next frame is the first.
    pub fn restart(&self) {
        self.frames.set(0);
        self.last_frames.take();
    }

    /// Begins a frame that is seen from a camera, with the objects where they stand now. `may_move` says whether other
    /// objects may move, too. Returns the turns that decide in which directions the frame's rays leave.
    pub fn begin(&self, camera: &Camera, objects: Vec<MovableObject>, may_move: bool) -> Turns {
        let mut last = self.last_frames.borrow_mut();
        last.movers = find_movers(&last.objects, &objects);
        last.camera_before = last.camera.replace(*camera);
        let change = last.camera_before.map(|before| CameraChange::between(&before, camera));
        last.camera_change = change.unwrap_or(CameraChange::Moves);
        let has_movers = may_move || !last.movers.is_empty();
        let turns = match change {
            None => Turns { remaining: self.averaged.saturating_sub(1), ..Turns::default() },
            Some(change) => last.turns.next(change, last.has_movers && !has_movers, self.averaged),
        };
        last.is_repetition = change == Some(CameraChange::None) && turns == last.turns;
        (last.turns, last.has_movers, last.objects) = (turns, has_movers, objects);
        turns
    }

    /// Records pass "history" of the frame that [`Self::begin`] began. Returns the averaged reflection, and the
    /// finished image if the pass makes it. `ends` is the image ([`ENDS`]) of where the rays of each pixel ended, and
    /// `motion` says how surfaces moved; `None` where unknown.
    pub fn record(
        &self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        camera: &Camera,
        reflection: Reflection,
        (ends, motion): (Option<&Image>, Option<SurfaceMotion>),
    ) -> Result<(Reflection<'_>, Option<&Image>)> {
        let last = self.last_frames.borrow();
        let turn = self.frames.get() as usize % 2;
        self.frames.set(self.frames.get().wrapping_add(1));
        let [current, earlier] = [&self.history_images[turn], &self.history_images[1 - turn]];
        if last.camera_before.is_none() {
            // The images of an earlier frame are bound in the first frame, too, but not read.
            frame.clear("history/begin", earlier.reflection.all(), [0.0; 4])?;
            frame.clear("history/begin guide", earlier.guide.all(), [0.0; 4])?;
            frame.clear("history/no triangle", self.no_triangle.all(), [f32::from_bits(NO_TRIANGLE); 4])?;
        }
        let block = HistoryBlock {
            has_ends: i32::from(ends.is_some()),
            ..self.block(camera, &last, gbuffer.depth.extent(), motion)
        };
        let composite = self.composite.as_ref();
        let program = History {
            history: &block,
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            normal_buffer: gbuffer.normal.all(),
            reflection_buffer: reflection.0.all(),
            material_buffer: gbuffer.material.all(),
            color_before: earlier.reflection.all(),
            guide_before: earlier.guide.all(),
            color_buffer: gbuffer.color.level(0),
            // An image that stands for an unknown one is not read.
            ends_image: ends.unwrap_or(&self.no_ends).all(),
            triangle_buffer: gbuffer.triangle.unwrap_or(&self.no_triangle).all(),
            motion_buffer: Sampled::nearest(motion.map_or(gbuffer.depth, |motion| motion.image).all()),
        };
        let targets = [
            Target::overwrite(current.reflection.all()),
            Target::overwrite(current.guide.all()),
            composite.map_or(Target::unwanted(), |image| Target::overwrite(image.all())),
        ];
        let search = last.search(motion.is_some());
        let pipeline = search.map_or(Ok(&self.at_rest), |search| self.pipeline_for(search))?;
        frame.pixels("history", pipeline, targets, &program)?;
        Ok((Reflection(&current.reflection), composite))
    }

    /// Returns the program for a frame in which something may have moved, compiled at the first call.
    fn pipeline_for(&self, search: HistorySearch) -> Result<&Pipeline> {
        let slot = &self.searching[search.index()];
        if let Some(pipeline) = slot.get() {
            return Ok(pipeline);
        }
        let pipeline = compile(&self.gpu, self.variant, Some(search))?;
        Ok(slot.get_or_init(|| pipeline))
    }

    /// Returns the uniform block of a frame: the matrices to the frame before, and what has moved since then.
    fn block(
        &self,
        camera: &Camera,
        last: &LastFrames,
        extent: [u32; 2],
        motion: Option<SurfaceMotion>,
    ) -> HistoryBlock {
        let before = last.camera_before.as_ref().unwrap_or(camera);
        // If only the jitter changed, a pixel keeps its own history: the earlier camera is taken to have been this one.
        // To move the history by parts of a pixel would blur it.
        let earlier = if last.camera_change == CameraChange::Shifts { camera } else { before };
        let is_at_rest = last.camera_change != CameraChange::Moves;
        let is_unchanged = last.camera_change == CameraChange::None;
        let has_all_directions = is_unchanged && last.turns.at_rest >= self.averaged;
        let array = |m: DMat4| m.as_mat4().to_cols_array_2d();
        let [clip, clip_before] = [camera, earlier].map(|c| c.view_to_clip_reversed().as_dmat4());
        let [world, world_before] = [camera, earlier].map(|c| c.world_to_view.as_dmat4());
        let to_world = world.inverse();
        let mut block = HistoryBlock {
            clip_to_view: array(clip.inverse()),
            view_to_view_before: array(world_before * to_world),
            view_to_clip_before: array(clip_before),
            clip_to_view_before: array(clip_before.inverse()),
            resolution: extent.map(|v| v as f32),
            size: extent.map(|v| v as i32),
            beyond: extent.map(|v| v as f32 + BEYOND as f32),
            unit: view_unit_m(camera),
            frames: self.averaged as f32,
            deviations: self.deviations,
            begins: i32::from(last.camera_before.is_none()),
            most: if is_unchanged { MOST_AT_REST } else { self.averaged as f32 },
            rests: i32::from(is_at_rest) + i32::from(has_all_directions), // 2 once all directions are averaged
            repeats: i32::from(last.is_repetition),
            view_to_clip: array(clip),
            ..HistoryBlock::default()
        };
        if let Some(SurfaceMotion { scale, shifted, .. }) = motion {
            let shifts = |past_camera: &Camera| shift(past_camera, extent) - shift(camera, extent);
            let included = if shifted { shifts(before) } else { Vec2::ZERO };
            (block.motion_scale, block.motion_shift) = (scale, (shifts(earlier) - included).to_array());
        }
        for (data, mover) in block.movers.iter_mut().zip(&last.movers) {
            let [first, end] = mover.triangles;
            *data = MoverData { to_before: array(world_before * mover.back * to_world), triangles: [first, end, 0, 0] };
            block.mover_count += 1;
        }
        block
    }
}

/// Compiles the program for frames in which `search` may have moved, or for frames in which nothing moved.
fn compile(gpu: &Gpu, variant: Variant, search: Option<HistorySearch>) -> Result<Pipeline> {
    let Variant { stage, is_orthographic: orthographic, composite } = variant;
    let HistorySearch { movers, motion } = search.unwrap_or_default();
    let constants = HistoryConstants { orthographic, composite, motion, movers, search: search.is_some() };
    let color = if composite { LIT_COLOR } else { vk::Format::UNDEFINED };
    PixelPipeline::new(gpu, stage, [LIT_COLOR, GUIDE, color], &constants)
}

/// Returns how far a camera's projection shifts the image, for example by jitter: pixels, x to the right and y down.
fn shift(camera: &Camera, extent: [u32; 2]) -> Vec2 {
    let projection = camera.view_to_clip_reversed();
    let column = if camera.kind().is_orthographic() { projection.w_axis } else { projection.z_axis };
    let [width, height] = extent.map(|side| 0.5 * side as f32);
    column.xy() * Vec2::new(width, -height)
}

/// Returns the first [`MOST_MOVERS`] objects that stand elsewhere than before.
fn find_movers(before: &[MovableObject], now: &[MovableObject]) -> Vec<Mover> {
    let pairs = before.iter().zip(now).filter(|(a, b)| a.triangles == b.triangles && a.placement != b.placement);
    let back = |before: &MovableObject, now: &MovableObject| {
        let [before, now] = [before, now].map(|object| object.placement);
        if before.is_offset() && now.is_offset() {
            return DMat4::from_translation((before.offset - now.offset).as_dvec3());
        }
        before.matrix() * now.matrix().inverse()
    };
    let moved = pairs.map(|(before, now)| Mover { triangles: now.triangles, back: back(before, now) });
    moved.take(MOST_MOVERS as usize).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, Vec3};

    #[test]
    fn rays_turn_once_through_their_directions_after_each_stop() {
        let averaged = 4;
        let first = Turns { remaining: averaged - 1, ..Turns::default() };
        let next_at_rest = |turns: Turns| turns.next(CameraChange::None, false, averaged);
        let at_rest: Vec<u32> =
            std::iter::successors(Some(first), |t| Some(next_at_rest(*t))).take(7).map(|t| t.at_rest).collect();
        assert_eq!(at_rest, [0, 1, 2, 3, 3, 3, 3]);
        // At rest, the directions turn until `averaged` frames have had different ones.
        let settled = (0..6).fold(first, |turns, _| next_at_rest(turns));
        // When the last moving object stops, they turn as often again, so that it is averaged where it stands now.
        let stopped = settled.next(CameraChange::None, true, averaged);
        assert_eq!((stopped.at_rest, stopped.total), (4, settled.total + 1));
        let moved = settled.next(CameraChange::Moves, false, averaged);
        assert_eq!((moved.at_rest, moved.total), (0, settled.total + 1));
        assert_eq!(next_at_rest(moved).at_rest, 1);
        // A jittered camera never runs out of new directions, unless only one frame is averaged.
        let jittered = (0..6).fold(settled, |turns, _| turns.next(CameraChange::Shifts, false, averaged));
        assert_eq!((jittered.at_rest, jittered.total), (settled.at_rest + 6, settled.total + 6));
        assert_eq!(Turns::default().next(CameraChange::Shifts, false, 1), Turns::default());
    }

    #[test]
    fn movers_are_the_things_that_stand_elsewhere_than_before() {
        let standing =
            |first: u32, x: f32| MovableObject { triangles: [first, first + 2], placement: (Vec3::X * x).into() };
        let before = [standing(0, 0.0), standing(2, 1.0), standing(4, 0.0)];
        let now = [standing(0, 0.0), standing(2, 1.5), standing(4, 0.0)];
        let moved = find_movers(&before, &now);
        let back = DMat4::from_translation(DVec3::X * -0.5);
        assert_eq!(moved.iter().map(|m| (m.triangles, m.back)).collect::<Vec<_>>(), [([2, 4], back)]);
        assert!(find_movers(&[], &now).is_empty(), "nothing is known of a frame before the first");
    }
}
