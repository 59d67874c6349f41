//! A scene in device memory: vertices, indices, material maps with their mip chains, and the sky.

mod drawn_captures;
mod triangles;

use super::triangle_scene::{TriangleGeometry, TriangleImages};
use crate::error::{Error, Result};
use crate::gpu::shader::{LightBlock, LightData};
use crate::gpu::sync::Access;
use crate::gpu::{Buffer, FrameContext, Gpu, Image, ImageDesc, RayStructure, image, memory::MemoryPlace};
use ash::vk;
pub(crate) use drawn_captures::{DrawingCost, DrawnCaptures};
use glam::{Mat4, Vec3};
use ssct_ground::math::constants;
use ssct_ground::scene::capture::{BOUNDS_MARGIN, WantedCaptures};
use ssct_ground::scene::planes::{CoplanarGroup, coplanar_groups};
use ssct_ground::scene::sky::SkyCube;
use ssct_ground::scene::tree::BuildTrees;
use ssct_ground::scene::{
    Aabb, AreaLight, Capture, Encoding, Impostor, Light, Mesh, Placement, Probe, Scene, Texture, Vertex, sky,
};
use std::cell::{Cell, OnceCell, RefCell};
use std::rc::Rc;
use std::sync::OnceLock;
use std::time::Instant;

/// The most lights that a scene can have, which is the length of the array in `LightBlock` (`scene/lit.glsl`).
pub const MAX_LIGHTS: usize = constants::MAX_LIGHTS as usize;

/// Side of a face of the sky's cube map, in texels.
const SKY_SIZE: u32 = 256;

/// A scene on the device, from which the scene passes draw.
pub struct SceneData {
    pub(super) meshes: Vec<MeshData>,
    pub(super) textures: Vec<Image>,
    encodings: Vec<Encoding>,
    /// A white texel, for materials without a map.
    pub(super) white: Image,
    /// The environment as a cube map in world axes.
    pub(super) sky: Image,
    pub(super) lights: Vec<Light>,
    probes: Vec<Probe>,
    /// The captures that the scene names itself.
    captures: Vec<Capture>,
    find_captures: Option<FindCaptures>,
    trees: Option<Box<dyn BuildTrees>>,
    /// The names of the meshes that have moved, whose triangles have a tree of their own.
    moving_names: Vec<String>,
    /// Whether any of these meshes has moved since their tree was built.
    has_moved: Cell<bool>,
    /// Milliseconds that building the tree of moving meshes took; `None` once a frame has reported them.
    moving_ms: Cell<Option<f64>>,
    /// Built when rays are first followed among triangles, and again when a mesh moves for the first time.
    triangle_geometry: OnceCell<(TriangleGeometry, DrawingCost)>,
    triangle_images: OnceCell<(TriangleImages, DrawingCost)>,
    /// Built when rays first need it for ray queries, and again after a mesh has moved.
    ray_structure: OnceCell<(RayStructure, DrawingCost)>,
    /// Whether shaders read triangles as storage blocks, and never as texels.
    triangles_as_blocks: bool,
    /// The results of [`Self::captures`] so far, by its argument.
    found_captures: RefCell<Vec<(WantedCaptures, PlacedCaptures)>>,
    /// The captures that were drawn last; `None` once a mesh or a light has changed.
    drawn_captures: RefCell<Option<DrawnCaptures>>,
    pub(super) impostors: Vec<Impostor>,
    pub(super) area_lights: Vec<AreaLight>,
    planes: Vec<CoplanarGroup>,
}

/// A function that returns the wanted captures of a scene, given the captures that the scene names itself.
pub type FindCaptures = Box<dyn Fn(&[Capture], WantedCaptures) -> Vec<Capture>>;

/// Captures of a scene at their places.
#[derive(Debug, Clone)]
pub struct PlacedCaptures {
    /// The captures: first those that the scene names, then those that show most of what the ones before do not.
    pub captures: Rc<[Capture]>,
    /// Milliseconds that finding the places took.
    pub time_ms: f64,
}

/// An object of the scene that may move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovableObject {
    /// The number of the object's first triangle, and the number behind its last.
    pub triangles: [u32; 2],
    /// Where the object stands, relative to where it stood at first.
    pub placement: Placement,
}

/// A mesh in device memory.
pub(super) struct MeshData {
    pub vertices: Buffer,
    /// The triangles, the last one first. Where triangles coincide, the one drawn last shows: the first of the scene.
    pub indices: Buffer,
    pub index_count: u32,
    /// The number of the mesh's first triangle among those of the scene.
    pub first_triangle: u32,
    pub material: usize,
    pub bounds: Aabb,
    name: String,
    /// Where the mesh stands, relative to where it was uploaded.
    pub placement: Placement,
}

impl MeshData {
    /// Returns the number of the mesh's last triangle among those of the scene.
    pub fn last_triangle(&self) -> u32 {
        self.first_triangle + self.index_count / 3 - 1
    }
}

impl SceneData {
    /// Uploads a scene.
    ///
    /// # Errors
    /// [`Error::Usage`] for a scene with more lights than are drawn, or a mesh with more vertices or indices than the
    /// device can draw; [`Error::Memory`] without memory.
    pub fn upload(context: &mut FrameContext, scene: &Scene) -> Result<Self> {
        check_lights(&format!("scene {}", scene.name), &scene.lights)?;
        let mut meshes = Vec::with_capacity(scene.meshes.len());
        let mut triangles = 0;
        for mesh in scene.meshes.iter().filter(|m| !m.indices.is_empty()) {
            let first_triangle = triangles;
            triangles += mesh.indices.len() as u32 / 3;
            let last_first: Vec<[u32; 3]> = mesh.indices.as_chunks().0.iter().rev().copied().collect();
            meshes.push(MeshData {
                first_triangle,
                vertices: device_buffer(
                    context,
                    &mesh.name,
                    bytemuck::cast_slice::<Vertex, u8>(&mesh.vertices),
                    vk::BufferUsageFlags::VERTEX_BUFFER,
                )?,
                indices: device_buffer(
                    context,
                    &mesh.name,
                    bytemuck::cast_slice(&last_first),
                    vk::BufferUsageFlags::INDEX_BUFFER,
                )?,
                index_count: index_count(mesh, context.gpu().max_vertices())?,
                material: mesh.material,
                bounds: mesh.bounds,
                name: mesh.name.clone(),
                placement: Placement::HERE,
            });
        }
        // Meshes of one material are drawn one after the other, so that materials are bound less often.
        meshes.sort_by_key(|m| m.material);
        let textures = scene.textures.iter().map(|image| upload_texture(context, image)).collect::<Result<_>>()?;
        let white =
            Texture { name: "white".into(), width: 1, height: 1, rgba: vec![255; 4], encoding: Encoding::Linear };
        Ok(Self {
            meshes,
            textures,
            encodings: scene.textures.iter().map(|t| t.encoding).collect(),
            white: upload_texture(context, &white)?,
            sky: environment(context)?,
            lights: scene.lights.clone(),
            probes: probes_or_middle(scene),
            captures: scene.captures.clone(),
            find_captures: None,
            trees: None,
            moving_names: Vec::new(),
            has_moved: Cell::new(false),
            moving_ms: Cell::new(None),
            triangle_geometry: OnceCell::new(),
            triangle_images: OnceCell::new(),
            ray_structure: OnceCell::new(),
            triangles_as_blocks: false,
            found_captures: RefCell::default(),
            drawn_captures: RefCell::default(),
            impostors: scene.impostors.clone(),
            area_lights: scene.area_lights.clone(),
            planes: coplanar_groups(scene),
        })
    }

    /// Returns a box in the world, in metres, outside of which nothing stands: the box around all meshes where they
    /// stand now, grown by [`BOUNDS_MARGIN`]. Without meshes the box is all of space.
    pub fn bounds(&self) -> Aabb {
        let boxes = self.meshes.iter().map(|mesh| mesh.bounds.placed(&mesh.placement));
        boxes.fold(Aabb::default(), Aabb::union).grown(BOUNDS_MARGIN)
    }

    /// The sky as a cube map in world axes: six faces in Vulkan's order, one level. RGBA16F.
    pub fn sky(&self) -> &Image {
        &self.sky
    }

    /// Returns the captures in which rays are followed: those that the scene names itself, or those that the function of
    /// [`Self::set_capture_finder`] finds at the first call. Empty if the scene has no place for a capture.
    pub fn captures(&self, wanted: WantedCaptures) -> PlacedCaptures {
        let mut found_captures = self.found_captures.borrow_mut();
        if let Some((_, known)) = found_captures.iter().find(|(request, _)| *request == wanted) {
            return known.clone();
        }
        let begun = Instant::now();
        let captures = match (&self.find_captures, wanted) {
            (Some(find), _) => find(&self.captures, wanted),
            (None, WantedCaptures::Auto) => self.captures.clone(),
            (None, WantedCaptures::Count(most)) => self.captures.iter().take(most).copied().collect(),
        };
        let found = PlacedCaptures { captures: captures.into(), time_ms: 1e3 * begun.elapsed().as_secs_f64() };
        found_captures.push((wanted, found.clone()));
        found
    }

    /// Returns the uniform block of the lights, in the space into which `world_to_space` turns and moves the world.
    pub fn light_block(&self, world_to_space: Mat4) -> LightBlock {
        let mut block = LightBlock { count: self.lights.len() as u32, ..LightBlock::default() };
        for (data, light) in block.lights.iter_mut().zip(&self.lights) {
            let (place, energy) = match *light {
                Light::Point { position, energy } => (world_to_space.transform_point3(position).extend(1.0), energy),
                Light::Directional { direction, energy } => {
                    (-world_to_space.transform_vector3(direction).normalize().extend(0.0), energy)
                }
            };
            *data = LightData { place: place.to_array(), energy: [energy, 0.0, 0.0, 0.0] };
        }
        block
    }

    /// Replaces the lights. Images that were captured of the scene show the old lights until they are captured again.
    ///
    /// # Errors
    /// [`Error::Usage`] for more lights than are drawn.
    pub fn set_lights(&mut self, lights: &[Light]) -> Result<()> {
        check_lights("the scene", lights)?;
        self.lights = lights.to_vec();
        self.drawn_captures.take();
        Ok(())
    }

    /// Places the meshes of a name relative to where they were uploaded, for example by an offset in metres along the world's axes.
    /// Images that were captured of the scene show the meshes where they stood, until they are captured again. Places of captures,
    /// and the planes that mirror, stay those of the scene that was uploaded.
    ///
    /// # Errors
    /// [`Error::Usage`] for a placement whose numbers are not finite, and if no mesh has the name.
    pub fn place_meshes(&mut self, name: &str, placement: impl Into<Placement>) -> Result<()> {
        let placement = placement.into();
        if !placement.is_sound() {
            let Placement { turn, size, offset } = placement;
            return Err(Error::Usage(format!(
                "mesh {name} cannot be placed at {offset}, turned by {turn}, {size} times as large: numbers must be finite, and \
                 the size above 0"
            )));
        }
        let mut has_name = false;
        let mut is_new_placement = false;
        for mesh in self.meshes.iter_mut().filter(|m| m.name == name) {
            has_name = true;
            is_new_placement |= mesh.placement != placement;
            mesh.placement = placement;
        }
        if !has_name {
            return Err(Error::Usage(format!("the scene has no mesh {name:?}")));
        }
        if is_new_placement {
            self.ray_structure.take();
            self.drawn_captures.take();
            self.has_moved.set(true);
            if !self.moving_names.iter().any(|mesh_name| mesh_name == name) {
                self.moving_names.push(name.to_owned());
                self.triangle_geometry.take();
            }
        }
        Ok(())
    }

    /// Returns each mesh as an object that may move, with its present placement.
    pub fn movable_objects(&self) -> Vec<MovableObject> {
        let object = |mesh: &MeshData| MovableObject {
            triangles: [mesh.first_triangle, mesh.first_triangle + mesh.index_count / 3],
            placement: mesh.placement,
        };
        self.meshes.iter().map(object).collect()
    }

    /// Replaces the captures that the scene names itself. If there are none, captures are found.
    pub fn set_captures(&mut self, captures: Vec<Capture>) {
        self.captures = captures;
        self.found_captures.get_mut().clear();
    }

    /// Sets the function that finds captures beyond those that the scene names itself. An effect that wants captures
    /// calls the function, once for each number of captures. Without the function the scene has only its own captures.
    pub fn set_capture_finder(&mut self, find: impl Fn(&[Capture], WantedCaptures) -> Vec<Capture> + 'static) {
        self.find_captures = Some(Box::new(find));
        self.found_captures.get_mut().clear();
    }

    /// How many lights there are.
    pub fn light_count(&self) -> u32 {
        self.lights.len() as u32
    }

    /// The rectangles that stand for objects in reflections.
    pub fn impostors(&self) -> &[Impostor] {
        &self.impostors
    }

    /// The places where cube maps are captured, at least one.
    pub fn probes(&self) -> &[Probe] {
        &self.probes
    }

    /// The planes that the scene's triangles share, the largest first.
    pub fn coplanar_groups(&self) -> &[CoplanarGroup] {
        &self.planes
    }
}

/// Checks that no more lights are given than can be drawn. `subject` begins the error's sentence.
fn check_lights(subject: &str, lights: &[Light]) -> Result<()> {
    let count = lights.len();
    if count > MAX_LIGHTS {
        return Err(Error::Usage(format!("{subject} has {count} lights; at most {MAX_LIGHTS} can be drawn")));
    }
    Ok(())
}

/// Returns the number of a mesh's indices. The device's indices tell at most `max_vertices` vertices apart.
fn index_count(mesh: &Mesh, max_vertices: u64) -> Result<u32> {
    let (name, vertices, indices) = (&mesh.name, mesh.vertices.len(), mesh.indices.len());
    match u32::try_from(indices) {
        Ok(count) if vertices as u64 <= max_vertices => Ok(count),
        _ => Err(Error::Usage(format!(
            "mesh {name} has {vertices} vertices and {indices} indices; the device draws at most {max_vertices} and {} \
             of one mesh",
            u32::MAX
        ))),
    }
}

/// Returns the scene's probes, or one probe in the scene's middle if the scene names none.
fn probes_or_middle(scene: &Scene) -> Vec<Probe> {
    if !scene.probes.is_empty() {
        return scene.probes.clone();
    }
    let bounds = scene.bounds();
    // Without meshes there are no bounds, and any box serves.
    let is_bounded = bounds.min.is_finite() && bounds.max.is_finite();
    vec![Probe::in_the_middle_of(if is_bounded { bounds } else { Aabb { min: Vec3::NEG_ONE, max: Vec3::ONE } })]
}

/// Fails if a scene has more of something than a method can take.
pub(super) fn check_at_most(what: &str, count: usize, most: usize, method: &str) -> Result<()> {
    if count > most {
        return Err(Error::Usage(format!("the scene has {count} {what}; the method {method} takes at most {most}")));
    }
    Ok(())
}

/// Makes a buffer in device memory that holds `bytes`, from which draws read vertices or indices.
fn device_buffer(context: &mut FrameContext, name: &str, bytes: &[u8], usage: vk::BufferUsageFlags) -> Result<Buffer> {
    let gpu: Gpu = context.gpu().clone();
    let staging = Buffer::upload(&gpu, "staging", bytes, vk::BufferUsageFlags::TRANSFER_SRC)?;
    let buffer =
        Buffer::new(&gpu, name, bytes.len() as u64, usage | vk::BufferUsageFlags::TRANSFER_DST, MemoryPlace::Device)?;
    context.once(|frame| frame.copy_buffer("upload", &staging, &buffer, Access::VertexInput))?;
    Ok(buffer)
}

/// Makes a material map with its mip chain, ready for fragment shaders.
fn upload_texture(context: &mut FrameContext, texture: &Texture) -> Result<Image> {
    use vk::ImageUsageFlags as U;
    let (name, extent) = (&texture.name, [texture.width, texture.height]);
    let format = match texture.encoding {
        Encoding::Srgb => vk::Format::R8G8B8A8_SRGB,
        Encoding::Linear => vk::Format::R8G8B8A8_UNORM,
    };
    let (levels, usage) = (image::full_chain(extent), U::SAMPLED | U::TRANSFER_DST | U::TRANSFER_SRC);
    let map = Image::new(context.gpu(), &ImageDesc { name, format, extent, levels, layers: 1, usage })?;
    let staging = Buffer::upload(context.gpu(), "staging", &texture.rgba, vk::BufferUsageFlags::TRANSFER_SRC)?;
    context.once(|frame| {
        frame.upload("upload", &staging, map.level(0))?;
        for level in 1..map.levels() {
            frame.blit("material mip", map.level(level - 1), map.level(level))?;
        }
        frame.make_ready(map.all(), Access::FragmentSampled);
        Ok(())
    })?;
    Ok(map)
}

/// Makes the generated sky as a cube map in world axes: six faces in Vulkan's order, one level. RGBA16F.
pub fn environment(context: &mut FrameContext) -> Result<Image> {
    // Every scene has this sky, so that a process computes its texels once.
    static HALVES: OnceLock<Vec<u16>> = OnceLock::new();
    sky_image(context, SKY_SIZE, HALVES.get_or_init(|| halves(sky::cube_map(SKY_SIZE).iter().flatten())))
}

/// Uploads a sky that comes from elsewhere as a cube map like that of [`environment`], rounded to its format.
pub fn upload_sky(context: &mut FrameContext, cube: &SkyCube) -> Result<Image> {
    let texels: Vec<[f32; 4]> = cube.texels.iter().map(|t| t.extend(1.0).to_array()).collect();
    sky_image(context, cube.side, &halves(&texels))
}

/// Returns the components of texels as the bits of 16-bit floats.
fn halves<'t>(texels: impl IntoIterator<Item = &'t [f32; 4]>) -> Vec<u16> {
    texels.into_iter().flatten().map(|value| half_bits(*value)).collect()
}

/// Returns the bits of a number as a 16-bit float, clamped to the range of such floats.
pub(super) fn half_bits(number: f32) -> u16 {
    let greatest = half::f16::MAX.to_f32();
    half::f16::from_f32(number.clamp(-greatest, greatest)).to_bits()
}

/// Uploads six faces of 16-bit RGBA floats as a cube map, ready for fragment shaders.
fn sky_image(context: &mut FrameContext, side: u32, halves: &[u16]) -> Result<Image> {
    use vk::ImageUsageFlags as U;
    let usage = U::SAMPLED | U::TRANSFER_DST | U::TRANSFER_SRC;
    let desc = ImageDesc::one_level("sky", vk::Format::R16G16B16A16_SFLOAT, [side, side], usage);
    let cube = Image::new(context.gpu(), &ImageDesc { layers: 6, ..desc })?;
    let staging =
        Buffer::upload(context.gpu(), "staging", bytemuck::cast_slice(halves), vk::BufferUsageFlags::TRANSFER_SRC)?;
    context.once(|frame| {
        frame.upload("upload", &staging, cube.level(0))?;
        frame.make_ready(cube.all(), Access::FragmentSampled);
        Ok(())
    })?;
    Ok(cube)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_with_more_vertices_than_indices_can_tell_apart_is_refused() {
        let mesh = Mesh {
            name: "dust".into(),
            vertices: vec![bytemuck::Zeroable::zeroed(); 5],
            indices: vec![0, 1, 4],
            ..Mesh::default()
        };
        assert_eq!(index_count(&mesh, 5).unwrap(), 3);
        let message = index_count(&mesh, 4).unwrap_err().to_string();
        assert_eq!(
            message,
            "mesh dust has 5 vertices and 3 indices; the device draws at most 4 and 4294967295 of one mesh"
        );
    }
}
