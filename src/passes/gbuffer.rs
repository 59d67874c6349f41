//! The G-buffer: albedo, normal, material and reversed depth of the nearest surface, from the
//! meshes that the frustum may see. A scene pass: its time is reported, not counted.

use super::scene_data::{MeshData, SceneData};
use super::{GBuffer, LIT_COLOR, MATERIAL, NORMAL, Reflectors, WIDE_ABOVE, camera_block};
use crate::error::Result;
use crate::gpu::pipeline::VertexInput;
use crate::gpu::programs::{GBufferFragment, GBufferVertex};
use crate::gpu::shader::DrawBlock;
use crate::gpu::{
    Buffer, Frame, FrameContext, Gpu, GraphicsPipeline, Image, ImageDesc, Sampled, Sampler, Target, image,
};
use crate::math::constants::{ALPHA_MASK, NORMAL_MAP};
use crate::math::frustum::Frustum;
use crate::scene::{Camera, GBufferData, Material, Surface, Vertex};
use ash::vk;
use glam::{DMat4, Vec3};
use std::mem::offset_of;

/// The images that [`GBuffer`] borrows, all of one size.
pub struct GBufferImages {
    depth: Image,
    normal: Image,
    material: Image,
    color: Image,
}

/// Pipeline and images of one size.
pub struct GBufferPass {
    pipeline: GraphicsPipeline<GBufferFragment<'static>, GBufferVertex<'static>>,
    images: GBufferImages,
    albedo: Image,
    label: &'static str,
}

/// What was drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Drawn {
    /// Meshes drawn.
    pub meshes: usize,
    /// Meshes that the frustum can't see.
    pub culled: usize,
    /// Triangles drawn.
    pub triangles: usize,
    /// What their materials say of reflections.
    #[serde(skip)]
    pub reflectors: Reflectors,
}

const ALBEDO: vk::Format = vk::Format::R8G8B8A8_SRGB;
const DEPTH: vk::Format = vk::Format::D32_SFLOAT;

/// Format of the depth of [`GBufferPass::where_marked`].
pub const DEPTH_STENCIL: vk::Format = vk::Format::D32_SFLOAT_S8_UINT;

impl GBufferImages {
    /// Images of a size in pixels, without content.
    pub fn new(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        Self::with_depth(gpu, extent, DEPTH)
    }

    fn with_depth(gpu: &Gpu, extent: [u32; 2], depth: vk::Format) -> Result<Self> {
        Self::of(gpu, extent, depth, [NORMAL, LIT_COLOR])
    }

    fn of(gpu: &Gpu, extent: [u32; 2], depth: vk::Format, [normal, color]: [vk::Format; 2]) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        Ok(Self {
            depth: image_of(gpu, "depth", depth, extent, 1, U::DEPTH_STENCIL_ATTACHMENT)?,
            normal: image_of(gpu, "normal", normal, extent, 1, U::COLOR_ATTACHMENT | U::STORAGE)?,
            material: image_of(gpu, "material", MATERIAL, extent, 1, U::COLOR_ATTACHMENT | U::STORAGE)?,
            color: image_of(gpu, "color", color, extent, image::full_chain(extent), U::COLOR_ATTACHMENT | U::STORAGE)?,
        })
    }

    /// Images with the content of a G-buffer on the host, rounded to their formats.
    pub fn upload(context: &mut FrameContext, data: &GBufferData) -> Result<Self> {
        let padded = |v: &[Vec3], w: f32| v.iter().flat_map(|p| p.extend(w).to_array().map(half_bits)).collect();
        let mut vectors: [Vec<u16>; 2] = [padded(&data.normal, 0.0), padded(&data.color, 1.0)];
        let shown = data.surface.iter().zip(&data.depth);
        for (color, (surface, depth)) in vectors[1].as_chunks_mut::<4>().0.iter_mut().zip(shown) {
            // As the lighting pass has it.
            color[3] = half_bits(if *surface == Surface::Lit && *depth > 0.0 { 1.0 } else { 0.0 });
        }
        let images = Self::new(context.gpu(), [data.width, data.height])?;
        images.filled(context, data, vectors.each_ref().map(|v| bytemuck::cast_slice(v)))
    }

    /// As [`GBufferImages::upload`], with the colour in 32-bit floats, which round nothing, and the normals too or as
    /// [`NORMAL`]: to try other formats than these by their values. The device must filter such images linearly.
    pub fn upload_wide(context: &mut FrameContext, data: &GBufferData, wide_normals: bool) -> Result<Self> {
        const WIDE: vk::Format = vk::Format::R32G32B32A32_SFLOAT;
        let wide = |v: &[Vec3], w: f32| -> Vec<u8> {
            v.iter().flat_map(|p| p.extend(w).to_array().map(f32::to_ne_bytes)).flatten().collect()
        };
        let half = |v: &[Vec3]| -> Vec<u8> {
            v.iter().flat_map(|p| p.extend(0.0).to_array().map(|c| half_bits(c).to_ne_bytes())).flatten().collect()
        };
        let (format, normal) =
            if wide_normals { (WIDE, wide(&data.normal, 0.0)) } else { (NORMAL, half(&data.normal)) };
        let images = Self::of(context.gpu(), [data.width, data.height], DEPTH, [format, WIDE])?;
        images.filled(context, data, [&normal, &wide(&data.color, 1.0)])
    }

    /// The images with depth and material of a G-buffer, and normals and colour as bytes of their formats.
    fn filled(self, context: &mut FrameContext, data: &GBufferData, [normal, color]: [&[u8]; 2]) -> Result<Self> {
        let images = self;
        let material: Vec<u16> =
            data.reflectivity.iter().zip(&data.roughness).flat_map(|(a, b)| [half_bits(*a), half_bits(*b)]).collect();
        let content: [(&Image, &[u8]); 4] = [
            (&images.depth, bytemuck::cast_slice(&data.depth)),
            (&images.normal, normal),
            (&images.material, bytemuck::cast_slice(&material)),
            (&images.color, color),
        ];
        for (image, bytes) in content {
            let staging = Buffer::upload(context.gpu(), "staging", bytes, vk::BufferUsageFlags::TRANSFER_SRC)?;
            context.once(|frame| frame.upload("upload", &staging, image.level(0)))?;
        }
        Ok(images)
    }

    /// The images as methods take them.
    pub fn gbuffer(&self) -> GBuffer<'_> {
        GBuffer {
            depth: &self.depth,
            normal: &self.normal,
            material: &self.material,
            color: &self.color,
            reflectors: Reflectors::UNKNOWN,
        }
    }
}

fn half_bits(v: f32) -> u16 {
    half::f16::from_f32(v).to_bits()
}

fn image_of(
    gpu: &Gpu,
    name: &str,
    format: vk::Format,
    extent: [u32; 2],
    levels: u32,
    usage: vk::ImageUsageFlags,
) -> Result<Image> {
    use vk::ImageUsageFlags as U;
    let usage = usage | U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST;
    Image::new(gpu, &ImageDesc { name, format, extent, levels, layers: 1, usage })
}

impl GBufferPass {
    /// Images of a size in pixels.
    pub fn new(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        Self::of(gpu, extent, DEPTH)
    }

    /// A pass that draws only where the stencil beside its depth is marked ([`Frame::mark`]).
    pub fn where_marked(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        Self::of(gpu, extent, DEPTH_STENCIL)
    }

    fn of(gpu: &Gpu, extent: [u32; 2], depth: vk::Format) -> Result<Self> {
        let input = VertexInput {
            stride: size_of::<Vertex>() as u32,
            attributes: &[
                (vk::Format::R32G32B32_SFLOAT, offset_of!(Vertex, position) as u32),
                (vk::Format::R32G32B32_SFLOAT, offset_of!(Vertex, normal) as u32),
                (vk::Format::R32G32_SFLOAT, offset_of!(Vertex, uv) as u32),
                (vk::Format::R32G32B32A32_SFLOAT, offset_of!(Vertex, tangent) as u32),
            ],
        };
        let targets = [ALBEDO, NORMAL, MATERIAL];
        let mesh = if depth == DEPTH_STENCIL { GraphicsPipeline::mesh_where_marked } else { GraphicsPipeline::mesh };
        Ok(Self {
            pipeline: mesh(gpu, input, targets, depth)?,
            images: GBufferImages::with_depth(gpu, extent, depth)?,
            albedo: image_of(gpu, "albedo", ALBEDO, extent, 1, vk::ImageUsageFlags::COLOR_ATTACHMENT)?,
            label: "g-buffer",
        })
    }

    /// Under another name, for a scene that a method draws for itself.
    pub fn labelled(self, label: &'static str) -> Self {
        Self { label, ..self }
    }

    /// The images, whose colour the lighting pass writes.
    pub fn gbuffer(&self) -> GBuffer<'_> {
        self.images.gbuffer()
    }

    /// Albedo (a: 1 lit, 0 shows the sky).
    pub fn albedo(&self) -> &Image {
        &self.albedo
    }

    /// Draws the scene with some materials (those of [`SceneData`]'s scene, possibly changed).
    pub fn record(
        &self,
        frame: &mut Frame,
        scene: &SceneData,
        materials: &[Material],
        camera: &Camera,
    ) -> Result<Drawn> {
        let extent = self.albedo.extent();
        let world_to_clip = camera.view_to_clip_reversed().as_dmat4() * camera.world_to_view.as_dmat4();
        let frustum = Frustum::new(&world_to_clip.as_mat4());
        let (seen, culled): (Vec<&MeshData>, Vec<_>) =
            scene.meshes.iter().partition(|m| frustum.may_see(m.bounds.min + m.offset, m.bounds.max + m.offset));
        let camera = camera_block(camera, extent);
        let targets = [
            Target::cleared(self.albedo.all(), [0.0; 4]),
            Target::cleared(self.images.normal.all(), [0.0; 4]),
            Target::cleared(self.images.material.all(), [0.0; 4]),
        ];
        let drawn = Drawn {
            meshes: seen.len(),
            culled: culled.len(),
            triangles: seen.iter().map(|m| m.index_count as usize / 3).sum(),
            reflectors: reflectors(seen.iter().map(|m| &materials[m.material])),
        };
        frame.raster(
            self.label,
            &self.pipeline,
            targets,
            Target::cleared(self.images.depth.all(), [0.0; 4]),
            |raster| {
                let mut bound = None;
                for mesh in seen {
                    if bound != Some((mesh.material, mesh.offset)) {
                        let material = &materials[mesh.material];
                        let map = |index: Option<usize>| {
                            let image = index.map_or(&scene.white, |i| &scene.textures[i]);
                            Sampled(image.all(), Sampler::Material)
                        };
                        let placed = world_to_clip * DMat4::from_translation(mesh.offset.as_dvec3());
                        let block = draw_block(material, placed.as_mat4().to_cols_array_2d());
                        let fragment = GBufferFragment {
                            camera: &camera,
                            albedo_map: map(material.albedo_map),
                            normal_map: map(material.normal_map),
                            alpha_mask: map(material.alpha_mask),
                            reflectivity_map: map(material.reflectivity_map),
                            draw: &block,
                        };
                        raster.bind(&fragment, &GBufferVertex { camera: &camera, draw: &block })?;
                        bound = Some((mesh.material, mesh.offset));
                    }
                    raster.draw(&mesh.vertices, &mesh.indices, mesh.index_count);
                }
                Ok(())
            },
        )?;
        Ok(drawn)
    }
}

/// What some materials can reflect, in the precision of the material image: a map only ever lowers a
/// reflectivity.
fn reflectors<'m>(materials: impl Iterator<Item = &'m Material>) -> Reflectors {
    let stored = |v: f32| half::f16::from_f32(v).to_f32();
    let start = Reflectors { everywhere: true, ..Reflectors::default() };
    materials.filter(|m| m.surface == Surface::Lit).fold(start, |r, m| {
        let reflects = stored(m.reflectivity) > GBufferData::REFLECTS_ABOVE;
        let roughness = stored(m.roughness);
        Reflectors {
            mirrors: r.mirrors || (reflects && roughness <= 0.0),
            narrow: r.narrow || (reflects && roughness > 0.0 && roughness <= WIDE_ABOVE),
            wide: r.wide || (reflects && roughness > WIDE_ABOVE),
            everywhere: r.everywhere && reflects && m.reflectivity_map.is_none(),
        }
    })
}

fn draw_block(material: &Material, world_to_clip: [[f32; 4]; 4]) -> DrawBlock {
    let lit = material.surface == Surface::Lit;
    DrawBlock {
        world_to_clip,
        albedo: material.albedo.extend(if lit { 1.0 } else { 0.0 }).to_array(),
        reflectivity: if lit { material.reflectivity } else { 0.0 },
        roughness: material.roughness,
        normal_deviation: material.normal_deviation,
        maps: material.normal_map.map_or(0, |_| NORMAL_MAP) | material.alpha_mask.map_or(0, |_| ALPHA_MASK),
    }
}
