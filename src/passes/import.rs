//! Converts the G-buffer of another renderer, whatever its conventions, to the images that every method reads. The time
//! of the pass is not counted, since a renderer that draws such images itself needs no import.

use super::{GBuffer, LIT_COLOR, MATERIAL, NORMAL, PerProjection, Reflectors, camera_block};
use crate::error::Result;
use crate::gpu::programs::{Import, ImportConstants};
use crate::gpu::shader::ImportBlock;
use crate::gpu::{ComputePipeline, Frame, Gpu, Image, ImageDesc, Sampled, image};
use ash::vk;
use glam::{Mat3, Mat4};
use ssct_ground::math::constants::NORMAL_OF_DEPTH;
use ssct_ground::scene::{Camera, ProjectionKind};

/// Pipelines and images of one size.
pub struct ImportPass {
    gpu: Gpu,
    /// A pipeline for each encoding of normals (`NORMAL_*`) and projection, made when a frame first needs it.
    pipelines: [PerProjection<ComputePipeline<Import<'static>>>; NORMAL_OF_DEPTH as usize + 1],
    depth: Image,
    normal: Image,
    material: Image,
    color: Image,
    label: &'static str,
}

/// Images of another renderer, all of the pass's size.
#[derive(Clone, Copy)]
pub struct ForeignImages<'a> {
    /// Depth, in R.
    pub depth: &'a Image,
    /// Factor and offset that turn the values of `depth` into reversed depth.
    pub to_reversed: [f32; 2],
    /// Normals, if there are any, the code of their encoding (`NORMAL_*`), and the matrix that turns them into our view space.
    pub normal: Option<(&'a Image, i32, Mat3)>,
    /// Reflectivity and roughness.
    pub material: [Factor<'a>; 2],
    /// Lit colour, linear.
    pub color: &'a Image,
    /// The kinds of reflecting surface that the frame may have, as the caller knows them.
    pub reflectors: Reflectors,
    /// Whether the colour becomes black where nothing stands, because the sky is given separately.
    pub leaves_sky_out: bool,
}

/// A number for each pixel.
#[derive(Clone, Copy)]
pub enum Factor<'a> {
    /// One value for all pixels.
    Constant(f32),
    /// A channel (0 to 3) of an image.
    Channel(&'a Image, u32),
}

impl Factor<'_> {
    /// Returns the value that all pixels have; `None` for a channel of an image.
    fn constant(self) -> Option<f32> {
        if let Self::Constant(value) = self { Some(value) } else { None }
    }
}

impl ImportPass {
    /// Makes the pass and its images of a size in pixels.
    pub fn new(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let make = |name, format, levels| {
            let usage = U::SAMPLED | U::STORAGE | U::TRANSFER_SRC | U::TRANSFER_DST;
            Image::new(gpu, &ImageDesc { name, format, extent, levels, layers: 1, usage })
        };
        Ok(Self {
            gpu: gpu.clone(),
            pipelines: [const { PerProjection::new() }; NORMAL_OF_DEPTH as usize + 1],
            depth: make("depth", vk::Format::R32_SFLOAT, 1)?,
            normal: make("normal", NORMAL, 1)?,
            material: make("material", MATERIAL, 1)?,
            color: make("color", LIT_COLOR, image::full_chain(extent))?,
            label: "import",
        })
    }

    /// Returns the pass with another label.
    pub fn labelled(self, label: &'static str) -> Self {
        Self { label, ..self }
    }

    /// Width and height in pixels.
    pub fn extent(&self) -> [u32; 2] {
        self.depth.extent()
    }

    /// Records pass "import". A constant reflectivity or roughness rules out kinds of reflectors in the result.
    pub fn record(&self, frame: &mut Frame, foreign: &ForeignImages, camera: &Camera) -> Result<GBuffer<'_>> {
        let (kind, to_view) =
            foreign.normal.map_or((NORMAL_OF_DEPTH, Mat3::IDENTITY), |(_, kind, to_view)| (kind, to_view));
        let (block, projection, camera) = (block(foreign, to_view), camera.kind(), camera_block(camera, self.extent()));
        let [reflectivity, roughness] = foreign.material;
        let source = |factor| match factor {
            // The binding needs some image, which is not read.
            Factor::Constant(_) => Sampled::nearest(foreign.color.all()),
            Factor::Channel(image, _) => Sampled::nearest(image.all()),
        };
        let [width, height] = self.extent();
        let program = Import {
            camera: &camera,
            import_block: &block,
            depth_source: Sampled::nearest(foreign.depth.all()),
            normal_source: Sampled::nearest(foreign.normal.map_or(foreign.color, |(image, ..)| image).all()),
            reflectivity_source: source(reflectivity),
            roughness_source: source(roughness),
            color_source: Sampled::nearest(foreign.color.all()),
            depth_image: self.depth.all(),
            normal_image: self.normal.all(),
            material_image: self.material.all(),
            color_image: self.color.level(0),
        };
        frame.compute(self.label, self.pipeline(kind, projection)?, &program, [width, height, 1])?;
        let possible = Reflectors::for_constants(reflectivity.constant(), roughness.constant());
        let reflectors = foreign.reflectors.and(possible);
        Ok(GBuffer {
            triangle: None,
            depth: &self.depth,
            normal: &self.normal,
            material: &self.material,
            color: &self.color,
            reflectors,
        })
    }

    /// Returns the pipeline for an encoding of normals and a projection, made at the first call.
    fn pipeline(&self, normal_kind: i32, kind: ProjectionKind) -> Result<&ComputePipeline<Import<'static>>> {
        let constants = ImportConstants { normal_kind, orthographic: kind.is_orthographic() };
        self.pipelines[normal_kind as usize].get(kind, || ComputePipeline::with_constants(&self.gpu, &constants))
    }
}

/// Returns the uniform block for the images of another renderer; `to_view` turns decoded normals into our view space.
fn block(foreign: &ForeignImages, to_view: Mat3) -> ImportBlock {
    let channel = |factor| if let Factor::Channel(_, channel) = factor { channel as i32 } else { -1 };
    ImportBlock {
        normal_to_view: Mat4::from_mat3(to_view).to_cols_array_2d(),
        depth_to_reversed: foreign.to_reversed,
        constants: foreign.material.map(|factor| factor.constant().unwrap_or(0.0)),
        channels: foreign.material.map(channel),
        leaves_sky_out: i32::from(foreign.leaves_sky_out),
        ..ImportBlock::default()
    }
}
