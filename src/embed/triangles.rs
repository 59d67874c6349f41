//! Triangles of the scene, from another renderer.

#[cfg(feature = "tree")]
use super::Context;
use crate::error::{Error, Result};
use crate::gpu::FrameContext;
use crate::gpu::frame::Mode;
use crate::passes::triangle_scene::{TriangleBuffers, TriangleReading};
use crate::passes::unlit_triangles::UnlitTriangles;
#[cfg(feature = "tree")]
use crate::scene::tree::{Tree, TriangleRecords};
#[cfg(feature = "tree")]
use crate::scene::{Aabb, Material, Mesh, Scene, Vertex};
use ash::vk;
#[cfg(feature = "tree")]
use glam::{Mat4, Vec3};

/// A mesh, where it stands, and the colour that it has in reflections.
#[derive(Debug, Clone, Copy)]
pub struct TriangleMesh<'a> {
    /// Places of the vertices, in the mesh's own space.
    pub positions: &'a [[f32; 3]],
    /// Three vertices for each triangle; it is seen from both sides.
    pub indices: &'a [u32],
    /// From the mesh's space to the world, column by column.
    pub mesh_to_world: [f32; 16],
    /// The light that comes from it, linear: as lit where it stands, since no light is computed for it.
    pub color: [f32; 3],
}

/// Triangles of the scene, in which `unified` and `traced` follow the rays that the screen loses: what a ray meets there has
/// its mesh's colour. Where something moved, make them anew, and keep the old ones until the device is done.
pub struct Triangles {
    frames: FrameContext,
    unlit: UnlitTriangles,
    is_recorded: bool,
}

impl Triangles {
    /// Builds the tree over the triangles on the CPU, and makes the buffers; [`record_upload`](Self::record_upload) fills
    /// them. It needs the crate's feature `tree`.
    ///
    /// # Errors
    /// [`Error::Usage`] with the number of a mesh that is wrong, and why; [`Error::Memory`] without memory.
    #[cfg(feature = "tree")]
    pub fn new(context: &Context, meshes: &[TriangleMesh]) -> Result<Self> {
        let meshes: Vec<(Mesh, Material)> =
            meshes.iter().enumerate().map(|(number, mesh)| mesh.take(number)).collect::<Result<_>>()?;
        let (meshes, materials) = meshes.into_iter().unzip();
        let scene = Scene { name: "of triangles".into(), meshes, materials, ..Scene::default() };
        let tree = Tree::build(&scene)?;
        let records = TriangleRecords::new(&scene, &tree);
        let unlit = UnlitTriangles::new(&context.gpu, &tree, &records, &scene.materials)?;
        Ok(Self { frames: FrameContext::in_others(&context.gpu, 1)?, unlit, is_recorded: false })
    }

    /// Records copying the triangles to the device: once, before the first frame that sees them.
    ///
    /// # Errors
    /// [`Error::Usage`] if it was recorded before; [`Error::Vulkan`] from the device.
    ///
    /// # Safety
    /// The contract is that of [`Reflections::record`](super::Reflections::record).
    pub unsafe fn record_upload(&mut self, commands: vk::CommandBuffer) -> Result<()> {
        if self.is_recorded {
            return Err(Error::Usage("the triangles were uploaded before: make others where something moved".into()));
        }
        // SAFETY: by the contract.
        let mut frame = unsafe { self.frames.begin_in(commands, 0, Mode::Plain) }?;
        self.unlit.record(&mut frame)?;
        frame.end()?;
        self.is_recorded = true;
        Ok(())
    }

    /// The triangles as methods take them.
    ///
    /// # Errors
    /// [`Error::Usage`] if they were never uploaded.
    pub(super) fn bound(&self) -> Result<TriangleBuffers<'_>> {
        if !self.is_recorded {
            return Err(Error::Usage("the triangles were never uploaded: record_upload comes first".into()));
        }
        Ok(self.unlit.bound())
    }

    /// How shaders read them, which every frame has in common.
    pub(super) fn reading(&self) -> TriangleReading {
        self.unlit.reading()
    }
}

#[cfg(feature = "tree")]
impl TriangleMesh<'_> {
    /// The mesh in world space, with its colour as a material.
    fn take(&self, number: usize) -> Result<(Mesh, Material)> {
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
        let vertex = |p: &Vec3| Vertex {
            position: p.to_array(),
            normal: [0.0, 1.0, 0.0],
            uv: [0.0; 2],
            tangent: [1.0, 0.0, 0.0, 1.0],
        };
        let mesh = Mesh {
            name: String::new(),
            vertices: places.iter().map(vertex).collect(),
            indices: indices.to_vec(),
            material: number,
            bounds: Aabb::ALL,
        };
        // What emits all of its albedo has that colour under every light.
        Ok((mesh, Material { albedo: color, emission: 1.0, ..Material::default() }))
    }
}
