//! Triangles of the scene, from another renderer.

#[cfg(feature = "tree")]
use super::Context;
use crate::error::{Error, Result};
use crate::gpu::FrameContext;
use crate::gpu::frame::Mode;
use crate::passes::triangle_scene::{TriangleBuffers, TriangleReading};
use crate::passes::unlit_triangles::UnlitTriangles;
use ash::vk;
#[cfg(feature = "tree")]
use glam::{Mat4, Vec3};
#[cfg(feature = "tree")]
use ssct_ground::scene::tree::{Tree, TriangleRecords};
#[cfg(feature = "tree")]
use ssct_ground::scene::{Aabb, Encoding, Material, Mesh, Scene, Texture, Vertex};

/// A mesh, where it stands, and the light that comes from it in reflections.
#[derive(Debug, Clone, Copy)]
pub struct TriangleMesh<'a> {
    /// Places of the vertices, in the mesh's own space.
    pub positions: &'a [[f32; 3]],
    /// Three indices of vertices for each triangle. Triangles are seen from both sides.
    pub indices: &'a [u32],
    /// The matrix from the mesh's space to the world, column by column.
    pub mesh_to_world: [f32; 16],
    /// The light that comes from the mesh, linear. Give the colour as your lights make it, since the crate does not
    /// light meshes. With a texture, the colour is a factor of the texture.
    pub color: [f32; 3],
    /// The texture of the light, if the light differs over the mesh.
    pub texture: Option<MeshTexture<'a>>,
}

/// The texture of a mesh, and where each vertex lies on the texture.
#[derive(Debug, Clone, Copy)]
pub struct MeshTexture<'a> {
    /// The texture's number among those that [`Triangles::with_textures`] is given.
    pub number: usize,
    /// The texture coordinates of each vertex: (0, 0) is the corner of the first texel, (1, 1) that of the last.
    /// Outside of this range the texture repeats.
    pub places: &'a [[f32; 2]],
}

/// A texture of the light that comes from meshes. Rays interpolate between four texels of the mip level whose texels
/// are nearest in size to the ray's footprint. The crate makes the levels.
#[derive(Debug, Clone, Copy)]
pub struct HitTexture<'a> {
    /// Width and height in texels, 1 to [`Self::MAX_SIDE`].
    pub extent: [u32; 2],
    /// Whether the bytes are sRGB; otherwise they are linear.
    pub is_srgb: bool,
    /// Four bytes for each texel: red, green, blue, and a byte that is not read. Rows begin at the top.
    pub texels: &'a [u8],
}

impl HitTexture<'_> {
    /// The greatest width and height in texels.
    pub const MAX_SIDE: u32 = 32768;
}

/// Triangles of the scene, among which `unified` and `traced` follow rays. A ray sees the colour or texture of the mesh
/// that it hits. If something moved, make new triangles, and keep the old ones until the device is done with them.
pub struct Triangles {
    frames: FrameContext,
    unlit: UnlitTriangles,
    is_recorded: bool,
}

impl Triangles {
    /// Builds the tree over the triangles on the CPU, and makes the buffers; [`record_upload`](Self::record_upload)
    /// fills them. The function needs the crate's feature `tree`.
    ///
    /// # Errors
    /// [`Error::Usage`] with the number of a mesh that is wrong, and why; [`Error::Memory`] without memory.
    #[cfg(feature = "tree")]
    pub fn new(context: &Context, meshes: &[TriangleMesh]) -> Result<Self> {
        Self::with_textures(context, meshes, &[])
    }

    /// Does the same as [`Self::new`], for meshes with textures among `textures`.
    ///
    /// # Errors
    /// Errors of [`Self::new`], and [`Error::Usage`] with the number of a texture that is wrong, and why.
    #[cfg(feature = "tree")]
    pub fn with_textures(context: &Context, meshes: &[TriangleMesh], textures: &[HitTexture]) -> Result<Self> {
        let convert_mesh = |(number, mesh): (usize, &TriangleMesh)| mesh.converted(number, textures.len());
        let converted: Vec<(Mesh, Material)> = meshes.iter().enumerate().map(convert_mesh).collect::<Result<_>>()?;
        let (meshes, materials) = converted.into_iter().unzip();
        let textures: Vec<Texture> =
            textures.iter().enumerate().map(|(number, texture)| texture.converted(number)).collect::<Result<_>>()?;
        if textures.iter().map(|texture| texture.rgba.len() / 4).sum::<usize>() > MAX_TEXELS {
            return Err(Error::Usage(format!("the textures have more than {MAX_TEXELS} texels together")));
        }
        let scene = Scene { name: "of triangles".into(), meshes, materials, ..Scene::default() };
        let tree = Tree::build(&scene)?;
        let records = TriangleRecords::new(&scene, &tree);
        let unlit = UnlitTriangles::new(&context.gpu, &tree, &records, &scene.materials, &textures)?;
        Ok(Self { frames: FrameContext::for_caller(&context.gpu, 1)?, unlit, is_recorded: false })
    }

    /// Records the copy of the triangles to the device. Call it once, before the first frame that sees them.
    ///
    /// # Errors
    /// [`Error::Usage`] if the copy was recorded before; [`Error::Vulkan`] from the device.
    ///
    /// # Safety
    /// The contract is that of [`Reflections::record`](super::Reflections::record).
    pub unsafe fn record_upload(&mut self, commands: vk::CommandBuffer) -> Result<()> {
        if self.is_recorded {
            return Err(Error::Usage("the triangles were uploaded before: make others where something moved".into()));
        }
        // SAFETY: the caller keeps to the contract of this function.
        let mut frame = unsafe { self.frames.begin_in(commands, 0, Mode::Plain) }?;
        self.unlit.record(&mut frame)?;
        frame.end()?;
        self.is_recorded = true;
        Ok(())
    }

    /// Returns the triangles in the form in which methods read them. Fails if they were never uploaded.
    pub(super) fn buffers(&self) -> Result<TriangleBuffers<'_>> {
        if !self.is_recorded {
            return Err(Error::Usage("the triangles were never uploaded: record_upload comes first".into()));
        }
        Ok(self.unlit.buffers())
    }

    /// Returns how shaders read the triangles, which is the same in every frame.
    pub(super) fn reading(&self) -> TriangleReading {
        self.unlit.reading()
    }
}

#[cfg(feature = "tree")]
impl TriangleMesh<'_> {
    /// Checks the mesh, and converts it to world space, with its colour or texture as a material. `number` is the
    /// mesh's place among all meshes, and becomes the number of its material.
    fn converted(&self, number: usize, texture_count: usize) -> Result<(Mesh, Material)> {
        let wrong = |why: String| Err(Error::Usage(format!("triangle mesh {number} {why}")));
        let (vertices, indices) = (self.positions.len(), self.indices);
        if !indices.len().is_multiple_of(3) {
            return wrong(format!("has {} indices, which are not three for each triangle", indices.len()));
        }
        if let Some(index) = indices.iter().find(|i| **i as usize >= vertices) {
            return wrong(format!("has the index {index}, and {vertices} vertices"));
        }
        let world = Mat4::from_cols_array(&self.mesh_to_world);
        let places: Vec<Vec3> = self.positions.iter().map(|p| world.transform_point3(Vec3::from(*p))).collect();
        let color = Vec3::from(self.color);
        if !places.iter().all(|p| p.is_finite()) || !color.is_finite() || color.min_element() < 0.0 {
            return wrong("has a place or a colour that is not finite, or a colour below 0".into());
        }
        if let Some(MeshTexture { number, places }) = self.texture {
            if number >= texture_count {
                return wrong(format!("has texture {number}, and there are {texture_count}"));
            }
            if places.len() != vertices {
                return wrong(format!("has {} places on its texture, and {vertices} vertices", places.len()));
            }
            if !places.as_flattened().iter().all(|v| v.is_finite()) {
                return wrong("has a place on its texture that is not finite".into());
            }
        }
        // Normals and tangents say nothing here: the light of a mesh does not depend on them.
        let vertex = |(vertex_number, place): (usize, &Vec3)| Vertex {
            position: place.to_array(),
            normal: [0.0, 1.0, 0.0],
            uv: self.texture.map_or([0.0; 2], |texture| texture.places[vertex_number]),
            tangent: [1.0, 0.0, 0.0, 1.0],
        };
        let mesh = Mesh {
            name: String::new(),
            vertices: places.iter().enumerate().map(vertex).collect(),
            indices: indices.to_vec(),
            material: number,
            bounds: Aabb::ALL,
        };
        // A material that emits all of its albedo has that colour under every light.
        let albedo_map = self.texture.map(|texture| texture.number);
        Ok((mesh, Material { albedo: color, albedo_map, emission: 1.0, ..Material::default() }))
    }
}

/// The most texels of all textures together, so that texels of all mip levels have indices of 31 bits.
#[cfg(feature = "tree")]
const MAX_TEXELS: usize = 1 << 30;

#[cfg(feature = "tree")]
impl HitTexture<'_> {
    /// Checks and converts the texture. Alpha becomes 255: for shaders it is the share of light that is emitted.
    fn converted(&self, number: usize) -> Result<Texture> {
        let [width, height] = self.extent;
        let wrong = |why: String| Err(Error::Usage(format!("texture {number} {why}")));
        if !self.extent.iter().all(|side| (1..=Self::MAX_SIDE).contains(side)) {
            return wrong(format!("is {width}x{height} texels; each side must have 1 to {}", Self::MAX_SIDE));
        }
        if self.texels.len() as u64 != 4 * u64::from(width) * u64::from(height) {
            return wrong(format!("is {width}x{height} texels of four bytes, and has {} bytes", self.texels.len()));
        }
        let encoding = if self.is_srgb { Encoding::Srgb } else { Encoding::Linear };
        let rgba = self.texels.as_chunks::<4>().0.iter().flat_map(|[r, g, b, _]| [*r, *g, *b, 255]).collect();
        Ok(Texture { name: String::new(), width, height, rgba, encoding })
    }
}
