//! Triangles of the scene.

use crate::border::{Guarded, Outcome, SsctResult, create, destroy, guard, to_slice};
use crate::context::SsctContext;
use crate::live;
use crate::vulkan::{VkBool32, VkCommandBuffer};
use ash::vk;
use ssct::{HitTexture, MeshTexture, TriangleMesh, Triangles};
use std::ptr::null;

/// Triangles of the scene, among which the methods "unified" and "traced" follow rays. A ray that hits a triangle sees
/// the colour or the texture of the triangle's mesh. If something moved, make new triangles, and keep the old ones
/// until the device is done with them.
pub struct SsctTriangles {
    pub(crate) triangles: Guarded<Triangles>,
}

/// A mesh, where it stands, and the light that comes from it in reflections. The library keeps no pointer to the
/// struct. Set the struct to zero before you fill it in, so that the mesh has no texture unless you give it one.
#[repr(C)]
pub struct SsctTriangleMesh {
    /// Places of the vertices, in the mesh's own space: x, y and z of each vertex, one vertex after the other.
    pub positions: *const f32,
    /// Three indices of vertices for each triangle. Triangles are seen from both sides.
    pub indices: *const u32,
    /// Number of vertices.
    pub vertex_count: u32,
    /// Number of indices.
    pub index_count: u32,
    /// The matrix from the mesh's space to the world, column by column.
    pub mesh_to_world: [f32; 16],
    /// The light that comes from the mesh, linear. Give the colour of the mesh as your lights make it, since the
    /// library does not light meshes. With a texture, the colour is a factor of the texture.
    pub color: [f32; 3],
    /// The number of the mesh's texture among those of `ssct_triangles_create_textured`; read only with `texture_places`.
    pub texture: u32,
    /// The texture coordinates of each vertex, two numbers each: (0, 0) is the corner of the first texel, (1, 1) that
    /// of the last. Outside of this range the texture repeats. NULL for a mesh without a texture.
    pub texture_places: *const f32,
}

/// A texture of the light that comes from meshes. Rays interpolate between four texels of the mip level whose texels are nearest in
/// size to the ray's footprint. The library makes the levels, and keeps no pointer to the struct.
#[repr(C)]
pub struct SsctHitTexture {
    /// Four bytes for each texel: red, green, blue, and a byte that is not read. Rows begin at the top.
    pub texels: *const u8,
    /// Width in texels, 1 to 32768.
    pub width: u32,
    /// Height in texels, 1 to 32768.
    pub height: u32,
    /// Whether the bytes are sRGB; otherwise they are linear.
    pub is_srgb: VkBool32,
}

/// Builds the tree over the triangles of meshes on the CPU, makes the buffers, and writes the object to `triangles`; NULL if the
/// call fails. `ssct_triangles_record_upload` fills the buffers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_triangles_create(
    context: *const SsctContext,
    meshes: *const SsctTriangleMesh,
    mesh_count: u32,
    triangles: *mut *mut SsctTriangles,
) -> SsctResult {
    // SAFETY: the header asks the same of the arguments of both functions.
    unsafe { ssct_triangles_create_textured(context, meshes, mesh_count, null(), 0, triangles) }
}

/// Does the same as `ssct_triangles_create`, for meshes with textures.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_triangles_create_textured(
    context: *const SsctContext,
    meshes: *const SsctTriangleMesh,
    mesh_count: u32,
    textures: *const SsctHitTexture,
    texture_count: u32,
    triangles: *mut *mut SsctTriangles,
) -> SsctResult {
    let make = || {
        // SAFETY: the header asks for such pointers.
        let (context, meshes) = unsafe { (live::read("context", context)?, to_slice("meshes", meshes, mesh_count)?) };
        // SAFETY: the header asks for such pointers.
        let textures = unsafe { to_slice("textures", textures, texture_count) }?;
        // SAFETY: the header asks for such pointers.
        let meshes: Vec<_> = meshes.iter().map(|m| unsafe { borrow_mesh(m) }).collect::<Outcome<_>>()?;
        // SAFETY: the header asks for such pointers.
        let textures: Vec<_> = textures.iter().map(|t| unsafe { borrow_texture(t) }).collect::<Outcome<_>>()?;
        let triangles = Triangles::with_textures(&context.context, &meshes, &textures)?;
        Ok(SsctTriangles { triangles: Guarded::new(triangles) })
    };
    // SAFETY: the header asks for a valid place.
    unsafe { create("triangles", triangles, make) }
}

/// Destroys triangles; NULL is allowed. The device must be done with every frame that saw the triangles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_triangles_destroy(triangles: *mut SsctTriangles) {
    // SAFETY: the header asks for an object that is not yet destroyed.
    unsafe { destroy(triangles) };
}

/// Records the copy of the triangles to the device. Call it once, before the first frame that sees them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_triangles_record_upload(
    triangles: *mut SsctTriangles,
    commands: VkCommandBuffer,
) -> SsctResult {
    guard(|| {
        // SAFETY: the header asks for such a pointer.
        let mut triangles = unsafe { live::write("triangles", triangles) }?;
        // SAFETY: the header asks the caller for the same of the command buffer.
        triangles.triangles.with(|triangles| Ok(unsafe { triangles.record_upload(commands) }?))
    })
}

/// Borrows the caller's mesh as the Rust interface's type.
///
/// # Safety
/// Each pointer is NULL or points to as many numbers as its count says.
unsafe fn borrow_mesh(mesh: &SsctTriangleMesh) -> Outcome<TriangleMesh<'_>> {
    // SAFETY: the caller keeps to the contract of this function.
    let (positions, indices) = unsafe {
        (
            to_slice("mesh.positions", mesh.positions.cast::<[f32; 3]>(), mesh.vertex_count)?,
            to_slice("mesh.indices", mesh.indices, mesh.index_count)?,
        )
    };
    let SsctTriangleMesh { mesh_to_world, color, texture, texture_places, vertex_count, .. } = *mesh;
    let texture = if texture_places.is_null() {
        None
    } else {
        // SAFETY: the caller keeps to the contract of this function.
        let places = unsafe { to_slice("mesh.texture_places", texture_places.cast::<[f32; 2]>(), vertex_count) }?;
        Some(MeshTexture { number: texture as usize, places })
    };
    Ok(TriangleMesh { positions, indices, mesh_to_world, color, texture })
}

/// Borrows the caller's texture as the Rust interface's type.
///
/// # Safety
/// The pointer is NULL or points to as many bytes as width and height say.
unsafe fn borrow_texture(texture: &SsctHitTexture) -> Outcome<HitTexture<'_>> {
    let SsctHitTexture { texels, width, height, is_srgb } = *texture;
    // `Triangles::with_textures` refuses a texture that is too large, so that none of its texels is borrowed here.
    let count = if width.max(height) > HitTexture::MAX_SIDE { 0 } else { width * height };
    // SAFETY: the caller keeps to the contract of this function.
    let texels = unsafe { to_slice("texture.texels", texels.cast::<[u8; 4]>(), count) }?;
    Ok(HitTexture { extent: [width, height], is_srgb: is_srgb != vk::FALSE, texels: texels.as_flattened() })
}
