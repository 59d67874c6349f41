//! Gathers the world's meshes as triangles, each with the light that comes from it. They are gathered anew when
//! something changed, and the render world builds a tree over them.

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
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
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

/// The meshes of the main world; `changes` counts how often they were gathered.
#[derive(Resource, Clone, Default)]
pub struct WorldMeshes {
    pub changes: u64,
    pub meshes: Arc<Vec<WorldMesh>>,
    pub images: Arc<Vec<WorldImage>>,
    /// True if lights shine on any of the meshes, whose colour here is a guess then.
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
/// Matches an entity of which one of the components that [`gather`] reads changed.
type Changed3d = Or<(
    Changed<Mesh3d>,
    Changed<MeshMaterial3d<StandardMaterial>>,
    Changed<GlobalTransform>,
    Changed<InheritedVisibility>,
)>;

type ChangedMeshes = (With<MeshMaterial3d<StandardMaterial>>, Without<NotReflected>, Changed3d);
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
    mut removed: RemovedComponents<Mesh3d>,
    (mut mesh_events, mut material_events, mut image_events): AssetEvents,
    meshes: Res<Assets<Mesh>>,
    (materials, images): (Res<Assets<StandardMaterial>>, Res<Assets<Image>>),
) {
    let of_assets = mesh_events.read().count() + material_events.read().count() + image_events.read().count();
    if changed.is_empty() && removed.read().count() == 0 && of_assets == 0 && !light.is_changed() {
        return;
    }
    let mut taken = GatheredMeshes { light: light.0, ..default() };
    for (mesh, material, transform, visible) in &drawn {
        let (Some(mesh), Some(material)) = (meshes.get(&mesh.0), materials.get(&material.0)) else { continue };
        if visible.is_none_or(|visible| visible.get()) {
            taken.add(mesh, material, transform, &images);
        }
    }
    let changes = world.changes + 1;
    let GatheredMeshes { meshes, images, is_lit, .. } = taken;
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
    light: LinearRgba,
    meshes: Vec<WorldMesh>,
    images: Vec<WorldImage>,
    is_lit: bool,
    /// The index of each asset in `images`; `None` for an image in a format that `ssct` cannot look up.
    places: HashMap<AssetId<Image>, Option<usize>>,
}

impl GatheredMeshes {
    /// Adds a mesh. Leaves it out if it is no triangle list, or if its vertices are in the render world alone.
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
        let texture = texture.and_then(|place| Some((place, places_on(mesh, material)?)));
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

    /// The index of an image in `images`, which it is added to first. `None` if it is not loaded or in another format.
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

/// The texture coordinates of the vertices on the image of base colours; `None` if the mesh has none.
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
    fn texture(&self) -> ssct::HitTexture<'_> {
        ssct::HitTexture { extent: self.extent, is_srgb: self.is_srgb, texels: &self.rgba }
    }
}

impl WorldMesh {
    fn triangles(&self) -> ssct::TriangleMesh<'_> {
        let Self { positions, indices, mesh_to_world, color, texture } = self;
        let texture = texture.as_ref().map(|(number, places)| ssct::MeshTexture { number: *number, places });
        ssct::TriangleMesh { positions, indices, mesh_to_world: *mesh_to_world, color: *color, texture }
    }
}
