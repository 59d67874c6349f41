//! Graphics and compute pipelines, typed by their programs. The layout of set 0 comes from the shaders' reflection, and its sets come
//! from pools (`frame/sets.rs`). The device keeps compiled pipelines (`pipelines.rs`).

mod module;

use super::device::{Gpu, vulkan};
use super::image;
use super::limits;
use super::pipelines::{Key, VerticesKey};
use super::pixels::ShaderStage;
use super::program::{
    self, Fragment, Permutation, PermutationChoice, Program, RaySource, VertexProgram, constant_entries,
    find_permutation, permutations_agree,
};
use super::programs::Fullscreen;
use super::shader::{Binding, BindingKind, Shader};
use crate::error::{Error, Result};
use ash::vk;
use module::Module;
use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The layouts of a graphics or compute pipeline.
pub(crate) struct Layout {
    device: ash::Device,
    pub set: vk::DescriptorSetLayout,
    pub pipeline: vk::PipelineLayout,
    pub bindings: Vec<Binding>,
    pub stages: vk::ShaderStageFlags,
}

/// A fragment and a vertex program with their fixed state. By default, `V` makes the triangle that covers the targets.
pub struct GraphicsPipeline<F, V = Fullscreen> {
    pub(crate) graphics: Arc<SharedPipeline>,
    /// The fragment program's shader.
    pub(crate) fragment: &'static Shader,
    /// Keeps the device until the pipeline is gone.
    _gpu: Gpu,
    programs: PhantomData<fn() -> (F, V)>,
}

/// A compute program.
pub struct ComputePipeline<P> {
    pub(crate) compute: Arc<SharedPipeline>,
    pub(crate) shader: &'static Shader,
    /// Keeps the device until the pipeline is gone.
    _gpu: Gpu,
    program: PhantomData<fn() -> P>,
}

/// A compiled graphics or compute pipeline, which all users share. This struct holds no [`Gpu`], since the device keeps
/// the pipeline, and two values that keep each other are never dropped.
pub(crate) struct SharedPipeline {
    pub layout: Layout,
    pub handle: vk::Pipeline,
    pub name: &'static str,
    /// Ids and bits of the specialization constants.
    pub constants: Vec<(u32, u32)>,
    /// Threads of a workgroup; 0 for a graphics pipeline.
    pub local_size: [u32; 3],
    /// Whether the pipeline drew before (`frame/quirks/settle.rs`).
    pub settled: Arc<AtomicBool>,
}

/// What a pipeline does with the stencil of its depth target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Stencil {
    /// Sets the stencil to 1.
    Mark,
    /// Draws only where the stencil is 1.
    OnlyMarked,
}

/// The depth target of a pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct DepthState {
    format: vk::Format,
    /// Whether depth is tested and written.
    tested: bool,
    stencil: Option<Stencil>,
}

/// What a draw reads per vertex.
#[derive(Debug, Clone, Copy)]
pub struct VertexInput<'a> {
    /// Bytes from one vertex to the next.
    pub stride: u32,
    /// Format and offset of each location, in order.
    pub attributes: &'a [(vk::Format, u32)],
}

/// The primitives that a graphics pipeline draws. Without an input, shaders make vertices from their numbers.
pub(super) enum Geometry<'a> {
    Triangles(Option<VertexInput<'a>>),
    Points,
}

impl Layout {
    /// Makes the layouts for all bindings and push constants of some shaders. Fails if they exceed the device's limits.
    fn new(gpu: &Gpu, shaders: &[(&Shader, vk::ShaderStageFlags)]) -> Result<Self> {
        let mut bindings: Vec<Binding> = Vec::new();
        for (shader, _) in shaders {
            for b in shader.bindings {
                if !bindings.iter().any(|known| known.binding == b.binding) {
                    bindings.push(*b);
                }
            }
        }
        limits::check(gpu, &shaders.iter().map(|(shader, _)| *shader).collect::<Vec<_>>(), &bindings)?;
        let stages = shaders.iter().fold(vk::ShaderStageFlags::empty(), |s, (_, stage)| s | *stage);
        let push_size = shaders.iter().map(|(s, _)| s.push_constant_size).max().unwrap_or(0);
        let name = shaders.last().map_or("", |(s, _)| s.name);
        let descriptors: Vec<_> = bindings
            .iter()
            .map(|b| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(b.binding)
                    .descriptor_type(b.kind.descriptor_type())
                    .descriptor_count(b.count)
                    .stage_flags(stages)
            })
            .collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&descriptors);
        // SAFETY: the create infos live through the calls; both handles are destroyed in `drop`.
        let set = unsafe { gpu.raw().create_descriptor_set_layout(&info, None) }
            .map_err(vulkan(format!("vkCreateDescriptorSetLayout for {name}")))?;
        let device = gpu.raw().clone();
        let mut layout = Self { device, set, pipeline: vk::PipelineLayout::null(), bindings, stages };
        let (sets, pushes) = ([set], [vk::PushConstantRange { stage_flags: stages, offset: 0, size: push_size }]);
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets).push_constant_ranges(if push_size > 0 {
            &pushes
        } else {
            &[]
        });
        // SAFETY: the create info lives through the call; the handle is destroyed in `drop`.
        layout.pipeline = unsafe { gpu.raw().create_pipeline_layout(&info, None) }
            .map_err(vulkan(format!("vkCreatePipelineLayout for {name}")))?;
        gpu.name(layout.pipeline, name);
        Ok(layout)
    }
}

impl BindingKind {
    pub(crate) fn descriptor_type(self) -> vk::DescriptorType {
        match self {
            Self::SampledImage => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            Self::StorageImage => vk::DescriptorType::STORAGE_IMAGE,
            Self::StorageTexels => vk::DescriptorType::STORAGE_TEXEL_BUFFER,
            Self::RayStructure => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
            Self::UniformBuffer => vk::DescriptorType::UNIFORM_BUFFER,
            Self::StorageBuffer => vk::DescriptorType::STORAGE_BUFFER,
        }
    }
}

impl Drop for Layout {
    fn drop(&mut self) {
        // SAFETY: the pipeline of this layout is destroyed before it (`drop` of the pipelines).
        unsafe {
            self.device.destroy_pipeline_layout(self.pipeline, None);
            self.device.destroy_descriptor_set_layout(self.set, None);
        }
    }
}

impl<F: Fragment> GraphicsPipeline<F> {
    /// Makes a pipeline of a fragment program over whole targets, with their formats: UNDEFINED for an unwanted output.
    pub fn fullscreen(gpu: &Gpu, targets: F::Outputs<vk::Format>) -> Result<Self>
    where
        F: Program<Constants = ()>,
    {
        Self::fullscreen_for_rays(gpu, None, targets, &())
    }

    /// Makes a full-screen pipeline of a program's permutation for a source of rays, with specialization constants.
    ///
    /// # Errors
    /// [`Error::Usage`] if the program has no permutation with this source.
    pub fn fullscreen_for_rays(
        gpu: &Gpu,
        rays: Option<RaySource>,
        targets: F::Outputs<vk::Format>,
        constants: &F::Constants,
    ) -> Result<Self> {
        Self::with_geometry(gpu, (rays, constants), Geometry::Triangles(None), targets, None)
    }

    /// Makes a pipeline that only marks, in the stencil of a depth target, the pixels that a fragment program keeps.
    pub fn marking(gpu: &Gpu, depth: vk::Format) -> Result<Self>
    where
        F: Fragment<Outputs<vk::Format> = [vk::Format; 0]> + Program<Constants = ()>,
    {
        let depth = DepthState { format: depth, tested: false, stencil: Some(Stencil::Mark) };
        Self::with_geometry(gpu, (None, &()), Geometry::Triangles(None), [], Some(depth))
    }
}

impl<F: Fragment, V: VertexProgram<Constants = ()>> GraphicsPipeline<F, V> {
    /// Makes a pipeline that draws points, which are squares of pixels. The vertex program places each by its number
    /// alone. The fragment program's permutation is the one with the source of rays `rays`.
    ///
    /// # Errors
    /// [`Error::Usage`] if the program has no permutation with this source.
    pub fn points(
        gpu: &Gpu,
        rays: Option<RaySource>,
        targets: F::Outputs<vk::Format>,
        constants: &F::Constants,
    ) -> Result<Self> {
        Self::with_geometry(gpu, (rays, constants), Geometry::Points, targets, None)
    }

    /// Makes a pipeline that draws both sides of triangles, with reversed depth: the greater depth wins, and of equal
    /// depths the last drawn. The viewport has negative height. A triangle whose winding agrees with its normal, by the
    /// usual cross product in our left-handed world, is therefore front-facing when it faces the camera.
    pub fn mesh(gpu: &Gpu, input: VertexInput, targets: F::Outputs<vk::Format>, depth: vk::Format) -> Result<Self>
    where
        F: Program<Constants = ()>,
    {
        let depth = DepthState { format: depth, tested: true, stencil: None };
        Self::with_geometry(gpu, (None, &()), Geometry::Triangles(Some(input)), targets, Some(depth))
    }

    /// Makes the pipeline of [`Self::mesh`] that draws only where a [`GraphicsPipeline::marking`] pipeline marked the
    /// stencil; the depth format must have a stencil.
    pub fn mesh_where_marked(
        gpu: &Gpu,
        input: VertexInput,
        targets: F::Outputs<vk::Format>,
        depth: vk::Format,
    ) -> Result<Self>
    where
        F: Program<Constants = ()>,
    {
        let depth = DepthState { format: depth, tested: true, stencil: Some(Stencil::OnlyMarked) };
        Self::with_geometry(gpu, (None, &()), Geometry::Triangles(Some(input)), targets, Some(depth))
    }

    /// Makes a pipeline for a kind of geometry and a depth target, with the chosen permutation of the fragment program.
    fn with_geometry(
        gpu: &Gpu,
        (rays, constants): (Option<RaySource>, &F::Constants),
        geometry: Geometry,
        targets: F::Outputs<vk::Format>,
        depth: Option<DepthState>,
    ) -> Result<Self> {
        const { assert!(permutations_agree(F::PERMUTATIONS, V::SHADER), "the stages disagree on a binding") };
        let choice = PermutationChoice { stage: ShaderStage::Fragment, rays };
        let chosen = find_permutation::<F>(choice, targets.as_ref())?;
        let (fragment, constants) = (chosen.shader, constant_entries(chosen, constants));
        let stages = Stages { vertex: V::SHADER, fragment, constants: &constants };
        let graphics = SharedPipeline::graphics(gpu, &stages, &geometry, targets.as_ref(), depth)?;
        Ok(Self { graphics, fragment, _gpu: gpu.clone(), programs: PhantomData })
    }
}

impl SharedPipeline {
    /// Returns the kept pipeline of these stages and targets, or makes it. Unwanted targets at the end are left out.
    fn graphics(
        gpu: &Gpu,
        stages: &Stages,
        geometry: &Geometry,
        targets: &[vk::Format],
        depth: Option<DepthState>,
    ) -> Result<Arc<Self>> {
        let wanted = targets.iter().rposition(|format| *format != vk::Format::UNDEFINED).map_or(0, |last| last + 1);
        let targets = &targets[..wanted];
        let key = Key {
            shaders: [Some(stages.vertex.name), Some(stages.fragment.name)],
            constants: stages.constants.to_vec(),
            targets: targets.to_vec(),
            depth,
            vertices: match geometry {
                Geometry::Points => VerticesKey::Points,
                Geometry::Triangles(None) => VerticesKey::Triangles,
                Geometry::Triangles(Some(input)) => VerticesKey::Meshes(input.stride, input.attributes.to_vec()),
            },
        };
        gpu.cached_pipeline(key, || Self::new_graphics(gpu, stages, geometry, targets, depth))
    }

    /// Compiles the pipeline of [`Self::graphics`].
    fn new_graphics(
        gpu: &Gpu,
        &Stages { vertex, fragment, constants }: &Stages,
        geometry: &Geometry,
        targets: &[vk::Format],
        depth: Option<DepthState>,
    ) -> Result<Self> {
        let layout =
            Layout::new(gpu, &[(vertex, vk::ShaderStageFlags::VERTEX), (fragment, vk::ShaderStageFlags::FRAGMENT)])?;
        let modules = [Module::new(gpu, vertex)?, Module::new(gpu, fragment)?];
        let (entries, values) = specialization(constants);
        let specialized = vk::SpecializationInfo::default().map_entries(&entries).data(bytemuck::cast_slice(&values));
        let stages = [
            modules[0].stage(vk::ShaderStageFlags::VERTEX),
            modules[1].stage(vk::ShaderStageFlags::FRAGMENT).specialization_info(&specialized),
        ];
        let (topology, input) = match geometry {
            Geometry::Triangles(input) => (vk::PrimitiveTopology::TRIANGLE_LIST, *input),
            Geometry::Points => (vk::PrimitiveTopology::POINT_LIST, None),
        };
        let vertex_bindings = input.map(|i| {
            [vk::VertexInputBindingDescription {
                binding: 0,
                stride: i.stride,
                input_rate: vk::VertexInputRate::VERTEX,
            }]
        });
        let attributes: Vec<_> = input
            .iter()
            .flat_map(|i| i.attributes)
            .zip(0..)
            .map(|(&(format, offset), location)| vk::VertexInputAttributeDescription {
                location,
                binding: 0,
                format,
                offset,
            })
            .collect();
        let vertex_state = vk::PipelineVertexInputStateCreateInfo::default()
            .vertex_binding_descriptions(vertex_bindings.as_ref().map_or(&[], |b| b.as_slice()))
            .vertex_attribute_descriptions(&attributes);
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(topology);
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(vk::PolygonMode::FILL)
            .cull_mode(vk::CullModeFlags::NONE)
            .front_face(vk::FrontFace::CLOCKWISE)
            .line_width(1.0);
        let multisample =
            vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let tested = depth.is_some_and(|d| d.tested);
        let mut depth_state = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(tested)
            .depth_write_enable(tested)
            .depth_compare_op(vk::CompareOp::GREATER_OR_EQUAL);
        if let Some(stencil) = depth.and_then(|d| d.stencil) {
            let state = stencil.state();
            depth_state = depth_state.stencil_test_enable(true).front(state).back(state);
        }
        let blends = vec![
            vk::PipelineColorBlendAttachmentState::default()
                .color_write_mask(vk::ColorComponentFlags::RGBA);
            targets.len()
        ];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
        let dynamic = vk::PipelineDynamicStateCreateInfo::default()
            .dynamic_states(&[vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR]);
        let mut rendering = vk::PipelineRenderingCreateInfo::default()
            .color_attachment_formats(targets)
            .depth_attachment_format(depth.map_or(vk::Format::UNDEFINED, |d| d.format));
        if let Some(depth) = depth.filter(|d| image::has_stencil(d.format)) {
            rendering = rendering.stencil_attachment_format(depth.format);
        }
        let info = vk::GraphicsPipelineCreateInfo::default()
            .flags(creation_flags(gpu))
            .stages(&stages)
            .vertex_input_state(&vertex_state)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&multisample)
            .depth_stencil_state(&depth_state)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(layout.pipeline)
            .push_next(&mut rendering);
        // SAFETY: everything that the create info points to is alive; destroyed in `drop`.
        let created = unsafe { gpu.raw().create_graphics_pipelines(vk::PipelineCache::null(), &[info], None) };
        let handle = only_pipeline(created, fragment.name)?;
        gpu.name(handle, fragment.name);
        let constants = constants.to_vec();
        Ok(Self { layout, handle, name: fragment.name, constants, local_size: [0; 3], settled: Arc::default() })
    }

    /// Returns the pipeline of two stages over whole targets. No type checks that the stages fit together.
    #[cfg(feature = "reload")]
    pub(super) fn whole_targets(gpu: &Gpu, stages: &Stages, targets: &[vk::Format]) -> Result<Arc<Self>> {
        Self::graphics(gpu, stages, &Geometry::Triangles(None), targets, None)
    }

    /// Returns the pipeline that the device keeps for this program and its constants, or makes it.
    pub(super) fn compute(gpu: &Gpu, shader: &'static Shader, constants: Vec<(u32, u32)>) -> Result<Arc<Self>> {
        let key = Key { shaders: [Some(shader.name), None], constants, ..Key::default() };
        let constants = key.constants.clone();
        gpu.cached_pipeline(key, || Self::new_compute(gpu, shader, &constants))
    }

    /// Compiles the pipeline of [`Self::compute`].
    fn new_compute(gpu: &Gpu, shader: &'static Shader, constants: &[(u32, u32)]) -> Result<Self> {
        let layout = Layout::new(gpu, &[(shader, vk::ShaderStageFlags::COMPUTE)])?;
        let module = Module::new(gpu, shader)?;
        let (entries, values) = specialization(constants);
        let specialized = vk::SpecializationInfo::default().map_entries(&entries).data(bytemuck::cast_slice(&values));
        let info = vk::ComputePipelineCreateInfo::default()
            .flags(creation_flags(gpu))
            .stage(module.stage(vk::ShaderStageFlags::COMPUTE).specialization_info(&specialized))
            .layout(layout.pipeline);
        // SAFETY: everything that the create info points to is alive; destroyed in `drop`.
        let created = unsafe { gpu.raw().create_compute_pipelines(vk::PipelineCache::null(), &[info], None) };
        let handle = only_pipeline(created, shader.name)?;
        gpu.name(handle, shader.name);
        let (constants, local_size) = (constants.to_vec(), shader.local_size);
        Ok(Self { layout, handle, name: shader.name, constants, local_size, settled: Arc::default() })
    }
}

/// The stages of a graphics pipeline.
pub(super) struct Stages<'c> {
    pub vertex: &'static Shader,
    pub fragment: &'static Shader,
    /// Id and bits of the fragment shader's specialization constants.
    pub constants: &'c [(u32, u32)],
}

impl Stencil {
    /// Returns the stencil test for both sides of triangles, with the reference value 1.
    fn state(self) -> vk::StencilOpState {
        let (pass_op, compare_op, write_mask) = match self {
            Self::Mark => (vk::StencilOp::REPLACE, vk::CompareOp::ALWAYS, 0xff),
            Self::OnlyMarked => (vk::StencilOp::KEEP, vk::CompareOp::EQUAL, 0),
        };
        vk::StencilOpState { pass_op, compare_op, compare_mask: 0xff, write_mask, reference: 1, ..Default::default() }
    }
}

impl<P: program::Compute> ComputePipeline<P> {
    /// Makes the pipeline of a compute program.
    pub fn new(gpu: &Gpu) -> Result<Self>
    where
        P: Program<Constants = ()>,
    {
        Self::with_constants(gpu, &())
    }

    /// Makes the pipeline of a program with specialization constants.
    pub fn with_constants(gpu: &Gpu, constants: &P::Constants) -> Result<Self> {
        Self::of_permutation(gpu, find_permutation::<P>(ShaderStage::Compute.into(), &[])?, constants)
    }

    /// Makes the pipeline of the permutation of a program with a source of rays.
    ///
    /// # Errors
    /// [`Error::Usage`] if the program has no permutation with this source.
    pub fn for_rays(gpu: &Gpu, rays: RaySource, constants: &P::Constants) -> Result<Self> {
        Self::of_permutation(gpu, find_permutation::<P>(PermutationChoice::compute(rays), &[])?, constants)
    }

    fn of_permutation(gpu: &Gpu, permutation: &Permutation, constants: &P::Constants) -> Result<Self> {
        let compute = SharedPipeline::compute(gpu, permutation.shader, constant_entries(permutation, constants))?;
        Ok(Self { compute, shader: permutation.shader, _gpu: gpu.clone(), program: PhantomData })
    }
}

/// Returns the creation flags of a pipeline. On a device that only compiles, they keep the compiler's statistics.
fn creation_flags(gpu: &Gpu) -> vk::PipelineCreateFlags {
    match gpu.shared().executables {
        Some(_) => vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR,
        None => vk::PipelineCreateFlags::empty(),
    }
}

/// Lays out specialization constants, each an id with its bits. Returns where each lies in the values, and the values.
fn specialization(constants: &[(u32, u32)]) -> (Vec<vk::SpecializationMapEntry>, Vec<u32>) {
    let size = size_of::<u32>();
    let entry = |(i, (constant_id, _)): (usize, &(u32, u32))| vk::SpecializationMapEntry {
        constant_id: *constant_id,
        offset: (size * i) as u32,
        size,
    };
    (constants.iter().enumerate().map(entry).collect(), constants.iter().map(|(_, bits)| *bits).collect())
}

/// Returns the one pipeline that a call made, or the call's error with the pipeline's name.
fn only_pipeline(
    created: std::result::Result<Vec<vk::Pipeline>, (Vec<vk::Pipeline>, vk::Result)>,
    name: &str,
) -> Result<vk::Pipeline> {
    let pipelines =
        created.map_err(|(_, result)| Error::Vulkan { what: format!("creating the pipeline {name}"), result })?;
    pipelines.first().copied().ok_or_else(|| Error::Vulkan {
        what: format!("creating the pipeline {name}"),
        result: vk::Result::ERROR_UNKNOWN,
    })
}

impl Drop for SharedPipeline {
    fn drop(&mut self) {
        // SAFETY: `FrameContext` waits for submissions before users are dropped; the device is alive (`Shared`).
        unsafe { self.layout.device.destroy_pipeline(self.handle, None) };
    }
}
