//! Takes over the G-buffer of another renderer, in whatever conventions it has, as images that every method reads. Not
//! counted: a renderer that draws such images itself does without.

use super::{GBuffer, LIT_COLOR, MATERIAL, NORMAL, Reflectors};
use crate::error::Result;
use crate::gpu::programs::Import;
use crate::gpu::shader::ImportBlock;
use crate::gpu::{ComputePipeline, Frame, Gpu, Image, ImageDesc, Sampled, image};
use crate::scene::Camera;
use ash::vk;
use glam::{DVec2, Mat3};

/// Pipeline and images of one size.
pub struct ImportPass {
    pipeline: ComputePipeline<Import<'static>>,
    depth: Image,
    normal: Image,
    material: Image,
    color: Image,
    label: &'static str,
}

/// Images of another renderer, all of the pass's size.
#[derive(Clone, Copy)]
pub struct Foreign<'a> {
    /// Depth, in R.
    pub depth: &'a Image,
    /// What reversed depth is of it: the first number times it plus the second.
    pub to_reversed: [f32; 2],
    /// Normals, if there are any, how they are stored (`NORMAL_*`), and what turns them into our view space.
    pub normal: Option<(&'a Image, i32, Mat3)>,
    /// Reflectivity and roughness.
    pub material: [Factor<'a>; 2],
    /// Lit colour, linear.
    pub color: &'a Image,
    /// Whether the colour is black where nothing stands, since the sky is known apart.
    pub leaves_sky_out: bool,
}

/// A number a pixel.
#[derive(Clone, Copy)]
pub enum Factor<'a> {
    /// The same everywhere.
    Constant(f32),
    /// A channel (0 to 3) of an image.
    Channel(&'a Image, u32),
}

impl Factor<'_> {
    fn constant(self) -> Option<f32> {
        if let Self::Constant(value) = self { Some(value) } else { None }
    }
}

impl ImportPass {
    /// The pipeline, and images of a size in pixels.
    pub fn new(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let make = |name, format, levels| {
            let usage = U::SAMPLED | U::STORAGE | U::TRANSFER_SRC | U::TRANSFER_DST;
            Image::new(gpu, &ImageDesc { name, format, extent, levels, layers: 1, usage })
        };
        Ok(Self {
            pipeline: ComputePipeline::new(gpu)?,
            depth: make("depth", vk::Format::R32_SFLOAT, 1)?,
            normal: make("normal", NORMAL, 1)?,
            material: make("material", MATERIAL, 1)?,
            color: make("color", LIT_COLOR, image::full_chain(extent))?,
            label: "import",
        })
    }

    /// Under another name.
    pub fn labelled(self, label: &'static str) -> Self {
        Self { label, ..self }
    }

    /// Width and height in pixels.
    pub fn extent(&self) -> [u32; 2] {
        self.depth.extent()
    }

    /// Pass "import". What reflects is known where reflectivity or roughness is the same everywhere.
    pub fn record(&self, frame: &mut Frame, from: &Foreign, camera: &Camera) -> Result<GBuffer<'_>> {
        let block = block(from, camera, self.extent());
        let source = |factor| match factor {
            Factor::Constant(_) => Sampled::nearest(from.color.all()),
            Factor::Channel(image, _) => Sampled::nearest(image.all()),
        };
        let [width, height] = self.extent();
        let program = Import {
            import_block: &block,
            depth_source: Sampled::nearest(from.depth.all()),
            normal_source: Sampled::nearest(from.normal.map_or(from.color, |(image, ..)| image).all()),
            reflectivity_source: source(from.material[0]),
            roughness_source: source(from.material[1]),
            color_source: Sampled::nearest(from.color.all()),
            depth_image: self.depth.all(),
            normal_image: self.normal.all(),
            material_image: self.material.all(),
            color_image: self.color.level(0),
        };
        frame.compute(self.label, &self.pipeline, &program, [width, height, 1])?;
        let reflectors = Reflectors::of(from.material[0].constant(), from.material[1].constant());
        Ok(GBuffer {
            depth: &self.depth,
            normal: &self.normal,
            material: &self.material,
            color: &self.color,
            reflectors,
        })
    }
}

fn block(from: &Foreign, camera: &Camera, extent: [u32; 2]) -> ImportBlock {
    use crate::math::constants::NORMAL_OF_DEPTH;
    let projection = camera.view_to_clip_reversed().as_dmat4();
    let side = DVec2::from(extent.map(f64::from));
    let (scale, shift) =
        (DVec2::new(projection.x_axis.x, projection.y_axis.y), projection.z_axis.truncate().truncate());
    let (per_pixel, shift) = (1.0 / (side * scale), shift * side);
    let constants = from.material.map(|factor| factor.constant().unwrap_or(0.0));
    let channel = |factor| if let Factor::Channel(_, channel) = factor { channel as i32 } else { -1 };
    let (kind, to_view) = from.normal.map_or((NORMAL_OF_DEPTH, Mat3::IDENTITY), |(_, kind, to_view)| (kind, to_view));
    ImportBlock {
        normal_to_view: glam::Mat4::from_mat3(to_view).to_cols_array_2d(),
        view_ray: [per_pixel.x, per_pixel.y, shift.x, shift.y].map(|v| v as f32),
        depth_to_reversed: from.to_reversed,
        reversed_to_z: [-projection.z_axis.z, projection.w_axis.z].map(|v| v as f32),
        constants,
        channels: from.material.map(channel),
        size: extent.map(|v| v as i32),
        normal_kind: kind,
        leaves_sky_out: i32::from(from.leaves_sky_out),
    }
}
