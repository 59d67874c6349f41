//! Makes and draws the render passes before and after the reflections, in wgpu, and the textures that they draw to.

use embed_wgpu::{HALF, Result, description};
use wgpu::{TextureFormat, TextureUsages as U};

/// Format of the material image: reflectivity and roughness.
pub const PAIR: TextureFormat = TextureFormat::Rg16Float;
/// Format of the copy of depth that [`crate::KeepImages`] writes.
pub const DEPTH: TextureFormat = TextureFormat::R32Float;

/// A texture with its view.
pub struct Picture {
    pub texture: wgpu::Texture,
    pub view: wgpu::TextureView,
}

/// The uniform block `View` of passes.wgsl, where its fields are described.
pub struct View {
    pub world_from_clip: [f32; 16],
    pub view_from_world: [f32; 16],
    pub eye: [f32; 4],
    pub environment: [f32; 4],
    pub fade: [f32; 2],
    pub exposure: f32,
    pub levels: f32,
}

impl View {
    /// Size of the block.
    pub const BYTES: u64 = 4 * 44;

    /// The block as passes.wgsl reads it.
    pub fn bytes(&self) -> Vec<u8> {
        let Self { world_from_clip, view_from_world, eye, environment, fade, exposure, levels } = self;
        let last = [*exposure, *levels];
        let parts: [&[f32]; 6] = [world_from_clip, view_from_world, eye, environment, fade, &last];
        parts.concat().iter().flat_map(|number| number.to_ne_bytes()).collect()
    }
}

/// The pipelines of passes.wgsl, each named after its fragment shader.
pub struct Passes {
    pub inputs: wgpu::RenderPipeline,
    pub add: wgpu::RenderPipeline,
    pub face: wgpu::RenderPipeline,
    pub depth: wgpu::RenderPipeline,
    pub sampler: wgpu::Sampler,
    /// A cube map of one black texel on each face, which is bound where there is no environment map.
    pub nothing: Picture,
}

impl Passes {
    /// Makes the pipelines on a device.
    pub fn new(device: &wgpu::Device) -> Self {
        let module = device.create_shader_module(wgpu::include_wgsl!("passes.wgsl"));
        let pipeline = |fragment, colors: &[TextureFormat]| pipeline(device, &module, fragment, colors);
        Self {
            inputs: pipeline("inputs", &[HALF, PAIR]),
            add: pipeline("add", &[HALF]),
            face: pipeline("face", &[HALF]),
            depth: pipeline("depth", &[DEPTH]),
            sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..Default::default()
            }),
            nothing: cube(device, 1, wgpu::TextureViewDimension::Cube),
        }
    }
}

/// Makes the pipeline that draws a triangle over the whole image with a fragment shader of passes.wgsl.
fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    fragment: &str,
    colors: &[TextureFormat],
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
        depth_stencil: None,
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

impl Passes {
    /// Draws the environment map into a new cube map, which is looked up by directions of the world. `bindings` are
    /// those of the pass "face", and `side` is the number of texels along a side.
    pub fn sky(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        bindings: &[(u32, wgpu::BindingResource)],
        side: u32,
    ) -> Picture {
        let sky = cube(device, side, wgpu::TextureViewDimension::D2Array);
        for face in 0..6 {
            let view = sky.texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: face,
                array_layer_count: Some(1),
                ..Default::default()
            });
            draw(device, encoder, &self.face, bindings, &[&view], face);
        }
        sky
    }
}

/// Draws a triangle over the whole of `targets` with bindings of passes.wgsl. `instance` is the face of a cube for the
/// pass "face", and 0 for other passes.
pub fn draw(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::RenderPipeline,
    bindings: &[(u32, wgpu::BindingResource)],
    targets: &[&wgpu::TextureView],
    instance: u32,
) {
    let entries: Vec<_> = bindings
        .iter()
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding: *binding, resource: resource.clone() })
        .collect();
    let layout = &pipeline.get_bind_group_layout(0);
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });
    let (ops, depth_slice, resolve_target) = (wgpu::Operations::default(), None, None);
    let color = |view| Some(wgpu::RenderPassColorAttachment { view, depth_slice, resolve_target, ops });
    let attachments: Vec<_> = targets.iter().map(|view| color(*view)).collect();
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("ssct"),
        color_attachments: &attachments,
        ..Default::default()
    });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.draw(0..3, instance..instance + 1);
}

/// Makes an image that a pass draws and that later passes and copies read.
pub fn picture(device: &wgpu::Device, name: &str, [width, height]: [u32; 2], format: TextureFormat) -> Picture {
    let usage = U::RENDER_ATTACHMENT | U::TEXTURE_BINDING | U::COPY_SRC;
    let texture = device.create_texture(&description(name, [width, height, 1], format, usage));
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    Picture { texture, view }
}

/// Makes a cube map of colours with one mip level.
pub fn cube(device: &wgpu::Device, side: u32, dimension: wgpu::TextureViewDimension) -> Picture {
    let usage = U::RENDER_ATTACHMENT | U::TEXTURE_BINDING;
    let texture = device.create_texture(&description("ssct sky", [side, side, 6], HALF, usage));
    let view = texture.create_view(&wgpu::TextureViewDescriptor { dimension: Some(dimension), ..Default::default() });
    Picture { texture, view }
}

/// Wraps an image that `ssct` made as a texture of wgpu. The image is in the state `RESOURCE`.
pub fn adopt(device: &wgpu::Device, image: &ssct::OutputImage) -> Result<Picture> {
    let texture = embed_wgpu::adopt(device, "ssct reflection", image)?;
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    Ok(Picture { texture, view })
}
