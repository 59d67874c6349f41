//! A scene's triangles in device memory, as the programs under `shaders-glsl/triangles/` read them: the tree with the
//! records of its triangles. The module `images` has the texels of all images, and a table of materials.

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
use ssct_ground::scene::tree::{MovingTriangles, NODE_VECTORS, Tree, TriangleRecords, Words, most_levels};
use std::cell::{Cell, RefCell};

/// Format of [`GBuffer::triangle`](super::GBuffer::triangle).
pub const TRIANGLE: vk::Format = vk::Format::R32_UINT;

/// Bytes of a texel of the images.
const TEXEL_BYTES: u64 = 4;

/// Format and size in bytes of a vector of four words, the unit in which shaders read geometry and materials.
pub(super) const VECTORS: (vk::Format, u64) = (vk::Format::R32G32B32A32_UINT, size_of::<Words>() as u64);

/// Format and size in bytes of a word, which holds one texel of an image.
pub(super) const TEXELS: (vk::Format, u64) = (vk::Format::R32_UINT, TEXEL_BYTES);

/// The tree and the records of a scene's triangles, where its meshes stand.
pub struct TriangleGeometry {
    origin: DVec3,
    counts: GeometryCounts,
    /// The greatest coordinate of a corner of a standing mesh, in metres.
    extent_m: f32,
    /// Whether a material has an alpha mask or is single-sided, and so decides at each hit whether the hit counts.
    may_reject_hits: bool,
    buffer: TexelBuffer,
    /// The triangles of moving meshes.
    moving: MovingPart,
    /// Where the parts of `buffer` begin; `None` if nothing can move.
    places: Option<Places>,
}

/// Where the first corner and the first attribute lie among the vectors of a geometry's buffer, and how many triangles and
/// nodes of standing meshes there are.
#[derive(Clone, Copy)]
struct GeometryCounts {
    first_corner: i32,
    first_attribute: i32,
    triangles: i32,
    nodes: i32,
}

/// The moving part of a scene's triangles, in the same buffer. Moving corners come after those of standing meshes, and
/// moving nodes after everything else. A walk visits a second root, that of the moving part, whose nodes and slots
/// continue the numbers of the standing part.
#[derive(Default)]
struct MovingPart {
    /// The number of the root node; 0 without one.
    root: Cell<i32>,
    /// The greatest coordinate of a corner, in metres.
    extent_m: Cell<f32>,
    update: RefCell<Option<Update>>,
}

/// Vectors that a frame copies to their places in the buffer.
struct Update {
    staging: Buffer,
    /// Source offset, target offset and length of each run of bytes; empty once the runs have been copied.
    runs: Vec<[u64; 3]>,
}

/// The indices of the vectors at which the parts of the buffer begin. Nodes of standing meshes begin at 0.
struct Places {
    /// Corners of standing meshes, three for each slot.
    corners: usize,
    moving_corners: usize,
    attributes: usize,
    /// Nodes of moving meshes, at a multiple of the vectors of a node.
    root: usize,
    end: usize, // of the buffer
}

impl Places {
    /// Places the parts one after the other, with room for all moving triangles. A corner is one vector.
    fn new(tree: &Tree, records: &TriangleRecords, moving: &MovingTriangles) -> Self {
        let moving_count = moving.numbers.len();
        let corners = tree.nodes.len();
        let moving_corners = corners + records.corners.len();
        let attributes = moving_corners + 3 * moving_count;
        let attributes_end = attributes + records.attributes.len();
        let root = attributes_end.next_multiple_of(NODE_VECTORS);
        // A tree over some triangles has no more nodes than triangles.
        let end = if moving_count == 0 { attributes_end } else { root + NODE_VECTORS * moving_count };
        Self { corners, moving_corners, attributes, root, end }
    }

    /// Returns the moving part as runs of vectors, each with the index of its first vector in the buffer.
    fn moving_runs(&self, moving: &MovingTriangles) -> Vec<(usize, Vec<Words>)> {
        let slots = ((self.moving_corners - self.corners) / 3) as u32;
        let mut corners = moving.records.corners.clone();
        // There is also room for triangles that have no area at the moment.
        corners.resize(3 * moving.numbers.len(), [0; 4]);
        let nodes = moving.tree.nodes_after((self.root / NODE_VECTORS) as u32, slots);
        assert!(self.root + nodes.len() <= self.end.max(self.root), "more nodes than triangles");
        let attributes = moving.attributes_after(slots).into_iter();
        let attributes = attributes.map(|(first, vectors)| (self.attributes + 4 * first as usize, vectors));
        let runs = [(self.moving_corners, corners), (self.root, nodes)].into_iter().chain(attributes);
        runs.filter(|(_, vectors)| !vectors.is_empty()).collect()
    }
}

/// The properties of a scene's triangles that programs are compiled for: whether shaders read each buffer as texels or
/// as a storage block, how rays find triangles, and where hits take their colour from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TriangleReading {
    /// Number of triangles of the scene.
    pub count: u32,
    /// Whether geometry and materials are read as texels.
    pub geometry_texels: bool,
    /// Whether images are read as texels.
    pub image_texels: bool,
    /// Whether a material has an alpha mask or is single-sided, and so decides at each hit whether the hit counts.
    pub may_reject_hits: bool,
    /// Number of lights of the scene.
    pub lights: u32,
    /// Groups of nodes that the stack of a walk has room for: at least as many as a tree has levels.
    pub walk_room: i32,
    /// Whether ray queries of the device find the nearest triangle, instead of a walk through the tree.
    pub queries: bool,
    /// Whether the colours of the triangles are the light that they send out, and no light of a scene shines on them.
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
    counts: GeometryCounts,
    extent_m: f32,
    /// The number of the root of the tree of moving meshes; 0 without one.
    moving_root: i32,
}

/// The bindings of a frame: a scene's triangles, and the camera and the lights in their coordinates.
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
    /// Returns the specialization constants that are common to all programs that trace rays against the triangles.
    pub fn constants(&self) -> TriangleConstants {
        let Self { geometry_texels, image_texels, may_reject_hits: asks, lights, screen_colors, walk_room, .. } = *self;
        TriangleConstants { geometry_texels, image_texels, asks, lights, screen_colors, walk_room }
    }

    /// Returns by what the programs find the triangle that a ray meets.
    pub fn ray_source(&self) -> RaySource {
        if self.queries { RaySource::Query } else { RaySource::Tree }
    }
}

impl<'a> TriangleBindings<'a> {
    /// Returns the bindings that are common to all programs that trace rays against the triangles.
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

/// The room of walks is rounded up to a multiple of this number, so that few different programs are compiled.
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
        for (first, run) in places.moving_runs(moving) {
            vectors[first..first + run.len()].copy_from_slice(&run);
        }
        let standing = Self::from_buffer(tree, records, upload_vectors(context, "triangles", &vectors)?);
        let [first_corner, first_attribute] = [places.corners, places.attributes].map(|index| index as i32);
        let counts = GeometryCounts { first_corner, first_attribute, ..standing.counts };
        let may_reject_hits = standing.may_reject_hits || moving.records.may_reject_hits();
        standing.set_moving(&places, moving);
        Ok(Self { counts, may_reject_hits, places: Some(places), ..standing })
    }

    /// Sets the root of the tree of moving meshes and their greatest coordinate in `self.moving`.
    fn set_moving(&self, places: &Places, moving: &MovingTriangles) {
        let root = if moving.tree.nodes.is_empty() { 0 } else { places.root / NODE_VECTORS };
        self.moving.root.set(root as i32);
        self.moving.extent_m.set(moving.records.extent_m());
    }

    /// Writes the moving triangles, where they stand now, to a staging buffer, which the next [`Self::copy_moving`] copies.
    ///
    /// # Errors
    /// [`crate::error::Error::Memory`] without memory.
    pub fn update(&self, gpu: &Gpu, moving: &MovingTriangles) -> Result<()> {
        let Some(places) = &self.places else { return Ok(()) };
        assert!(moving.tree.is_walkable(), "a tree of {} levels: a walk has no room for them", moving.tree.levels);
        let mut slot = self.moving.update.borrow_mut();
        let update = match &mut *slot {
            Some(update) => update,
            empty => {
                let (_, vector_bytes) = VECTORS;
                // Each triangle has room for three corners, four vectors of attributes and a node.
                let bytes = vector_bytes * ((3 + 4 + NODE_VECTORS) * moving.numbers.len()) as u64;
                let staging = Buffer::new(
                    gpu,
                    "moving triangles",
                    bytes,
                    vk::BufferUsageFlags::TRANSFER_SRC,
                    MemoryPlace::Upload,
                )?;
                empty.insert(Update { staging, runs: Vec::new() })
            }
        };
        update.runs.clear();
        let mut from = 0;
        let staging = update.staging.bytes_mut()?;
        for (first_vector, vectors) in places.moving_runs(moving) {
            let bytes: &[u8] = bytemuck::cast_slice(&vectors);
            staging[from..from + bytes.len()].copy_from_slice(bytes);
            update.runs.push([from, first_vector * size_of::<Words>(), bytes.len()].map(|n| n as u64));
            from += bytes.len();
        }
        self.set_moving(places, moving);
        Ok(())
    }

    /// Records pass "moving", which copies the triangles of the last [`Self::update`], if they were not copied yet.
    pub fn copy_moving(&self, frame: &mut Frame) -> Result<()> {
        let mut slot = self.moving.update.borrow_mut();
        let Some(Update { staging, runs }) = slot.as_mut().filter(|update| !update.runs.is_empty()) else {
            return Ok(());
        };
        frame.copy_parts("moving", (staging, self.buffer.buffer()), runs, Access::ComputeStorageRead)?;
        runs.clear();
        Ok(())
    }

    /// Returns all vectors of the buffer of a geometry in which nothing moves.
    pub(super) fn vectors(tree: &Tree, records: &TriangleRecords) -> Vec<Words> {
        [&tree.nodes[..], &records.corners, &records.attributes].concat()
    }

    /// Makes a geometry in which nothing moves, of a buffer that holds its vectors.
    pub(super) fn from_buffer(tree: &Tree, records: &TriangleRecords, buffer: TexelBuffer) -> Self {
        assert!(tree.is_walkable(), "a tree of {} levels: a walk has no room for them", tree.levels);
        let counts = GeometryCounts {
            first_corner: tree.nodes.len() as i32,
            first_attribute: (tree.nodes.len() + records.corners.len()) as i32,
            triangles: (records.attributes.len() / 4) as i32,
            nodes: (tree.nodes.len() / NODE_VECTORS) as i32,
        };
        Self {
            origin: tree.origin,
            counts,
            extent_m: records.extent_m(),
            may_reject_hits: records.may_reject_hits(),
            buffer,
            moving: MovingPart::default(),
            places: None,
        }
    }

    /// Returns how shaders read the geometry together with some images and with `lights` lights.
    pub fn reading(&self, images: &TriangleImages, lights: u32) -> TriangleReading {
        let count = self.counts.triangles.cast_unsigned();
        TriangleReading {
            count,
            geometry_texels: self.buffer.is_whole(),
            image_texels: images.buffer.is_whole(),
            may_reject_hits: self.may_reject_hits,
            lights,
            walk_room: walk_room(most_levels(count as usize)),
            queries: false,
            unlit: false,
            screen_colors: false,
        }
    }

    /// Builds the structure for ray queries over the triangles that have an area, in the order of their slots.
    ///
    /// # Errors
    /// [`crate::error::Error::Usage`] without ray queries, and [`crate::error::Error::Memory`] without memory.
    pub fn build_structure(&self, context: &mut FrameContext) -> Result<RayStructure> {
        let GeometryCounts { first_corner, first_attribute, .. } = self.counts;
        let (_, stride) = VECTORS;
        let corners = Corners {
            buffer: self.buffer.buffer(),
            first_byte: stride * u64::from(first_corner.cast_unsigned()),
            stride,
            triangles: (first_attribute - first_corner).cast_unsigned() / 3, // attributes begin where the corners end
        };
        RayStructure::build(context, &corners)
    }

    /// Returns the buffers that passes bind, with images and a table of materials.
    pub fn buffers<'a>(&'a self, images: &'a TriangleImages, table: &'a TriangleTable) -> TriangleBuffers<'a> {
        let Self { origin, counts, extent_m, buffer, moving, .. } = self;
        let (origin, counts, extent_m) = (*origin, *counts, extent_m.max(moving.extent_m.get()));
        let (images, table, moving_root) = (&images.buffer, &table.0, moving.root.get());
        TriangleBuffers { geometry: buffer, images, table, structure: None, origin, counts, extent_m, moving_root }
    }
}

impl<'a> TriangleBuffers<'a> {
    /// Returns the buffers with a structure for ray queries, or with none.
    pub fn with_ray_structure(self, structure: Option<&'a RayStructure>) -> Self {
        Self { structure, ..self }
    }

    /// Returns the uniform block by which shaders read the triangles, for one camera. `max_offset` is the greatest
    /// distance of a pixel's point from its surface: in metres for each metre from the eye, or in view units for an
    /// orthographic camera.
    pub fn block(&self, camera: &Camera, max_offset: f32) -> TriangleBlock {
        let GeometryCounts { first_corner, first_attribute, triangles, nodes } = self.counts;
        TriangleBlock {
            eye: (camera.eye().as_dvec3() - self.origin).as_vec3().to_array(),
            extent: self.extent_m,
            corners: first_corner,
            attributes: first_attribute,
            count: triangles,
            nodes,
            beside: max_offset,
            moving: self.moving_root,
            ..Default::default()
        }
    }

    /// Returns the matrix from the world to the coordinates of the triangles.
    pub fn world_to_tree(&self) -> Mat4 {
        Mat4::from_translation(-self.origin.as_vec3())
    }
}

/// Makes a buffer that holds `vectors`, and uploads them.
fn upload_vectors(context: &mut FrameContext, name: &str, vectors: &[Words]) -> Result<TexelBuffer> {
    let (buffer, staging) = buffer_and_staging(context.gpu(), name, bytemuck::cast_slice(vectors), VECTORS)?;
    context.once(|frame| frame.copy_buffer("upload", &staging, buffer.buffer(), Access::ComputeStorageRead))?;
    Ok(buffer)
}

/// Makes a buffer of texels without content, and a staging buffer that holds `bytes`, to be copied to it.
pub(super) fn buffer_and_staging(
    gpu: &Gpu,
    name: &str,
    bytes: &[u8],
    (format, texel_bytes): (vk::Format, u64),
) -> Result<(TexelBuffer, Buffer)> {
    // A buffer without bytes cannot be bound.
    let one_texel = vec![0; texel_bytes as usize];
    let bytes = if bytes.is_empty() { &one_texel } else { bytes };
    let staging = Buffer::upload(gpu, "staging", bytes, vk::BufferUsageFlags::TRANSFER_SRC)?;
    let buffer = texel_buffer(gpu, name, bytes.len() as u64)?;
    Ok((TexelBuffer::new(buffer, format, texel_bytes)?, staging))
}

/// Makes a buffer of texels without content. Copies can fill it, and with ray queries a ray structure can read it.
fn texel_buffer(gpu: &Gpu, name: &str, bytes: u64) -> Result<Buffer> {
    let build_input = if gpu.has_ray_queries() { RayStructure::INPUT } else { vk::BufferUsageFlags::empty() };
    let usage = TexelBuffer::USAGE | vk::BufferUsageFlags::TRANSFER_DST | build_input;
    Buffer::new(gpu, name, bytes, usage, MemoryPlace::Device)
}
