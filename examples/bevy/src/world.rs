//! Gathers the world's meshes as triangles, each with the light that comes from its surface. The meshes are gathered
//! anew when one of them changes, and the render world then builds a tree over their triangles.

use crate::device::Result;
use bevy::asset::AssetEvent;
use bevy::ecs::query::Or;
use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;
use bevy::render::Extract;
use std::collections::HashMap;
use std::sync::Arc;
use wgpu::TextureFormat;

/// A mesh with its place in the world.
pub struct WorldMesh {
    /// The vertices' positions in the space of the mesh.
    positions: Vec<[f32; 3]>,
    /// Three vertices for each triangle.
    indices: Vec<u32>,
    /// The matrix from the space of the mesh to the world, column by column.
    mesh_to_world: [f32; 16],
    /// The linear light that leaves the surface; a factor on the texture if there is one.
    color: [f32; 3],
    /// The number of an image in [`WorldMeshes::images`], and the texture coordinates of each vertex.
    texture: Option<(usize, Vec<[f32; 2]>)>,
}

/// An image of base colours, four bytes a texel.
pub struct WorldImage {
    extent: [u32; 2],
    is_srgb: bool,
    rgba: Vec<u8>,
}

/// The meshes of the main world.
#[derive(Resource, Clone, Default)]
pub struct WorldMeshes {
    /// How often the meshes were gathered.
    pub changes: u64,
    pub meshes: Arc<Vec<WorldMesh>>,
    /// The images of base colours that the meshes use.
    pub images: Arc<Vec<WorldImage>>,
    /// True if lights shine on any of the meshes. The colour of such a mesh here is a guess.
    pub is_lit: bool,
}

/// The brightness of lit surfaces in reflections, as a factor on their base colour. It is a guess, since no lighting is
/// computed where a ray hits a mesh. Unlit and emissive colours are exact without it.
#[derive(Resource, Clone, Copy)]
pub struct LightOnMeshes(pub LinearRgba);

impl Default for LightOnMeshes {
    fn default() -> Self {
        Self(LinearRgba::rgb(0.5, 0.5, 0.5))
    }
}

/// Leaves an entity's mesh out of the triangles that rays are traced among.
#[derive(Component, Clone, Copy, Default)]
pub struct NotReflected;

/// The components of a mesh that [`gather`] reads.
type Drawn = (
    &'static Mesh3d,
    &'static MeshMaterial3d<StandardMaterial>,
    &'static GlobalTransform,
    Option<&'static InheritedVisibility>,
);
/// Matches an entity if one of the components that [`gather`] reads has changed.
type Changed3d = Or<(
    Changed<Mesh3d>,
    Changed<MeshMaterial3d<StandardMaterial>>,
    Changed<GlobalTransform>,
    Changed<InheritedVisibility>,
)>;

/// Matches the entities whose change makes [`gather`] gather all meshes anew: meshes that it gathers, and those that it
/// no longer gathers.
type ChangedMeshes =
    Or<((With<MeshMaterial3d<StandardMaterial>>, Without<NotReflected>, Changed3d), Added<NotReflected>)>;
/// The entities that lost a component on which it depends whether [`gather`] gathers their mesh.
type Removed<'w, 's> = (
    RemovedComponents<'w, 's, Mesh3d>,
    RemovedComponents<'w, 's, MeshMaterial3d<StandardMaterial>>,
    RemovedComponents<'w, 's, NotReflected>,
);
/// Readers of the changes of meshes, materials and images.
type AssetEvents<'w, 's> = (
    MessageReader<'w, 's, AssetEvent<Mesh>>,
    MessageReader<'w, 's, AssetEvent<StandardMaterial>>,
    MessageReader<'w, 's, AssetEvent<Image>>,
);

/// Gathers all meshes anew if a mesh, a material, an image, [`LightOnMeshes`], or an entity with a mesh changed.
#[expect(clippy::too_many_arguments, reason = "each is a table of Bevy's")]
pub fn gather(
    mut world: ResMut<WorldMeshes>,
    light: Res<LightOnMeshes>,
    drawn: Query<Drawn, Without<NotReflected>>,
    changed: Query<(), ChangedMeshes>,
    (mut meshes_removed, mut materials_removed, mut marks_removed): Removed,
    (mut mesh_events, mut material_events, mut image_events): AssetEvents,
    meshes: Res<Assets<Mesh>>,
    (materials, images): (Res<Assets<StandardMaterial>>, Res<Assets<Image>>),
) {
    let asset_changes = mesh_events.read().count() + material_events.read().count() + image_events.read().count();
    let removed = meshes_removed.read().count() + materials_removed.read().count() + marks_removed.read().count();
    if changed.is_empty() && removed == 0 && asset_changes == 0 && !light.is_changed() {
        return;
    }
    let mut gathered = GatheredMeshes { light: light.0, ..default() };
    for (mesh, material, transform, visible) in &drawn {
        let (Some(mesh), Some(material)) = (meshes.get(&mesh.0), materials.get(&material.0)) else { continue };
        if visible.is_none_or(|visible| visible.get()) {
            gathered.add(mesh, material, transform, &images);
        }
    }
    let changes = world.changes + 1;
    let GatheredMeshes { meshes, images, is_lit, .. } = gathered;
    *world = WorldMeshes { changes, meshes: Arc::new(meshes), images: Arc::new(images), is_lit };
}

/// Hands the meshes to the render world.
pub fn extract(main: Extract<Res<WorldMeshes>>, mut world: ResMut<WorldMeshes>) {
    if world.changes != main.changes {
        *world = main.clone();
    }
}

/// The meshes and images that [`gather`] has found so far.
#[derive(Default)]
struct GatheredMeshes {
    /// The factor on the base colour of lit surfaces.
    light: LinearRgba,
    meshes: Vec<WorldMesh>,
    images: Vec<WorldImage>,
    is_lit: bool,
    /// The index of each asset in `images`; `None` for an image in a format that `ssct` cannot look up.
    places: HashMap<AssetId<Image>, Option<usize>>,
}

impl GatheredMeshes {
    /// Adds a mesh with its material and its place. A mesh that is no triangle list, or whose vertices are only in the
    /// render world, is left out.
    fn add(&mut self, mesh: &Mesh, material: &StandardMaterial, transform: &GlobalTransform, images: &Assets<Image>) {
        let Ok(VertexAttributeValues::Float32x3(positions)) = mesh.try_attribute(Mesh::ATTRIBUTE_POSITION) else {
            return;
        };
        if mesh.primitive_topology() != PrimitiveTopology::TriangleList {
            return;
        }
        let indices = match mesh.try_indices() {
            Ok(Indices::U16(indices)) => indices.iter().map(|index| u32::from(*index)).collect(),
            Ok(Indices::U32(indices)) => indices.clone(),
            Err(_) => (0..positions.len() as u32).collect(),
        };
        // A metal scatters no light: all its light is reflected.
        let base = material.base_color.to_linear() * if material.unlit { 1.0 } else { 1.0 - material.metallic };
        let light = if material.unlit { LinearRgba::WHITE } else { self.light };
        let emitted = if material.unlit { LinearRgba::BLACK } else { material.emissive };
        self.is_lit |= !material.unlit && material.metallic < 1.0;
        let texture = material.base_color_texture.as_ref().and_then(|image| self.image(image.id(), images));
        let texture = texture.and_then(|index| Some((index, places_on(mesh, material)?)));
        let channel = |base: f32, light: f32, emitted: f32| (base * light + emitted).max(0.0);
        self.meshes.push(WorldMesh {
            positions: positions.clone(),
            indices,
            mesh_to_world: transform.to_matrix().to_cols_array(),
            color: [
                channel(base.red, light.red, emitted.red),
                channel(base.green, light.green, emitted.green),
                channel(base.blue, light.blue, emitted.blue),
            ],
            texture,
        });
    }

    /// Returns the index of an asset in `self.images`, to which it is added if it is new. `None` if it is not loaded,
    /// or if it has a format that `ssct` cannot look up.
    fn image(&mut self, id: AssetId<Image>, images: &Assets<Image>) -> Option<usize> {
        let image = images.get(id)?;
        let next = self.images.len();
        *self.places.entry(id).or_insert_with(|| {
            let is_srgb = match image.texture_descriptor.format {
                TextureFormat::Rgba8UnormSrgb => true,
                TextureFormat::Rgba8Unorm => false,
                _ => return None,
            };
            let (width, height) = (image.width(), image.height());
            let texels = image.data.as_ref()?.get(..4 * width as usize * height as usize)?;
            self.images.push(WorldImage { extent: [width, height], is_srgb, rgba: texels.to_vec() });
            Some(next)
        })
    }
}

/// Returns the texture coordinates of a mesh's vertices on the image of base colours; `None` if the mesh has none.
fn places_on(mesh: &Mesh, material: &StandardMaterial) -> Option<Vec<[f32; 2]>> {
    match mesh.try_attribute(Mesh::ATTRIBUTE_UV_0) {
        Ok(VertexAttributeValues::Float32x2(places)) => {
            Some(places.iter().map(|place| material.uv_transform.transform_point2((*place).into()).into()).collect())
        }
        _ => None,
    }
}

impl WorldMeshes {
    /// Builds the tree over the triangles on the CPU.
    ///
    /// # Errors
    /// Returns the error of `ssct`.
    pub fn triangles(&self, context: &ssct::Context) -> Result<ssct::Triangles> {
        let textures: Vec<_> = self.images.iter().map(WorldImage::texture).collect();
        let meshes: Vec<_> = self.meshes.iter().map(WorldMesh::triangles).collect();
        Ok(ssct::Triangles::with_textures(context, &meshes, &textures)?)
    }
}

impl WorldImage {
    /// The image as `ssct` takes it.
    fn texture(&self) -> ssct::HitTexture<'_> {
        ssct::HitTexture { extent: self.extent, is_srgb: self.is_srgb, texels: &self.rgba }
    }
}

impl WorldMesh {
    /// The mesh as `ssct` takes it.
    fn triangles(&self) -> ssct::TriangleMesh<'_> {
        let Self { positions, indices, mesh_to_world, color, texture } = self;
        let texture = texture.as_ref().map(|(number, places)| ssct::MeshTexture { number: *number, places });
        ssct::TriangleMesh { positions, indices, mesh_to_world: *mesh_to_world, color: *color, texture }
    }
}
