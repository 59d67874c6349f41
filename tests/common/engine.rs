//! A stand-in for another program's renderer, which keeps its images in its own conventions. Tests use it to try the
//! door for other renderers.

#![allow(dead_code)]

use ash::vk;
use glam::{Mat3, Mat4, Vec3};
use half::f16;
use ssct::gpu::{Buffer, FrameContext, Gpu, Image, ImageDesc, PassTime, Pixels};
use ssct::methods::{METHODS, Setup, Wants};
use ssct::{
    CameraInput, ClipY, Context, DeviceHandles, EnabledFeatures, FactorInput, FrameInput, HitTexture, ImageInput,
    ImageUse, MeshTexture, NormalEncoding, NormalInput, NormalSpace, OutputImage, Recorded, Reflections,
    ReflectionsInfo, Reflectors, TriangleMesh, Triangles,
};
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer, image};
use ssct_scenes::{Camera, Encoding, GBufferData, Mesh, Scene, Surface, Texture, library};
use ssct_truth::reference::unified::encode_octahedral;

/// A format of four 16-bit floats.
pub const HALVES: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
/// A format of four bytes, each of which stands for 0 to 1.
pub const BYTES: vk::Format = vk::Format::R8G8B8A8_UNORM;
/// A format of one 32-bit float.
pub const FLOAT: vk::Format = vk::Format::R32_SFLOAT;

/// The other renderer with its device. The raw handles of our device stand for those of its own.
pub struct Engine {
    pub gpu: Gpu,
    frames: FrameContext,
    pool: vk::CommandPool,
}

impl Engine {
    /// Makes the renderer, with a command pool of its own, on a device.
    pub fn new(gpu: &Gpu) -> Self {
        let info = vk::CommandPoolCreateInfo::default().queue_family_index(gpu.shared().queue_family);
        // SAFETY: destroyed in `drop`.
        let pool = unsafe { gpu.raw().create_command_pool(&info, None) }.unwrap();
        Self { gpu: gpu.clone(), frames: FrameContext::new(gpu).unwrap(), pool }
    }

    /// Returns the handles of the device, as the door takes them.
    pub fn handles(&self) -> DeviceHandles {
        let shared = self.gpu.shared();
        let mut enabled = EnabledFeatures::default();
        ssct::enable_features(&mut enabled.core, &mut enabled.vulkan12, &mut enabled.vulkan13);
        DeviceHandles {
            entry: shared.entry.clone(),
            instance: shared.instance.clone(),
            physical: shared.physical,
            device: shared.device.clone(),
            queue_family: shared.queue_family,
            enabled,
            debug_utils: false,
            memory: None,
        }
    }

    /// Makes a context of the door on the device.
    pub fn context(&self) -> Context {
        // SAFETY: the handles are of one device, which outlives the test's contexts; its features are those of
        // `Gpu::open`, which has them on.
        unsafe { Context::new(self.handles()) }.unwrap()
    }

    /// Makes an image of one layer, with a format, a width and height in texels, and the given bytes. Fragment shaders
    /// may sample it.
    pub fn upload(&mut self, format: vk::Format, extent: [u32; 2], bytes: &[u8]) -> Image {
        self.upload_layers(1, format, extent, bytes)
    }

    /// Makes a cube map of one linear colour, in 16-bit floats, whose faces are `side` texels wide.
    pub fn cube(&mut self, side: u32, color: Vec3) -> Image {
        let texels = (0..6 * side * side).flat_map(|_| color.extend(1.0).to_array());
        self.upload_layers(6, HALVES, [side; 2], &halves(texels))
    }

    /// Makes an image as `upload` does, but of several layers, whose bytes follow each other.
    fn upload_layers(&mut self, layers: u32, format: vk::Format, extent: [u32; 2], bytes: &[u8]) -> Image {
        use vk::ImageUsageFlags as U;
        let usage = U::SAMPLED | U::TRANSFER_DST | U::TRANSFER_SRC;
        let image =
            Image::new(&self.gpu, &ImageDesc { name: "theirs", format, extent, levels: 1, layers, usage }).unwrap();
        let staging = Buffer::upload(&self.gpu, "staging", bytes, vk::BufferUsageFlags::TRANSFER_SRC).unwrap();
        self.frames
            .once(|frame| {
                frame.upload("upload", &staging, image.all())?;
                frame.hand_over(&image, ImageUse::FRAGMENT_SAMPLED);
                Ok(())
            })
            .unwrap();
        image
    }

    /// Begins a command buffer.
    pub fn begin(&self) -> vk::CommandBuffer {
        let info = vk::CommandBufferAllocateInfo::default().command_pool(self.pool).command_buffer_count(1);
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the pool is alive, and frees its command buffers.
        unsafe {
            let commands = self.gpu.raw().allocate_command_buffers(&info).unwrap()[0];
            self.gpu.raw().begin_command_buffer(commands, &begin).unwrap();
            commands
        }
    }

    /// Ends a command buffer, submits it, and waits until the device is idle.
    pub fn submit(&self, commands: vk::CommandBuffer) -> ash::prelude::VkResult<()> {
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(commands)];
        let submit = [vk::SubmitInfo2::default().command_buffer_infos(&commands)];
        let queue = self.gpu.queue().unwrap();
        // SAFETY: the command buffer is recorded; the device is waited for.
        unsafe {
            self.gpu.raw().end_command_buffer(commands[0].command_buffer)?;
            self.gpu.raw().queue_submit2(*queue, &submit, vk::Fence::null())?;
            self.gpu.raw().device_wait_idle()
        }
    }

    /// Frees every command buffer, none of which the device may still be running.
    pub fn reset(&mut self) {
        let info = vk::CommandPoolCreateInfo::default().queue_family_index(self.gpu.shared().queue_family);
        // SAFETY: nothing is under way; the new pool is destroyed in `drop`.
        unsafe {
            self.gpu.raw().destroy_command_pool(self.pool, None);
            self.pool = self.gpu.raw().create_command_pool(&info, None).unwrap();
        }
    }

    /// Reads an output image of the door back to the host. The frame must have left it ready to be copied from, as
    /// [`ForeignGBuffer::input`] asks.
    pub fn read(&mut self, output: &OutputImage) -> Pixels {
        let range =
            vk::ImageSubresourceRange::default().aspect_mask(vk::ImageAspectFlags::COLOR).level_count(1).layer_count(1);
        let (handles, format_and_extent) = ((output.image, output.view), (output.format, output.extent));
        let image = Image::borrowed(&self.gpu, "output", handles, range, format_and_extent);
        self.frames
            .once(|frame| {
                frame.take_over(&image, ImageUse::TRANSFER_SOURCE);
                Ok(())
            })
            .unwrap();
        self.frames.read(image.all()).unwrap()
    }

    /// Records one frame of reflections, submits it, and waits for it. Returns what the door recorded, with the frame's
    /// images.
    pub fn frame(&mut self, reflections: &mut Reflections, input: &FrameInput) -> ssct::Result<Recorded> {
        let commands = self.begin();
        // SAFETY: the command buffer is recording; what is recorded is submitted and waited for at once.
        let recorded = unsafe { reflections.record(commands, input) }?;
        self.submit(commands).unwrap();
        Ok(recorded)
    }

    /// Hands a G-buffer over in a convention, and returns the composite that the door makes of it.
    pub fn shown(&mut self, reflections: &mut Reflections, data: &GBufferData, convention: Convention) -> Pixels {
        let theirs = ForeignGBuffer::new(self, data, convention);
        let recorded = self.frame(reflections, &theirs.input()).unwrap();
        self.read(&recorded.composite.unwrap())
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        // SAFETY: nothing is under way.
        unsafe { self.gpu.raw().destroy_command_pool(self.pool, None) };
    }
}

/// How a renderer encodes its G-buffer and its camera.
#[derive(Debug, Clone, Copy)]
pub struct Convention {
    /// The space that normals are in, and how their components are stored.
    pub normal: (NormalSpace, NormalEncoding),
    /// Whether its view space is right-handed.
    pub right_handed: bool,
    /// Whether depth is 0 at the near plane; else it is reversed.
    pub standard_depth: bool,
    /// The direction of the y axis in clip space.
    pub clip_y: ClipY,
}

/// The convention of `ssct` itself.
pub const NATIVE: Convention = Convention {
    normal: (NormalSpace::View, NormalEncoding::Float),
    right_handed: false,
    standard_depth: false,
    clip_y: ClipY::Up,
};

/// The images of a G-buffer in the convention of another renderer, with its camera.
pub struct ForeignGBuffer {
    pub depth: Image,
    pub normal: Image,
    /// Roughness in channel 1 and reflectivity in channel 3. The others hold values that the door must not use.
    pub material: Image,
    pub color: Image,
    pub camera: CameraInput,
    pub convention: Convention,
}

/// Converts values to 16-bit floats, and returns their bytes.
pub fn halves(values: impl Iterator<Item = f32>) -> Vec<u8> {
    values.flat_map(|v| f16::from_f32(v).to_ne_bytes()).collect()
}

impl ForeignGBuffer {
    /// Converts a G-buffer to a convention, and uploads it.
    pub fn new(engine: &mut Engine, data: &GBufferData, convention: Convention) -> Self {
        let extent = [data.width, data.height];
        let to_their_view = Mat3::from_diagonal(Vec3::new(1.0, 1.0, if convention.right_handed { -1.0 } else { 1.0 }));
        let ours = data.camera.view_to_clip_reversed().to_cols_array();
        let mut clip = ours;
        let z_sign = if convention.right_handed { -1.0 } else { 1.0 };
        let is_parallel = data.camera.kind().is_orthographic();
        if convention.standard_depth {
            // Standard depth is 1 minus reversed depth. Both are multiplied by w in clip space, which is z in a
            // perspective and 1 otherwise.
            let (w_per_z, constant_w) = if is_parallel { (0.0, 1.0) } else { (1.0, 0.0) };
            clip[10] = w_per_z - ours[10];
            clip[14] = constant_w - ours[14];
        }
        // The numbers stand column by column: 8 to 11 are the column of z, and 1, 5, 9 and 13 the row of y.
        (8..12).for_each(|i| clip[i] *= z_sign);
        if convention.clip_y == ClipY::Down {
            [1, 5, 9, 13].into_iter().for_each(|i| clip[i] = -clip[i]);
        }
        let world_to_view = Mat4::from_mat3(to_their_view) * data.camera.world_to_view;
        let to_world = Mat3::from_mat4(data.camera.world_to_view).transpose();
        let normal_texel = |n: &Vec3| -> [f32; 4] {
            let n = match convention.normal.0 {
                NormalSpace::View => to_their_view * *n,
                NormalSpace::World => to_world * *n,
            };
            // Pixels of the sky have the normal 0, which has no octahedral form.
            let octahedral = if n == Vec3::ZERO { n.truncate() } else { encode_octahedral(n) };
            let unorm = |v: f32| 0.5 * v + 0.5;
            match convention.normal.1 {
                NormalEncoding::Float => [n.x, n.y, n.z, 0.0],
                NormalEncoding::Unorm => [unorm(n.x), unorm(n.y), unorm(n.z), 0.0],
                NormalEncoding::Octahedral => [octahedral.x, octahedral.y, 0.0, 0.0],
                NormalEncoding::OctahedralUnorm => [unorm(octahedral.x), unorm(octahedral.y), 0.0, 0.0],
            }
        };
        let depth: Vec<f32> = data.depth.iter().map(|d| if convention.standard_depth { 1.0 - d } else { *d }).collect();
        let factors = data.roughness.iter().zip(&data.reflectivity);
        let material = factors.flat_map(|(roughness, reflectivity)| [0.25, *roughness, 0.5, *reflectivity]);
        let color = data.color.iter().flat_map(|c| c.extend(1.0).to_array());
        let camera =
            CameraInput { world_to_view: world_to_view.to_cols_array(), view_to_clip: clip, clip_y: convention.clip_y };
        Self {
            depth: engine.upload(FLOAT, extent, bytemuck::cast_slice(&depth)),
            normal: engine.upload(HALVES, extent, &halves(data.normal.iter().flat_map(normal_texel))),
            material: engine.upload(HALVES, extent, &halves(material)),
            color: engine.upload(HALVES, extent, &halves(color)),
            camera,
            convention,
        }
    }

    /// Returns the input of a frame that hands over these images and nothing optional.
    pub fn input(&self) -> FrameInput<'static> {
        let image_input =
            |image: &Image| ImageInput::color(image.handle(), image.all().view(), image.format(), image.extent());
        let (space, encoding) = self.convention.normal;
        FrameInput {
            slot: 0,
            camera: self.camera,
            depth: image_input(&self.depth),
            normal: NormalInput { image: image_input(&self.normal), space, encoding },
            reflectivity: FactorInput::Channel(image_input(&self.material), 3),
            roughness: FactorInput::Channel(image_input(&self.material), 1),
            reflectors: Reflectors::UNKNOWN,
            color: image_input(&self.color),
            sky: None,
            captures: None,
            triangles: None,
            triangle_numbers: None,
            motion: None,
            timed: false,
            outputs: ImageUse::TRANSFER_SOURCE,
        }
    }
}

/// Draws the G-buffer of a view of the rooms, which shows all kinds of surfaces.
pub fn view_of_rooms(gpu: &Gpu, extent: [u32; 2]) -> GBufferData {
    drawn(gpu, "rooms", "corridor", extent)
}

/// Draws the G-buffer of a view of a built-in scene at a size in pixels. Its camera has a projection matrix and no
/// lens, as another engine gives it.
pub fn drawn(gpu: &Gpu, scene: &str, view: &str, extent: [u32; 2]) -> GBufferData {
    let scene = library::scene(scene).expect("a built-in scene");
    let view = scene.view(view).unwrap();
    let mut stage = Stage::new(gpu, &scene).unwrap();
    let materials = Globals::default().materials(&scene, view);
    let camera = view.camera(&scene, extent);
    // Any method will do, since all of them draw the same G-buffer.
    let shot = Shot::new(&mut stage, &METHODS[0], &Setup::new(extent), Wants::IMAGE, camera, materials).unwrap();
    image::render(&mut stage, &shot, false).unwrap();
    let mut data = gbuffer::read(&mut stage.context, &shot).unwrap();
    data.camera = Camera::of_projection(data.camera.world_to_view, camera.projection_numbers());
    // The images that another renderer hands over do not tell which surfaces show the sky.
    data.surface.fill(Surface::Lit);
    data
}

/// Returns the info for reflections by a method, with the size and the kind of projection of a G-buffer.
pub fn info<'a>(data: &GBufferData, method: &'a str) -> ReflectionsInfo<'a> {
    let (extent, projection) = ([data.width, data.height], data.camera.kind());
    ReflectionsInfo { extent, projection, method, ..ReflectionsInfo::default() }
}

/// Returns the bits of all values, so that two images can be compared exactly.
pub fn bits(pixels: &Pixels) -> Vec<u32> {
    pixels.values.iter().map(|v| v.to_bits()).collect()
}

/// Returns the root mean square difference of two images over all channels of all texels.
pub fn rmse(a: &Pixels, b: &Pixels) -> f64 {
    assert_eq!(a.values.len(), b.values.len());
    let sum: f64 = a.values.iter().zip(&b.values).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (sum / a.values.len() as f64).sqrt()
}

/// Returns the rooms without lights and maps. Each surface is seen from both sides and emits one colour, its albedo, as
/// meshes of another renderer may.
pub fn plain_rooms() -> Scene {
    let mut scene = library::scene("rooms").expect("a built-in scene");
    scene.lights.clear();
    for material in &mut scene.materials {
        (material.albedo_map, material.normal_map, material.alpha_mask) = (None, None, None);
        (material.emission, material.single_sided) = (1.0, false);
        material.surface = Surface::Lit;
    }
    scene
}

/// The vertices of a mesh, in the form in which the door takes them.
pub struct Vertices {
    pub positions: Vec<[f32; 3]>,
    /// Coordinates on the mesh's texture, one pair for each position.
    pub places: Vec<[f32; 2]>,
}

/// Returns the vertices of each mesh of a scene, in the order of the meshes.
pub fn vertices_of(scene: &Scene) -> Vec<Vertices> {
    let vertices = |mesh: &Mesh| Vertices {
        positions: mesh.vertices.iter().map(|v| v.position).collect(),
        places: mesh.vertices.iter().map(|v| v.uv).collect(),
    };
    scene.meshes.iter().map(vertices).collect()
}

/// Returns the meshes of a scene for the door, each in its material's albedo. If they are textured, each has its albedo
/// map as well. `vertices` are those of [`vertices_of`] for the same scene.
pub fn meshes_of<'a>(scene: &'a Scene, vertices: &'a [Vertices], are_textured: bool) -> Vec<TriangleMesh<'a>> {
    let mesh_for_door = |(mesh, Vertices { positions, places }): (&'a Mesh, &'a Vertices)| {
        let material = &scene.materials[mesh.material];
        let texture = material.albedo_map.filter(|_| are_textured);
        TriangleMesh {
            positions,
            indices: &mesh.indices,
            mesh_to_world: Mat4::IDENTITY.to_cols_array(),
            color: material.albedo.to_array(),
            texture: texture.map(|number| MeshTexture { number, places }),
        }
    };
    scene.meshes.iter().zip(vertices).map(mesh_for_door).collect()
}

/// Returns the textures of a scene, in the form in which the door takes them.
pub fn textures_of(scene: &Scene) -> Vec<HitTexture<'_>> {
    let mut textures = Vec::new();
    for Texture { width, height, rgba, encoding, .. } in &scene.textures {
        textures.push(HitTexture { extent: [*width, *height], is_srgb: *encoding == Encoding::Srgb, texels: rgba });
    }
    textures
}

/// Copies triangles to the device.
pub fn upload(engine: &Engine, triangles: &mut Triangles) {
    let commands = engine.begin();
    // SAFETY: the command buffer is recording; it is submitted and waited for at once.
    unsafe { triangles.record_upload(commands) }.unwrap();
    engine.submit(commands).unwrap();
}

/// Makes the door's triangles of a scene, each mesh in its material's albedo, and copies them to the device.
pub fn triangles_of(engine: &Engine, scene: &Scene) -> Triangles {
    let mut triangles = Triangles::new(&engine.context(), &meshes_of(scene, &vertices_of(scene), false)).unwrap();
    upload(engine, &mut triangles);
    triangles
}

/// Returns the sum, in milliseconds, of the times of the passes that count towards a method's time.
pub fn counted(passes: &[PassTime]) -> f64 {
    passes.iter().filter(|p| p.counted).map(|p| p.ms).sum()
}
