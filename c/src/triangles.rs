//! Triangles of the scene.

use crate::border::{Guarded, Outcome, SsctResult, array, create, destroy, guard, needed, needed_mut};
use crate::context::SsctContext;
use crate::vulkan::VkCommandBuffer;
use ssct::{TriangleMesh, Triangles};

/// Triangles of the scene, in which "unified" and "traced" follow the rays that the screen loses: what a ray meets there has
/// its mesh's colour. Where something moved, make them anew, and keep the old ones until the device is done.
pub struct SsctTriangles {
    pub(crate) triangles: Guarded<Triangles>,
}

/// A mesh, where it stands, and the colour that it has in reflections. The library keeps no pointer to it.
#[repr(C)]
pub struct SsctTriangleMesh {
    /// Places of the vertices, in the mesh's own space: x, y and z of each, one after the other.
    pub positions: *const f32,
    /// Three vertices for each triangle; it is seen from both sides.
    pub indices: *const u32,
    /// Number of vertices.
    pub vertex_count: u32,
    /// Number of indices.
    pub index_count: u32,
    /// From the mesh's space to the world, column by column.
    pub mesh_to_world: [f32; 16],
    /// The light that comes from it, linear: as lit where it stands, since no light is computed for it.
    pub color: [f32; 3],
}

/// Builds the tree over the triangles of meshes on the CPU, makes the buffers, and writes the object to `triangles`; NULL if
/// it fails. `ssct_triangles_record_upload` fills the buffers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_triangles_create(
    context: *const SsctContext,
    meshes: *const SsctTriangleMesh,
    mesh_count: u32,
    triangles: *mut *mut SsctTriangles,
) -> SsctResult {
    let make = || {
        // SAFETY: the header asks for such pointers.
        let (context, meshes) = unsafe { (needed("context", context)?, array("meshes", meshes, mesh_count)?) };
        // SAFETY: as above.
        let taken: Vec<_> = meshes.iter().map(|m| unsafe { mesh(m) }).collect::<Outcome<_>>()?;
        Ok(SsctTriangles { triangles: Guarded::new(Triangles::new(&context.context, &taken)?) })
    };
    // SAFETY: the header asks for a valid place.
    unsafe { create("triangles", triangles, make) }
}

/// Destroys triangles; NULL is none. The device is done with every frame that saw them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_triangles_destroy(triangles: *mut SsctTriangles) {
    // SAFETY: the header asks for an object that is not yet destroyed.
    unsafe { destroy(triangles) };
}

/// Records copying the triangles to the device: once, before the first frame that sees them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_triangles_record_upload(
    triangles: *mut SsctTriangles,
    commands: VkCommandBuffer,
) -> SsctResult {
    guard(|| {
        // SAFETY: the header asks for such a pointer.
        let triangles = unsafe { needed_mut("triangles", triangles) }?;
        // SAFETY: the header asks for what this does of the command buffer.
        triangles.triangles.with(|triangles| Ok(unsafe { triangles.record_upload(commands) }?))
    })
}

/// A mesh as the door takes it.
///
/// # Safety
/// The pointers are NULL or to as many numbers as the counts say.
unsafe fn mesh(mesh: &SsctTriangleMesh) -> Outcome<TriangleMesh<'_>> {
    // SAFETY: by the contract.
    let (positions, indices) = unsafe {
        (
            array("mesh.positions", mesh.positions.cast::<[f32; 3]>(), mesh.vertex_count)?,
            array("mesh.indices", mesh.indices, mesh.index_count)?,
        )
    };
    Ok(TriangleMesh { positions, indices, mesh_to_world: mesh.mesh_to_world, color: mesh.color })
}
