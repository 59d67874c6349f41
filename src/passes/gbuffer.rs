//! Draws the G-buffer: albedo, normal, material and reversed depth of the nearest surface, from the meshes that may lie
//! in the frustum. The time of this scene pass is reported, but not counted.

use super::scene_data::{MeshData, SceneData, half_bits};
use super::triangle_scene::TRIANGLE;
use super::{GBuffer, LIT_COLOR, MATERIAL, NORMAL, Reflectors, WIDE_ABOVE, camera_block};
use crate::error::Result;
use crate::gpu::frame::Raster;
use crate::gpu::pipeline::VertexInput;
use crate::gpu::program::Fragment;
use crate::gpu::programs::{GBufferDepth, GBufferFragment, GBufferNumbered, GBufferPeeled, GBufferVertex};
use crate::gpu::shader::{CameraBlock, DrawBlock, PeelBlock};
use crate::gpu::sync::Access;
use crate::gpu::{
    Buffer, Frame, FrameContext, Gpu, GraphicsPipeline, Image, ImageDesc, Sampled, Sampler, Target, image,
};
use ash::vk;
use glam::{DMat4, Vec3};
use ssct_ground::math::constants::{ALPHA_MASK, NO_TRIANGLE, NORMAL_MAP, ROUGHNESS_MAP, SINGLE_SIDED};
use ssct_ground::math::frustum::Frustum;
use ssct_ground::scene::{Aabb, Camera, GBufferData, Material, Surface, Vertex};
use std::mem::offset_of;

/// The images that a [`GBuffer`] borrows, all of one size.
pub struct GBufferImages {
    depth: Image,
    normal: Image,
    material: Image,
    color: Image,
}

/// The texel of the image of triangles for a pixel in which nothing stands.
const NO_TRIANGLE_TEXEL: [f32; 4] = [f32::from_bits(NO_TRIANGLE); 4];

/// Pipelines and images of one size.
pub struct GBufferPass {
    /// Draws depth alone first, so that no surface is shaded in a pixel that does not show it; `None` to leave it out.
    depth: Option<GraphicsPipeline<GBufferDepth<'static>, GBufferVertex<'static>>>,
    pipeline: GBufferPipeline,
    images: GBufferImages,
    albedo: Image,
    /// The number of the triangle that each pixel shows, where it is asked for.
    triangle: Option<Image>,
    label: &'static str,
}

enum GBufferPipeline {
    /// Draws the nearest surfaces.
    Nearest(GraphicsPipeline<GBufferFragment<'static>, GBufferVertex<'static>>),
    /// Draws the nearest surfaces, and which triangle each pixel shows.
    Numbered(GraphicsPipeline<GBufferNumbered<'static>, GBufferVertex<'static>>),
    /// Draws the nearest surfaces behind another depth buffer.
    Peeled(GraphicsPipeline<GBufferPeeled<'static>, GBufferVertex<'static>>),
}

/// The layer behind which a pass of [`GBufferPass::behind`] draws.
#[derive(Clone, Copy)]
pub struct Peel<'a> {
    /// The layer's reversed depth, of the pass's size and from the same camera.
    pub depth: &'a Image,
    /// Least distance of a surface behind the layer, in metres of view depth.
    pub separation_m: f32,
}

/// Makes a fragment program from the bindings of a surface, which every such program has, and from its own fields.
macro_rules! fragment_program {
    ($program:ident, $view:expr, $surface:expr $(, $field:ident: $value:expr)*) => {
        $program {
            camera: &$view.camera,
            albedo_map: $surface.albedo_map,
            normal_map: $surface.normal_map,
            alpha_mask: $surface.alpha_mask,
            reflectivity_map: $surface.reflectivity_map,
            roughness_map: $surface.roughness_map,
            draw: $surface.draw,
            $($field: $value,)*
        }
    };
}

/// Counts of what was drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename = "Drawn")]
pub struct DrawnCounts {
    /// Meshes drawn.
    pub meshes: usize,
    /// Meshes that the frustum can't see.
    pub culled: usize,
    /// Triangles drawn.
    pub triangles: usize,
    /// The kinds of reflectors among the materials of the drawn meshes.
    #[serde(skip)]
    pub reflectors: Reflectors,
}

const ALBEDO: vk::Format = vk::Format::R8G8B8A8_SRGB;
const TARGETS: [vk::Format; 3] = [ALBEDO, NORMAL, MATERIAL];
const DEPTH: vk::Format = vk::Format::D32_SFLOAT;

/// Format of the depth of [`GBufferPass::where_marked`].
pub const DEPTH_STENCIL: vk::Format = vk::Format::D32_SFLOAT_S8_UINT;

impl GBufferImages {
    /// Makes images of a size in pixels, without content.
    pub fn new(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        Self::with_depth(gpu, extent, DEPTH)
    }

    fn with_depth(gpu: &Gpu, extent: [u32; 2], depth: vk::Format) -> Result<Self> {
        Self::with_formats(gpu, extent, depth, [NORMAL, LIT_COLOR])
    }

    /// Makes images without content, with a format for the depth, and one each for normals and colours.
    fn with_formats(gpu: &Gpu, extent: [u32; 2], depth: vk::Format, [normal, color]: [vk::Format; 2]) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        Ok(Self {
            depth: make_image(gpu, "depth", depth, extent, 1, U::DEPTH_STENCIL_ATTACHMENT)?,
            normal: make_image(gpu, "normal", normal, extent, 1, U::COLOR_ATTACHMENT | U::STORAGE)?,
            material: make_image(gpu, "material", MATERIAL, extent, 1, U::COLOR_ATTACHMENT | U::STORAGE)?,
            color: make_image(
                gpu,
                "color",
                color,
                extent,
                image::full_chain(extent),
                U::COLOR_ATTACHMENT | U::STORAGE,
            )?,
        })
    }

    /// Makes images with the content of a G-buffer on the host, rounded to their formats. NaN in a colour becomes 0, as in the
    /// import of another renderer's images, since a blurred chain would spread NaN over the image.
    pub fn upload(context: &mut FrameContext, data: &GBufferData) -> Result<Self> {
        if data.color.iter().all(|color| !color.is_nan()) {
            return Self::upload_unsound(context, data);
        }
        let without_nan = |channel: f32| if channel.is_nan() { 0.0 } else { channel };
        let color = data.color.iter().map(|color| Vec3::from(color.to_array().map(without_nan))).collect();
        Self::upload_unsound(context, &GBufferData { color, ..data.clone() })
    }

    /// Uploads as [`GBufferImages::upload`] does, but keeps NaN in colours, to test that methods bear NaN.
    pub fn upload_unsound(context: &mut FrameContext, data: &GBufferData) -> Result<Self> {
        let padded = |xyz: &[Vec3], w: f32| xyz.iter().flat_map(|v| v.extend(w).to_array().map(half_bits)).collect();
        let (normal, mut color): (Vec<u16>, Vec<u16>) = (padded(&data.normal, 0.0), padded(&data.color, 1.0));
        let surfaces_and_depths = data.surface.iter().zip(&data.depth);
        for ([.., alpha], (surface, depth)) in color.as_chunks_mut::<4>().0.iter_mut().zip(surfaces_and_depths) {
            // The lighting pass stores the same alpha.
            *alpha = half_bits(if *surface == Surface::Lit && *depth > 0.0 { 1.0 } else { 0.0 });
        }
        let images = Self::new(context.gpu(), [data.width, data.height])?;
        images.fill(context, data, [bytemuck::cast_slice(&normal), bytemuck::cast_slice(&color)])
    }

    /// Uploads as [`GBufferImages::upload`] does, but with colours and normals in 32-bit floats, which can hold the
    /// rounded values of other formats unchanged. The device must be able to filter such images linearly.
    pub fn upload_wide(context: &mut FrameContext, data: &GBufferData) -> Result<Self> {
        const WIDE: vk::Format = vk::Format::R32G32B32A32_SFLOAT;
        let wide = |xyz: &[Vec3], w: f32| -> Vec<u8> {
            xyz.iter().flat_map(|v| v.extend(w).to_array().map(f32::to_ne_bytes)).flatten().collect()
        };
        let images = Self::with_formats(context.gpu(), [data.width, data.height], DEPTH, [WIDE; 2])?;
        images.fill(context, data, [&wide(&data.normal, 0.0), &wide(&data.color, 1.0)])
    }

    /// Fills the images with depth and material of a G-buffer, and with `normal` and `color`, bytes in their formats.
    fn fill(self, context: &mut FrameContext, data: &GBufferData, [normal, color]: [&[u8]; 2]) -> Result<Self> {
        let values = data.reflectivity.iter().zip(&data.roughness);
        let material: Vec<u16> =
            values.flat_map(|(reflectivity, roughness)| [*reflectivity, *roughness]).map(half_bits).collect();
        let content: [(&Image, &[u8]); 4] = [
            (&self.depth, bytemuck::cast_slice(&data.depth)),
            (&self.normal, normal),
            (&self.material, bytemuck::cast_slice(&material)),
            (&self.color, color),
        ];
        for (image, bytes) in content {
            let staging = Buffer::upload(context.gpu(), "staging", bytes, vk::BufferUsageFlags::TRANSFER_SRC)?;
            context.once(|frame| frame.upload("upload", &staging, image.level(0)))?;
        }
        Ok(self)
    }

    /// Returns the images in the form in which methods read them.
    pub fn gbuffer(&self) -> GBuffer<'_> {
        GBuffer {
            depth: &self.depth,
            normal: &self.normal,
            material: &self.material,
            color: &self.color,
            triangle: None,
            reflectors: Reflectors::UNKNOWN,
        }
    }
}

/// The layout of [`Vertex`] in a buffer.
fn vertex_input() -> VertexInput<'static> {
    VertexInput {
        stride: size_of::<Vertex>() as u32,
        attributes: const {
            &[
                (vk::Format::R32G32B32_SFLOAT, offset_of!(Vertex, position) as u32),
                (vk::Format::R32G32B32_SFLOAT, offset_of!(Vertex, normal) as u32),
                (vk::Format::R32G32_SFLOAT, offset_of!(Vertex, uv) as u32),
                (vk::Format::R32G32B32A32_SFLOAT, offset_of!(Vertex, tangent) as u32),
            ]
        },
    }
}

/// Makes an image that passes can also sample and copy; `usage` is what else they use it for.
fn make_image(
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
    /// Makes the pass and its images of a size in pixels.
    pub fn new(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        let pipeline = GraphicsPipeline::mesh(gpu, vertex_input(), TARGETS, DEPTH)?;
        let depth = GraphicsPipeline::mesh(gpu, vertex_input(), [], DEPTH)?;
        Ok(Self { depth: Some(depth), ..Self::with_pipeline(gpu, extent, DEPTH, GBufferPipeline::Nearest(pipeline))? })
    }

    /// Makes a pass that also writes which triangle each pixel shows ([`GBuffer::triangle`]), if the device can.
    pub fn numbered(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        let plain = Self::new(gpu, extent)?;
        if !gpu.numbers_triangles() {
            return Ok(plain);
        }
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::STORAGE;
        let targets = [ALBEDO, NORMAL, MATERIAL, TRIANGLE];
        let pipeline = GraphicsPipeline::mesh(gpu, vertex_input(), targets, DEPTH)?;
        Ok(Self {
            pipeline: GBufferPipeline::Numbered(pipeline),
            triangle: Some(make_image(gpu, "triangle", TRIANGLE, extent, 1, usage)?),
            ..plain
        })
    }

    /// Makes a pass that draws the nearest surfaces behind those of another pass, by depth peeling (Everitt 2001).
    pub fn behind(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        let pipeline = GraphicsPipeline::mesh(gpu, vertex_input(), TARGETS, DEPTH)?;
        Self::with_pipeline(gpu, extent, DEPTH, GBufferPipeline::Peeled(pipeline))
    }

    /// Makes a pass that draws only where the stencil beside its depth is marked ([`Frame::mark`]).
    pub fn where_marked(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        let pipeline = GraphicsPipeline::mesh_where_marked(gpu, vertex_input(), TARGETS, DEPTH_STENCIL)?;
        Self::with_pipeline(gpu, extent, DEPTH_STENCIL, GBufferPipeline::Nearest(pipeline))
    }

    /// Makes a pass that draws no depth beforehand and writes no triangles.
    fn with_pipeline(gpu: &Gpu, extent: [u32; 2], depth: vk::Format, pipeline: GBufferPipeline) -> Result<Self> {
        Ok(Self {
            depth: None,
            pipeline,
            images: GBufferImages::with_depth(gpu, extent, depth)?,
            albedo: make_image(gpu, "albedo", ALBEDO, extent, 1, vk::ImageUsageFlags::COLOR_ATTACHMENT)?,
            triangle: None,
            label: "g-buffer",
        })
    }

    /// Returns the pass with another label, for a scene that a method draws for itself.
    pub fn labelled(self, label: &'static str) -> Self {
        Self { label, ..self }
    }

    /// The images that the pass draws, and the lit colour, which the lighting pass writes.
    pub fn gbuffer(&self) -> GBuffer<'_> {
        GBuffer { triangle: self.triangle.as_ref(), ..self.images.gbuffer() }
    }

    /// The albedo. Its alpha is 0 where the sky shows, and elsewhere 1, less a part for emission.
    pub fn albedo(&self) -> &Image {
        &self.albedo
    }

    /// Records the passes that draw the scene with its materials, possibly changed, and counts what they draw.
    pub fn record(
        &self,
        frame: &mut Frame,
        scene: &SceneData,
        materials: &[Material],
        camera: &Camera,
    ) -> Result<DrawnCounts> {
        let view = SceneView::new(scene, materials, camera, self.albedo.extent());
        let depth = match &self.depth {
            Some(pipeline) => {
                let (name, view) = (format!("{}/depth", self.label), view.opaque());
                frame.raster(&name, pipeline, [], self.cleared_depth(), |raster| {
                    view.draw(raster, |raster, surface| {
                        let fragment = GBufferDepth { camera: &view.camera, draw: surface.draw };
                        raster.bind(&fragment, &GBufferVertex { camera: &view.camera, draw: surface.draw })
                    })
                })?;
                Target::kept(self.images.depth.all())
            }
            None => self.cleared_depth(),
        };
        match (&self.pipeline, &self.triangle) {
            (GBufferPipeline::Nearest(pipeline), _) => {
                frame.raster(self.label, pipeline, self.targets(), depth, |raster| {
                    view.draw(raster, |raster, surface| {
                        let fragment = fragment_program!(GBufferFragment, view, surface);
                        raster.bind(&fragment, &GBufferVertex { camera: &view.camera, draw: surface.draw })
                    })
                })?;
            }
            (GBufferPipeline::Numbered(pipeline), Some(triangle)) => {
                let [albedo, normal, material] = self.targets();
                let targets = [albedo, normal, material, Target::cleared(triangle.all(), NO_TRIANGLE_TEXEL)];
                frame.raster(self.label, pipeline, targets, depth, |raster| {
                    view.draw(raster, |raster, surface| {
                        let fragment = fragment_program!(GBufferNumbered, view, surface);
                        raster.bind(&fragment, &GBufferVertex { camera: &view.camera, draw: surface.draw })
                    })
                })?;
            }
            _ => unreachable!("a pass of GBufferPass::behind records by record_behind"),
        }
        Ok(view.counts())
    }

    /// Records a pass made by [`GBufferPass::behind`]: draws the nearest surfaces behind the layer `peel`.
    pub fn record_behind(
        &self,
        frame: &mut Frame,
        scene: &SceneData,
        materials: &[Material],
        camera: &Camera,
        peel: Peel,
    ) -> Result<DrawnCounts> {
        let GBufferPipeline::Peeled(pipeline) = &self.pipeline else {
            unreachable!("only a pass of GBufferPass::behind records by record_behind");
        };
        let view = SceneView::new(scene, materials, camera, self.albedo.extent());
        let block = PeelBlock { separation: peel.separation_m };
        frame.make_ready(peel.depth.all(), Access::FragmentSampled);
        frame.raster(self.label, pipeline, self.targets(), self.cleared_depth(), |raster| {
            view.draw(raster, |raster, surface| {
                let first_depth = Sampled::nearest(peel.depth.all());
                let fragment = fragment_program!(GBufferPeeled, view, surface, first_depth: first_depth, peel: &block);
                raster.bind(&fragment, &GBufferVertex { camera: &view.camera, draw: surface.draw })
            })
        })?;
        Ok(view.counts())
    }

    fn targets(&self) -> [Target<'_>; 3] {
        [&self.albedo, &self.images.normal, &self.images.material].map(|image| Target::cleared(image.all(), [0.0; 4]))
    }

    fn cleared_depth(&self) -> Target<'_> {
        Target::cleared(self.images.depth.all(), [0.0; 4])
    }
}

/// The maps and parameters of a surface that fragment programs read.
struct SurfaceInput<'a> {
    albedo_map: Sampled<'a>,
    normal_map: Sampled<'a>,
    alpha_mask: Sampled<'a>,
    reflectivity_map: Sampled<'a>,
    roughness_map: Sampled<'a>,
    draw: &'a DrawBlock,
}

/// The part of a scene that a camera may see.
struct SceneView<'a> {
    scene: &'a SceneData,
    materials: &'a [Material],
    /// The meshes to draw, the last one first. Of surfaces in one place the one drawn last shows: the scene's first.
    visible: Vec<&'a MeshData>,
    culled_count: usize,
    world_to_clip: DMat4,
    camera: CameraBlock,
}

impl<'a> SceneView<'a> {
    /// Selects the meshes whose bounds may lie in the camera's frustum, and counts the others.
    fn new(scene: &'a SceneData, materials: &'a [Material], camera: &Camera, extent: [u32; 2]) -> Self {
        let world_to_clip = camera.view_to_clip_reversed().as_dmat4() * camera.world_to_view.as_dmat4();
        let frustum = Frustum::new(&world_to_clip.as_mat4());
        let (visible, culled): (Vec<&MeshData>, Vec<_>) = scene.meshes.iter().rev().partition(|mesh| {
            let Aabb { min, max } = mesh.bounds.placed(&mesh.placement);
            frustum.may_see(min, max)
        });
        let camera = camera_block(camera, extent);
        Self { scene, materials, visible, culled_count: culled.len(), world_to_clip, camera }
    }

    fn counts(&self) -> DrawnCounts {
        DrawnCounts {
            meshes: self.visible.len(),
            culled: self.culled_count,
            triangles: self.visible.iter().map(|m| m.index_count as usize / 3).sum(),
            reflectors: reflectors(self.visible.iter().map(|m| &self.materials[m.material])),
        }
    }

    /// Returns the view without the meshes that have an alpha mask.
    fn opaque(&self) -> Self {
        let is_opaque = |mesh: &&MeshData| self.materials[mesh.material].alpha_mask.is_none();
        Self { visible: self.visible.iter().copied().filter(is_opaque).collect(), ..*self }
    }

    /// Draws the visible meshes. `bind` binds the programs whenever material or placement differ from the mesh before.
    fn draw<'r, 'f, F: Fragment>(
        &self,
        raster: &mut Raster<'r, 'f, F, GBufferVertex<'static>>,
        bind: impl Fn(&mut Raster<'r, 'f, F, GBufferVertex<'static>>, &SurfaceInput) -> Result<()>,
    ) -> Result<()> {
        let mut bound = None;
        for mesh in &self.visible {
            if bound != Some((mesh.material, mesh.placement)) {
                let material = &self.materials[mesh.material];
                // White needs no filtering, and filtering maps is the largest cost of a fragment on a CPU.
                let map = |index: Option<usize>| match index {
                    Some(i) => Sampled(self.scene.textures[i].all(), Sampler::Material),
                    None => Sampled::nearest(self.scene.white.all()),
                };
                let placed = self.world_to_clip * mesh.placement.matrix();
                let turn = mesh.placement.turn.to_array();
                let block = DrawBlock { turn, ..draw_block(material, placed.as_mat4().to_cols_array_2d()) };
                let surface = SurfaceInput {
                    albedo_map: map(material.albedo_map),
                    normal_map: map(material.normal_map),
                    alpha_mask: map(material.alpha_mask),
                    reflectivity_map: map(material.reflectivity_map),
                    roughness_map: map(material.roughness_map),
                    draw: &block,
                };
                bind(raster, &surface)?;
                bound = Some((mesh.material, mesh.placement));
            }
            raster.draw(&mesh.vertices, &mesh.indices, mesh.index_count, mesh.last_triangle());
        }
        Ok(())
    }
}

/// Returns the kinds of reflectors that may occur on some materials, whose values are rounded as in the material image.
/// A map can only lower a reflectivity or a roughness.
fn reflectors<'m>(materials: impl Iterator<Item = &'m Material>) -> Reflectors {
    let rounded = |value: f32| half::f16::from_f32(value).to_f32();
    let start = Reflectors { everywhere: true, ..Reflectors::default() };
    materials.filter(|material| material.surface == Surface::Lit).fold(start, |found, material| {
        let reflects = rounded(material.reflectivity) > GBufferData::REFLECTS_ABOVE;
        let roughness = rounded(material.roughness);
        let may_be_lower = material.roughness_map.is_some();
        Reflectors {
            mirrors: found.mirrors || (reflects && (roughness <= 0.0 || may_be_lower)),
            narrow: found.narrow || (reflects && roughness > 0.0 && (roughness <= WIDE_ABOVE || may_be_lower)),
            wide: found.wide || (reflects && roughness > WIDE_ABOVE),
            everywhere: found.everywhere && reflects && material.reflectivity_map.is_none(),
        }
    })
}

/// Returns the uniform block for draws of one material, without the mesh's turn.
fn draw_block(material: &Material, world_to_clip: [[f32; 4]; 4]) -> DrawBlock {
    let lit = material.surface == Surface::Lit;
    DrawBlock {
        world_to_clip,
        albedo: material.albedo.extend(if lit { 1.0 } else { 0.0 }).to_array(),
        reflectivity: if lit { material.reflectivity } else { 0.0 },
        roughness: material.roughness,
        normal_deviation: material.normal_deviation,
        maps: [
            (material.normal_map.is_some(), NORMAL_MAP),
            (material.alpha_mask.is_some(), ALPHA_MASK),
            (material.roughness_map.is_some(), ROUGHNESS_MAP),
            (material.single_sided, SINGLE_SIDED),
        ]
        .into_iter()
        .filter(|(has, _)| *has)
        .fold(0, |bits, (_, bit)| bits | bit),
        emission: if lit { material.emission } else { 0.0 },
        ..DrawBlock::default()
    }
}
