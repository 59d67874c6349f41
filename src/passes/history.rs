//! Temporal filtering (thesis §4.2.11): the reflection of earlier frames, found again in this one, and averaged with it.

use super::{GBuffer, LIT_COLOR, Reflection};
use crate::error::Result;
use crate::gpu::shader::HistoryBlock;
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, Sampled, Target, programs};
use crate::passes::lost::unit;
use crate::scene::{Camera, ProjectionKind};
use ash::vk;
use std::cell::Cell;

/// Reversed depth, the number of frames, and the normal.
const GUIDE: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Pipeline, and the images of two frames of one size.
pub struct HistoryPass {
    pipeline: GraphicsPipeline<programs::History<'static>>,
    kept: [Kept; 2],
    /// How many frames there were, and what the last one was seen from.
    frames: Cell<u32>,
    camera: Cell<Option<Camera>>,
    averaged: u32,
    deviations: f32,
}

/// What is kept of a frame.
struct Kept {
    reflection: Image,
    guide: Image,
}

impl HistoryPass {
    /// For a size in pixels and a projection: how many frames are averaged at most, and how many standard deviations of what is seen
    /// around a pixel its history may lie from their mean.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn new(gpu: &Gpu, extent: [u32; 2], kind: ProjectionKind, (averaged, deviations): (u32, f32)) -> Result<Self> {
        let constants = programs::HistoryConstants { orthographic: kind.is_orthographic() };
        let image = |name, format| Image::target(gpu, name, format, extent);
        let kept = || -> Result<Kept> {
            Ok(Kept { reflection: image("history", LIT_COLOR)?, guide: image("history guide", GUIDE)? })
        };
        Ok(Self {
            pipeline: GraphicsPipeline::fullscreen_with(gpu, [LIT_COLOR, GUIDE], &constants)?,
            kept: [kept()?, kept()?],
            frames: Cell::new(0),
            camera: Cell::new(None),
            averaged,
            deviations,
        })
    }

    /// How many frames there were since the history began.
    pub fn frames(&self) -> u32 {
        self.frames.get()
    }

    /// How many frames are averaged at most.
    pub fn averaged(&self) -> u32 {
        self.averaged
    }

    /// Forgets all frames: the next one is the first.
    pub fn restart(&self) {
        self.frames.set(0);
        self.camera.set(None);
    }

    /// Pass "history". `distance` is from each pixel's point to what it reflects, in units of
    /// [`unit()`], where the method knows it: a mirror's image moves as what it shows, not as the mirror.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn record(
        &self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        camera: &Camera,
        reflection: Reflection,
        distance: Option<&Image>,
    ) -> Result<Reflection<'_>> {
        let before = self.camera.replace(Some(*camera));
        let turn = self.frames.get() as usize % 2;
        self.frames.set(self.frames.get() + 1);
        let [now, earlier] = [&self.kept[turn], &self.kept[1 - turn]];
        if before.is_none() {
            // Read by nobody, and yet bound.
            frame.clear("history/begin", earlier.reflection.all(), [0.0; 4])?;
            frame.clear("history/begin guide", earlier.guide.all(), [0.0; 4])?;
        }
        let program = programs::History {
            history: &HistoryBlock {
                has_distance: i32::from(distance.is_some()),
                ..self.block(camera, before.as_ref(), gbuffer.depth.extent())
            },
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            normal_buffer: Sampled::nearest(gbuffer.normal.all()),
            reflection_buffer: Sampled::nearest(reflection.0.all()),
            material_buffer: Sampled::nearest(gbuffer.material.all()),
            color_before: Sampled::nearest(earlier.reflection.all()),
            guide_before: Sampled::nearest(earlier.guide.all()),
            // Not read where it is not known.
            distance_buffer: Sampled::nearest(distance.unwrap_or(gbuffer.depth).all()),
        };
        let targets = [Target::overwrite(now.reflection.all()), Target::overwrite(now.guide.all())];
        frame.fullscreen("history", &self.pipeline, targets, &program)?;
        Ok(Reflection(&now.reflection))
    }

    fn block(&self, camera: &Camera, before: Option<&Camera>, extent: [u32; 2]) -> HistoryBlock {
        let earlier = before.unwrap_or(camera);
        let array = |m: glam::DMat4| m.as_mat4().to_cols_array_2d();
        let [clip, clip_before] = [camera, earlier].map(|c| c.view_to_clip_reversed().as_dmat4());
        let [world, world_before] = [camera, earlier].map(|c| c.world_to_view.as_dmat4());
        HistoryBlock {
            clip_to_view: array(clip.inverse()),
            view_to_view_before: array(world_before * world.inverse()),
            view_to_clip_before: array(clip_before),
            clip_to_view_before: array(clip_before.inverse()),
            resolution: extent.map(|v| v as f32),
            unit: unit(camera),
            frames: self.averaged as f32,
            deviations: self.deviations,
            begins: i32::from(before.is_none()),
            ..HistoryBlock::default()
        }
    }
}
