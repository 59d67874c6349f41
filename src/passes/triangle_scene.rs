//! A scene's triangles in device memory, as the programs under `shaders-glsl/triangles/` read them: the tree with the
//! records of its triangles, and in `images` the texels of all images with their levels, and a table of materials.

mod images;

pub use images::{TriangleImages, TriangleTable};

use crate::error::Result;
use crate::gpu::memory::MemoryPlace;
use crate::gpu::program::RaySource;
use crate::gpu::programs::{TriangleConstants, TriangleResources};
use crate::gpu::ray_structure::{Corners, RayStructure};
use crate::gpu::shader::{LightBlock, TriangleBlock};
use crate::gpu::sync::Access;
use crate::gpu::{Buffer, Frame, FrameContext, Gpu, Sampled, TexelBuffer};
use ash::vk;
use glam::{DVec3, Mat4};
use ssct_ground::scene::Camera;
use ssct_ground::scene::tree::{MovingTriangles, NODE_WORDS, Tree, TriangleRecords, Words, most_levels};
use std::cell::{Cell, RefCell};

/// Format of [`GBuffer::triangle`](super::GBuffer::triangle).
pub const TRIANGLE: vk::Format = vk::Format::R32_UINT;

/// Bytes of a texel of the images.
const TEXEL_BYTES: u64 = 4;

/// Format and bytes of a vector of four words, in which shaders read geometry and materials.
pub(super) const VECTORS: (vk::Format, u64) = (vk::Format::R32G32B32A32_UINT, size_of::<Words>() as u64);

/// Format and bytes of a word, in which shaders read texels of images.
pub(super) const TEXELS: (vk::Format, u64) = (vk::Format::R32_UINT, TEXEL_BYTES);

/// The tree and the records of a scene's triangles, where its meshes stand.
pub struct TriangleGeometry {
    origin: DVec3,
    /// Where corners and attributes begin among the vectors of `buffer`, then the numbers of triangles and nodes.
    counts: [i32; 4],
    /// The greatest coordinate of a corner of a standing mesh, in metres.
    extent_m: f32,
    /// Whether some material has an alpha mask or is single-sided, so that a hit on it may not count.
    asks: bool,
    buffer: TexelBuffer,
    /// The triangles of moving meshes.
    moving: MovingPart,
    /// Where the parts of the vectors begin; `None` if nothing can move.
    places: Option<Places>,
}

/// The moving part of a scene's triangles, among the vectors of all. The moving corners come after those of standing
/// meshes, and the moving nodes after everything else. A walk begins with a second root for the moving part, and the
/// numbers of nodes and slots go on from the standing part.
#[derive(Default)]
struct MovingPart {
    /// The number of the root node; 0 without one.
    root: Cell<i32>,
    /// The greatest coordinate of a corner, in metres.
    extent_m: Cell<f32>,
    update: RefCell<Option<Update>>,
}

/// Vectors that are copied to their places in a frame.
struct Update {
    staging: Buffer,
    /// Source, target and length of each run of bytes; empty once the runs have been copied.
    runs: Vec<[u64; 3]>,
}

/// Where the parts of the vectors begin.
struct Places {
    /// Corners of standing meshes, then of moving ones, by slots.
    corners: usize,
    moving_corners: usize,
    attributes: usize,
    /// Nodes of moving meshes, at a multiple of the size of a node.
    root: usize,
    end: usize,
}

impl Places {
    /// Places the parts one after the other, with room for each moving triangle.
    fn new(tree: &Tree, records: &TriangleRecords, moving: &MovingTriangles) -> Self {
        let room = moving.numbers.len();
        let corners = tree.nodes.len();
        let moving_corners = corners + records.corners.len();
        let attributes = moving_corners + 3 * room;
        let behind = attributes + records.attributes.len();
        let root = behind.next_multiple_of(NODE_WORDS);
        // A hierarchy over some triangles has no more nodes than triangles.
        let end = if room == 0 { behind } else { root + NODE_WORDS * room };
        Self { corners, moving_corners, attributes, root, end }
    }

    /// Returns the moving part, as runs of vectors and their places.
    fn of_moving(&self, moving: &MovingTriangles) -> Vec<(usize, Vec<Words>)> {
        let slots = ((self.moving_corners - self.corners) / 3) as u32;
        let mut corners = moving.records.corners.clone();
        // Triangles that have no area at the moment have room, too.
        corners.resize(3 * moving.numbers.len(), [0; 4]);
        let nodes = moving.tree.nodes_behind((self.root / NODE_WORDS) as u32, slots);
        assert!(self.root + nodes.len() <= self.end.max(self.root), "more nodes than triangles");
        let attributes = moving.attributes_behind(slots).into_iter();
        let attributes = attributes.map(|(first, vectors)| (self.attributes + 4 * first as usize, vectors));
        let parts = [(self.moving_corners, corners), (self.root, nodes)].into_iter().chain(attributes);
        parts.filter(|(_, part)| !part.is_empty()).collect()
    }
}

/// The properties of a scene's triangles that programs are compiled for: which buffers the device reads as texels and which as
/// storage blocks, how rays find triangles, and where hits take their colour from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TriangleReading {
    /// Number of triangles of the scene.
    pub count: u32,
    /// Whether geometry and materials are read as texels.
    pub geometry_texels: bool,
    /// Whether images are read as texels.
    pub image_texels: bool,
    /// Whether some material has an alpha mask or is single-sided, so that a hit on it may not count.
    pub asks: bool,
    /// Number of lights of the scene.
    pub lights: u32,
    /// Groups of nodes that a walk through the trees has room for: at least as many as a tree has levels.
    pub walk_room: i32,
    /// Whether ray queries find the nearest triangle, and not a walk through the tree.
    pub queries: bool,
    /// Whether a caller gives the colours of the triangles, and no light of the scene shines on them.
    pub unlit: bool,
    /// Whether a hit has the colour of the screen where the screen shows its place.
    pub screen_colors: bool,
}

/// The buffers of a scene's triangles that passes bind.
#[derive(Clone, Copy)]
pub struct TriangleBuffers<'a> {
    /// Nodes, corners and attributes.
    pub geometry: &'a TexelBuffer,
    /// Texels of all images.
    pub images: &'a TexelBuffer,
    /// Materials.
    pub table: &'a TexelBuffer,
    /// The structure for ray queries, if these find the nearest triangle.
    pub structure: Option<&'a RayStructure>,
    /// The place from which coordinates of triangles are measured.
    pub origin: DVec3,
    counts: [i32; 4],
    extent_m: f32,
    /// The number of the root of the tree of moving meshes; 0 without one.
    moving: i32,
}

/// The bindings of a frame: a scene's triangles, and the camera and the lights among them.
#[derive(Clone, Copy)]
pub struct TriangleBindings<'a> {
    /// The triangles.
    pub triangles: TriangleBuffers<'a>,
    /// The camera.
    pub block: &'a TriangleBlock,
    /// The lights.
    pub lights: &'a LightBlock,
    /// The screen's lit colour, with its coarser levels if hits have the screen's colours.
    pub screen_color: Sampled<'a>,
    /// The screen's reversed depth.
    pub screen_depth: Sampled<'a>,
}

impl TriangleReading {
    /// The specialization constants that are common to all programs that trace rays against the triangles.
    pub fn constants(&self) -> TriangleConstants {
        let Self { geometry_texels, image_texels, asks, lights, screen_colors, walk_room, .. } = *self;
        TriangleConstants { geometry_texels, image_texels, asks, lights, screen_colors, walk_room }
    }

    /// How rays among the triangles find where they end.
    pub fn ray_source(&self) -> RaySource {
        if self.queries { RaySource::Query } else { RaySource::Tree }
    }
}

impl<'a> TriangleBindings<'a> {
    /// The bindings that are common to all programs that trace rays against the triangles.
    pub fn resources(&self) -> TriangleResources<'a> {
        let Self { triangles, block, lights, screen_color, screen_depth } = *self;
        TriangleResources {
            geometry_texels: triangles.geometry,
            geometry: triangles.geometry.buffer(),
            table_texels: triangles.table,
            table: triangles.table.buffer(),
            image_texels: triangles.images,
            images: triangles.images.buffer(),
            triangles: block,
            scene: lights,
            screen_color,
            screen_depth,
        }
    }
}

/// Walks have room for a multiple of this number of levels, so that few programs are compiled.
const ROOM_STEP: u32 = 4;

/// Returns the room for walks through trees of `levels` levels: one group of nodes for each level.
fn walk_room(levels: u32) -> i32 {
    levels.max(1).next_multiple_of(ROOM_STEP).cast_signed()
}

impl TriangleGeometry {
    /// Uploads the tree of standing meshes with its records, and the moving meshes.
    ///
    /// # Errors
    /// [`crate::error::Error::Memory`] without memory.
    pub fn new(
        context: &mut FrameContext,
        (tree, records): (&Tree, &TriangleRecords),
        moving: &MovingTriangles,
    ) -> Result<Self> {
        let places = Places::new(tree, records, moving);
        let mut vectors = [&tree.nodes[..], &records.corners].concat();
        vectors.resize(places.attributes, [0; 4]);
        vectors.extend_from_slice(&records.attributes);
        vectors.resize(places.end, [0; 4]);
        for (offset, part) in places.of_moving(moving) {
            vectors[offset..offset + part.len()].copy_from_slice(&part);
        }
        let made = Self::from_buffer(tree, records, uploaded(context, "triangles", &vectors)?);
        let [_, _, count, nodes] = made.counts;
        let counts = [places.corners as i32, places.attributes as i32, count, nodes];
        made.moves(&places, moving);
        Ok(Self { counts, asks: made.asks || moving.records.asks(), places: Some(places), ..made })
    }

    /// Keeps the root of the tree of moving meshes, and their greatest coordinate.
    fn moves(&self, places: &Places, moving: &MovingTriangles) {
        let root = if moving.tree.nodes.is_empty() { 0 } else { places.root / NODE_WORDS };
        self.moving.root.set(root as i32);
        self.moving.extent_m.set(moving.records.extent_m());
    }

    /// Replaces the moving triangles by the same triangles where they stand now. The next [`Self::bring`] copies them.
    ///
    /// # Errors
    /// [`crate::error::Error::Memory`] without memory.
    pub fn update(&self, gpu: &Gpu, moving: &MovingTriangles) -> Result<()> {
        let Some(places) = &self.places else { return Ok(()) };
        assert!(moving.tree.is_walkable(), "a tree of {} levels: a walk has no room for them", moving.tree.levels);
        let mut held = self.moving.update.borrow_mut();
        let update = match &mut *held {
            Some(update) => update,
            none => {
                let (_, vector) = VECTORS;
                // Each triangle has room for its corners, its attributes and a node.
                let bytes = vector * ((3 + 4 + NODE_WORDS) * moving.numbers.len()) as u64;
                let staging = Buffer::new(
                    gpu,
                    "moving triangles",
                    bytes,
                    vk::BufferUsageFlags::TRANSFER_SRC,
                    MemoryPlace::Upload,
                )?;
                none.insert(Update { staging, runs: Vec::new() })
            }
        };
        update.runs.clear();
        let mut from = 0;
        let written = update.staging.bytes_mut()?;
        for (offset, part) in places.of_moving(moving) {
            let bytes: &[u8] = bytemuck::cast_slice(&part);
            written[from..from + bytes.len()].copy_from_slice(bytes);
            update.runs.push([from, offset * size_of::<Words>(), bytes.len()].map(|n| n as u64));
            from += bytes.len();
        }
        self.moves(places, moving);
        Ok(())
    }

    /// Records pass "moving", which copies the triangles that [`Self::update`] replaced; records nothing otherwise.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn bring(&self, frame: &mut Frame) -> Result<()> {
        let mut held = self.moving.update.borrow_mut();
        let Some(Update { staging, runs }) = held.as_mut().filter(|update| !update.runs.is_empty()) else {
            return Ok(());
        };
        frame.copy_parts("moving", (staging, self.buffer.buffer()), runs, Access::ComputeStorageRead)?;
        runs.clear();
        Ok(())
    }

    /// Returns the vectors of the buffer of a geometry.
    pub(super) fn vectors(tree: &Tree, records: &TriangleRecords) -> Vec<Words> {
        [&tree.nodes[..], &records.corners, &records.attributes].concat()
    }

    /// Makes the geometry of a buffer that holds its vectors.
    pub(super) fn from_buffer(tree: &Tree, records: &TriangleRecords, buffer: TexelBuffer) -> Self {
        assert!(tree.is_walkable(), "a tree of {} levels: a walk has no room for them", tree.levels);
        let attributes = tree.nodes.len() + records.corners.len();
        let counts = [tree.nodes.len(), attributes, records.attributes.len() / 4, tree.nodes.len() / NODE_WORDS];
        Self {
            origin: tree.origin,
            counts: counts.map(|count| count as i32),
            extent_m: records.extent_m(),
            asks: records.asks(),
            buffer,
            moving: MovingPart::default(),
            places: None,
        }
    }

    /// Returns how shaders read the geometry together with some images and with `lights` lights.
    pub fn reading(&self, images: &TriangleImages, lights: u32) -> TriangleReading {
        let [_, _, count, _] = self.counts;
        TriangleReading {
            count: count.cast_unsigned(),
            geometry_texels: self.buffer.is_whole(),
            image_texels: images.buffer.is_whole(),
            asks: self.asks,
            lights,
            walk_room: walk_room(most_levels(count.cast_unsigned() as usize)),
            queries: false,
            unlit: false,
            screen_colors: false,
        }
    }

    /// Builds the structure for ray queries over the triangles that have an area, in the order of their slots.
    ///
    /// # Errors
    /// [`crate::error::Error::Usage`] without ray queries, and [`crate::error::Error::Memory`] without memory.
    pub fn structure(&self, context: &mut FrameContext) -> Result<RayStructure> {
        let [corners, attributes, ..] = self.counts;
        let (_, stride) = VECTORS;
        let corners = Corners {
            buffer: self.buffer.buffer(),
            first_byte: stride * u64::from(corners.cast_unsigned()),
            stride,
            triangles: (attributes - corners).cast_unsigned() / 3,
        };
        RayStructure::build(context, &corners)
    }

    /// Returns the buffers that passes bind, with images and a table of materials.
    pub fn bound<'a>(&'a self, images: &'a TriangleImages, table: &'a TriangleTable) -> TriangleBuffers<'a> {
        let Self { origin, counts, extent_m, buffer, moving, .. } = self;
        let (origin, counts, extent_m) = (*origin, *counts, extent_m.max(moving.extent_m.get()));
        let (images, table, moving) = (&images.buffer, &table.0, moving.root.get());
        TriangleBuffers { geometry: buffer, images, table, structure: None, origin, counts, extent_m, moving }
    }
}

impl<'a> TriangleBuffers<'a> {
    /// Returns the buffers with a structure for ray queries, or with none.
    pub fn queried(self, structure: Option<&'a RayStructure>) -> Self {
        Self { structure, ..self }
    }

    /// Fills the uniform block through which shaders read the triangles, for one camera. `beside` says how far a
    /// pixel's point may lie beside the surface: in metres for each metre from the eye, or in view units for an
    /// orthographic camera.
    pub fn block(&self, camera: &Camera, beside: f32) -> TriangleBlock {
        let eye = (camera.eye().as_dvec3() - self.origin).as_vec3();
        let [corners, attributes, count, nodes] = self.counts;
        let Self { extent_m: extent, moving, .. } = *self;
        let eye = eye.to_array();
        TriangleBlock { eye, extent, corners, attributes, count, nodes, beside, moving, ..Default::default() }
    }

    /// The matrix from the world to the coordinates of the triangles.
    pub fn world_to_tree(&self) -> Mat4 {
        Mat4::from_translation(-self.origin.as_vec3())
    }
}

/// Uploads a buffer of vectors of four words.
fn uploaded(context: &mut FrameContext, name: &str, vectors: &[Words]) -> Result<TexelBuffer> {
    let (staging, buffer) = staged(context.gpu(), name, bytemuck::cast_slice(vectors), VECTORS)?;
    context.once(|frame| frame.copy_buffer("upload", &staging, buffer.buffer(), Access::ComputeStorageRead))?;
    Ok(buffer)
}

/// Makes a buffer that is not written yet, and a staging buffer to copy to it.
pub(super) fn staged(
    gpu: &Gpu,
    name: &str,
    bytes: &[u8],
    (format, texel): (vk::Format, u64),
) -> Result<(Buffer, TexelBuffer)> {
    // An empty buffer cannot be bound.
    let nothing = vec![0; texel as usize];
    let bytes = if bytes.is_empty() { &nothing } else { bytes };
    let staging = Buffer::upload(gpu, "staging", bytes, vk::BufferUsageFlags::TRANSFER_SRC)?;
    let buffer = texel_buffer(gpu, name, bytes.len() as u64)?;
    Ok((staging, TexelBuffer::new(buffer, format, texel)?))
}

/// Makes an empty buffer of texels, to be filled by a copy. With ray queries, a ray structure can be built from it.
fn texel_buffer(gpu: &Gpu, name: &str, bytes: u64) -> Result<Buffer> {
    let built = if gpu.has_ray_queries() { RayStructure::INPUT } else { vk::BufferUsageFlags::empty() };
    let usage = TexelBuffer::USAGE | vk::BufferUsageFlags::TRANSFER_DST | built;
    Buffer::new(gpu, name, bytes, usage, MemoryPlace::Device)
}
