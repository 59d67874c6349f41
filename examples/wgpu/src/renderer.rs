//! The renderer itself, which draws on wgpu and knows little of reflections.

use embed_wgpu::{HALF, Result, copy_out, description};
use wgpu::TextureFormat;

/// The format of the depth buffer.
pub const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// The device, and the two pipelines: `scene` draws the scene through `camera`, `show` draws an image to the screen
/// image.
pub struct Renderer {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub adapter: wgpu::Adapter,
    scene: wgpu::RenderPipeline,
    camera: wgpu::BindGroup,
    show: wgpu::RenderPipeline,
}

/// A texture with its view.
pub struct Picture {
    pub texture: wgpu::Texture,
    view: wgpu::TextureView,
}

impl Picture {
    /// Takes a texture, and makes a view of all of it.
    fn from_texture(texture: wgpu::Texture) -> Self {
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Self { texture, view }
    }
}

// ---- reflections ----
impl Renderer {
    /// Describes a texture as an input of the reflections. It is in the state `RESOURCE` before and after them.
    pub fn input(&self, picture: &Picture) -> Result<ssct::ImageInput> {
        embed_wgpu::input(&self.adapter, &picture.texture, &picture.view)
    }

    /// Wraps an image that `ssct` made, and that is in the state `RESOURCE`, as a texture of wgpu.
    pub fn adopt(&self, image: &ssct::OutputImage) -> Result<Picture> {
        Ok(Picture::from_texture(embed_wgpu::adopt(&self.device, "composite", image)?))
    }
}
// ---------------------

impl Renderer {
    /// Opens the fastest device, and makes the pipelines for a camera with these matrices.
    pub fn new(view_to_clip: &[f32; 16], world_to_view: &[f32; 16]) -> Result<Self> {
        let (_, adapter) = pollster::block_on(embed_wgpu::fastest())?;
        let open = embed_wgpu::open(&adapter, wgpu::Features::empty(), &wgpu::Limits::default())?;
        // SAFETY: the device is of this adapter, and has the default's features and limits.
        let (device, queue) = unsafe { adapter.create_device_from_hal(open, &wgpu::DeviceDescriptor::default()) }?;
        let module = device.create_shader_module(wgpu::include_wgsl!("scene.wgsl"));
        let scene = pipeline(&device, &module, "scene", &[HALF; 3], Some(DEPTH));
        let show = pipeline(&device, &module, "show", &[TextureFormat::Rgba8UnormSrgb], None);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("camera"),
            size: 128,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let numbers: Vec<u8> = view_to_clip.iter().chain(world_to_view).flat_map(|v| v.to_ne_bytes()).collect();
        queue.write_buffer(&buffer, 0, &numbers);
        let entries = [wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }];
        let layout = &scene.get_bind_group_layout(0);
        let camera = device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });
        Ok(Self { device, queue, adapter, scene, camera, show })
    }

    /// Makes an image that a pass draws, and that is then sampled and copied.
    pub fn picture(&self, name: &str, [width, height]: [u32; 2], format: TextureFormat) -> Picture {
        use wgpu::TextureUsages as U;
        let usage = U::RENDER_ATTACHMENT | U::TEXTURE_BINDING | U::COPY_SRC;
        Picture::from_texture(self.device.create_texture(&description(name, [width, height, 1], format, usage)))
    }

    /// Records drawing the scene to three colours and a depth, all of which are left in the state `RESOURCE`.
    pub fn draw(&self, colors: [&Picture; 3], depth: &Picture) -> wgpu::CommandBuffer {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        render(&mut encoder, &self.scene, &self.camera, &colors, Some(depth));
        let transitions = colors.into_iter().chain([depth]).map(|picture| wgpu::TextureTransition {
            texture: &picture.texture,
            selector: None,
            state: wgpu::TextureUses::RESOURCE,
        });
        encoder.transition_resources(std::iter::empty(), transitions);
        encoder.finish()
    }

    /// Records drawing a linear image to the image `screen`. The linear image is sampled, and so stays in the state
    /// `RESOURCE`.
    pub fn show(&self, linear: &Picture, screen: &Picture) -> wgpu::CommandBuffer {
        let entries = [wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&linear.view) }];
        let layout = &self.show.get_bind_group_layout(0);
        let image =
            self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        render(&mut encoder, &self.show, &image, &[screen], None);
        encoder.finish()
    }

    /// Waits until the device is done with a submission, or with all submissions if it is `None`.
    pub fn wait(&self, submission: Option<&wgpu::SubmissionIndex>) -> Result<()> {
        self.device.poll(wgpu::PollType::Wait { submission_index: submission.cloned(), timeout: None })?;
        Ok(())
    }

    /// Copies images to the host and returns their bytes. If the bytes of a row are no multiple of 256, the returned
    /// rows are padded to one.
    pub fn read<'a>(&self, pictures: impl Iterator<Item = &'a Picture>) -> Result<Vec<Vec<u8>>> {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let buffers: Vec<_> =
            pictures.map(|picture| copy_out(&self.device, &mut encoder, &picture.texture).0).collect();
        self.queue.submit([encoder.finish()]);
        // If mapping fails, `get_mapped_range` returns an error.
        buffers.iter().for_each(|buffer| buffer.map_async(wgpu::MapMode::Read, .., |_| ()));
        self.wait(None)?;
        buffers.iter().map(|buffer| Ok(buffer.get_mapped_range(..)?.to_vec())).collect()
    }
}

/// Makes the pipeline that draws a triangle over the whole image with a fragment shader of scene.wgsl.
fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    fragment: &str,
    colors: &[TextureFormat],
    depth: Option<TextureFormat>,
) -> wgpu::RenderPipeline {
    let targets: Vec<_> = colors.iter().map(|format| Some((*format).into())).collect();
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
        layout: None,
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("whole_image"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: depth.map(|format| wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(fragment),
            compilation_options: Default::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Records a render pass that clears its images and draws one triangle over them.
fn render(
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::RenderPipeline,
    bindings: &wgpu::BindGroup,
    colors: &[&Picture],
    depth: Option<&Picture>,
) {
    let (ops, depth_slice, resolve_target) = (wgpu::Operations::default(), None, None);
    let color = |view| wgpu::RenderPassColorAttachment { view, depth_slice, resolve_target, ops };
    let attachments: Vec<_> = colors.iter().map(|picture| Some(color(&picture.view))).collect();
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &attachments,
        depth_stencil_attachment: depth.map(|depth| wgpu::RenderPassDepthStencilAttachment {
            view: &depth.view,
            depth_ops: Some(wgpu::Operations::default()),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, bindings, &[]);
    pass.draw(0..3, 0..1);
}
