//! Following the rays that the screen lost through the captures of a scene (docs/definitions.md, "Images"): the list of
//! such rays, which the passes that trace the screen fill, and the passes that follow them, over as many rays as there
//! are.

use super::tiles::{self, TILE};
use super::{Canvas, Captures, GBuffer, Hits, Reflection};
use crate::error::Result;
use crate::gpu::memory::Place;
use crate::gpu::shader::{CaptureBlock, UnifiedBlock};
use crate::gpu::{Buffer, ComputePipeline, Frame, Gpu, Image, ImageDesc, Sampled, programs};
use crate::scene::Camera;
use ash::vk;

/// Bytes of a ray in the list (`LostRay` of `shaders-glsl/captures/lost.glsl`).
const RAY_BYTES: u64 = 48;

/// What the passes that trace the screen need to show the sky along a ray, and to hand on rays that the screen lost.
pub struct LostRays {
    counts: Buffer,
    rays: Buffer,
    /// In place of a scene's sky, where there is no scene: black.
    no_sky: Image,
}

/// What those passes bind.
#[derive(Clone, Copy)]
pub struct Beyond<'a> {
    /// The camera among the captures.
    pub block: &'a CaptureBlock,
    /// The sky in world axes.
    pub sky: Sampled<'a>,
    /// How many rays there are.
    pub counts: &'a Buffer,
    /// The rays.
    pub rays: &'a Buffer,
}

impl LostRays {
    /// Room for a ray of each pixel, or for none where there are no captures to follow them in.
    pub fn new(gpu: &Gpu, extent: [u32; 2], followed: bool) -> Result<Self> {
        use vk::BufferUsageFlags as U;
        // Tiles at the border overlap, so that a ray may be on the list twice.
        let tiles: u64 = tiles::count(extent).into_iter().map(u64::from).product();
        let count = if followed { tiles * u64::from(TILE * TILE) } else { 1 };
        let usage = U::STORAGE_BUFFER | U::INDIRECT_BUFFER | U::TRANSFER_DST;
        Ok(Self {
            counts: Buffer::new(gpu, "lost counts", 16, usage, Place::Device)?,
            rays: Buffer::new(gpu, "lost rays", RAY_BYTES * count, U::STORAGE_BUFFER, Place::Device)?,
            no_sky: Image::new(
                gpu,
                &ImageDesc {
                    name: "no sky",
                    format: vk::Format::R16G16B16A16_SFLOAT,
                    extent: [1, 1],
                    levels: 1,
                    layers: 6,
                    usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
                },
            )?,
        })
    }

    /// Pass "lost/clear", where rays are followed: there are none yet.
    pub fn clear(&self, frame: &mut Frame) -> Result<()> {
        frame.fill("lost/clear", &self.counts, 0)
    }

    /// What a pass binds, with the scene's sky if there is a scene.
    pub fn beyond<'a>(&'a self, block: &'a CaptureBlock, sky: Option<&'a Image>) -> Beyond<'a> {
        let sky = Sampled::trilinear(sky.unwrap_or(&self.no_sky).all());
        Beyond { block, sky, counts: &self.counts, rays: &self.rays }
    }
}

/// The block of a camera among captures, or without any.
pub fn capture_block(camera: &Camera, captures: Option<&Captures>) -> CaptureBlock {
    let mut block = CaptureBlock::default();
    let mut rotation = camera.world_to_view.as_dmat4().inverse();
    rotation.w_axis = glam::DVec4::W;
    block.view_to_world = rotation.as_mat4().to_cols_array_2d();
    block.view_unit = unit(camera);
    if let Some(captures) = captures {
        let eye = camera.eye();
        for (place, of) in block.places.iter_mut().zip(captures.places) {
            *place = (*of - eye).extend(0.0).to_array();
        }
        block.count = captures.places.len().min(block.places.len()) as i32;
        block.face_unit = captures.face_unit;
    }
    block
}

/// near (1 + k) of a camera, k = near / (far - near): reversed depth plus k is this over z.
pub fn unit(camera: &Camera) -> f32 {
    camera.view_to_clip_reversed().as_dmat4().w_axis.z as f32
}

/// The pipelines.
pub struct FollowPass {
    begin: ComputePipeline<programs::BeginInCaptures<'static>>,
    mirrors: ComputePipeline<programs::FollowMirrors<'static>>,
    narrow: ComputePipeline<programs::FollowNarrow<'static>>,
    wide: ComputePipeline<programs::FollowWide<'static>>,
}

/// What is written of the pixels of mirrors, and where rays begin.
#[derive(Debug, Clone, Copy, Default)]
pub struct FollowWants {
    /// Another reflection shows where no image knows what a ray sees.
    pub over: bool,
    /// The finished image.
    pub composite: bool,
    /// The reflection as an image of its own.
    pub reflection: bool,
    /// Where each ray ended.
    pub hits: bool,
    /// Rays begin only where another reflection does not cover all.
    pub behind: bool,
}

/// What every pass here reads.
#[derive(Clone, Copy)]
pub struct FollowInput<'a> {
    /// Where rays go on.
    pub captures: Captures<'a>,
    /// The rays, the camera among the captures, and the sky.
    pub beyond: Beyond<'a>,
}

impl FollowPass {
    /// Compiles the pipelines, for faces whose pyramids have strips of 2^`strip` columns.
    ///
    /// Of mirrors the composite, the reflection and the hits are written as they are wanted; `behind` says that what is
    /// followed from its beginning stands behind another reflection.
    pub fn new(gpu: &Gpu, strip: u32, wanted: FollowWants) -> Result<Self> {
        let strip = strip as i32;
        let FollowWants { over, composite, reflection, hits, behind } = wanted;
        let mirrors = programs::FollowMirrorsConstants { strip, over, composite, reflection, hits };
        Ok(Self {
            begin: ComputePipeline::with(gpu, &programs::BeginInCapturesConstants { behind })?,
            mirrors: ComputePipeline::with(gpu, &mirrors)?,
            narrow: ComputePipeline::with(gpu, &programs::FollowNarrowConstants { strip, over })?,
            wide: ComputePipeline::with(gpu, &programs::FollowWideConstants { strip, over })?,
        })
    }

    /// Pass "begin": puts the ray of every pixel that reflects on the list, from where it begins.
    pub fn record_begin(
        &self,
        frame: &mut Frame,
        beyond: Beyond,
        gbuffer: &GBuffer,
        in_front: Option<Reflection>,
        parameters: &UnifiedBlock,
    ) -> Result<()> {
        let [width, height] = gbuffer.depth.extent();
        let program = programs::BeginInCaptures {
            unified: parameters,
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            normal_buffer: Sampled::nearest(gbuffer.normal.all()),
            material_buffer: Sampled::nearest(gbuffer.material.all()),
            reflection_buffer: Sampled::nearest(in_front.map_or(gbuffer.color.level(0), |r| r.0.all())),
            captures: beyond.block,
            environment: beyond.sky,
            lost_counts: beyond.counts,
            lost: beyond.rays,
        };
        frame.compute("begin", &self.begin, &program, [width, height, 1])
    }

    /// Pass "follow/mirrors": finishes the pixels whose mirror rays the screen lost.
    pub fn record_mirrors(
        &self,
        frame: &mut Frame,
        FollowInput { captures, beyond }: FollowInput,
        gbuffer: &GBuffer,
        canvas: Canvas,
        hits: Option<Hits>,
    ) -> Result<()> {
        let composite = canvas.composite.all();
        let program = programs::FollowMirrors {
            unified: captures.face,
            pyramid: captures.pyramid.all(),
            normal_buffer: captures.normal.all(),
            material_buffer: gbuffer.material.all(),
            color_cubes: Sampled::trilinear(captures.color.all()),
            color_buffer: Sampled::nearest(gbuffer.color.level(0)),
            composite_image: composite,
            // What is not wanted is not written, and needs an image all the same.
            reflection_image: canvas.reflection.map_or(composite, Image::all),
            hits_image: hits.map_or(composite, |h| h.0.all()),
            captures: beyond.block,
            environment: beyond.sky,
            lost_counts: beyond.counts,
            lost: beyond.rays,
        };
        frame.compute_indirect("follow/mirrors", &self.mirrors, &program, beyond.counts)
    }

    /// Pass "follow/narrow": writes into the records what the rays of narrow lobes see that the screen lost.
    pub fn record_narrow(
        &self,
        frame: &mut Frame,
        FollowInput { captures, beyond }: FollowInput,
        records: &Image,
    ) -> Result<()> {
        let program = programs::FollowNarrow {
            unified: captures.face,
            pyramid: captures.pyramid.all(),
            normal_buffer: captures.normal.all(),
            color_cubes: Sampled::trilinear(captures.color.all()),
            seen_image: records.all(),
            captures: beyond.block,
            environment: beyond.sky,
            lost_counts: beyond.counts,
            lost: beyond.rays,
        };
        frame.compute_indirect("follow/narrow", &self.narrow, &program, beyond.counts)
    }

    /// Pass "follow/wide": the same for the rays of cells with wide lobes.
    pub fn record_wide(
        &self,
        frame: &mut Frame,
        FollowInput { captures, beyond }: FollowInput,
        [place, seen]: [&Image; 2],
    ) -> Result<()> {
        let program = programs::FollowWide {
            unified: captures.face,
            pyramid: captures.pyramid.all(),
            normal_buffer: captures.normal.all(),
            color_cubes: Sampled::trilinear(captures.color.all()),
            place_image: place.all(),
            seen_image: seen.all(),
            captures: beyond.block,
            environment: beyond.sky,
            lost_counts: beyond.counts,
            lost: beyond.rays,
        };
        frame.compute_indirect("follow/wide", &self.wide, &program, beyond.counts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::constants::LOST_GROUP;

    #[test]
    fn a_workgroup_follows_as_many_rays_as_the_list_counts_by() {
        use crate::gpu::program::Program;
        assert_eq!(<programs::FollowWide as Program>::SHADER.local_size, [LOST_GROUP as u32, 1, 1]);
    }
}
