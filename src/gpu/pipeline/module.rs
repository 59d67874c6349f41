//! Shader modules.

use crate::error::{Error, Result};
use crate::gpu::device::{Gpu, vulkan};
use crate::gpu::shader::Shader;
use ash::vk;

/// A shader module, alive while a pipeline is made from it.
pub(super) struct Module {
    gpu: Gpu,
    handle: vk::ShaderModule,
}

impl Module {
    /// Makes the module of a shader from its compiled-in code, or from new code if the shader changed meanwhile.
    pub(super) fn new(gpu: &Gpu, shader: &Shader) -> Result<Self> {
        #[cfg(feature = "reload")]
        let replaced = match gpu.shared().replaced_shaders.get(shader.name) {
            Some(code) => Some(code),
            None => crate::gpu::sources::code_from_folder(shader)?,
        };
        #[cfg(not(feature = "reload"))]
        let replaced: Option<std::sync::Arc<[u8]>> = None;
        let words = ash::util::read_spv(&mut std::io::Cursor::new(replaced.as_deref().unwrap_or(shader.spirv)))
            .map_err(|e| Error::Memory { what: shader.name.to_owned(), message: e.to_string() })?;
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: the words are a module that shaderc made; destroyed in `drop`.
        let handle = unsafe { gpu.raw().create_shader_module(&info, None) }
            .map_err(vulkan(format!("vkCreateShaderModule for {}", shader.name)))?;
        gpu.name(handle, shader.name);
        Ok(Self { gpu: gpu.clone(), handle })
    }

    pub(super) fn stage(&self, stage: vk::ShaderStageFlags) -> vk::PipelineShaderStageCreateInfo<'static> {
        vk::PipelineShaderStageCreateInfo::default().stage(stage).module(self.handle).name(c"main")
    }
}

impl Drop for Module {
    fn drop(&mut self) {
        // SAFETY: pipelines keep what they need of a module.
        unsafe { self.gpu.raw().destroy_shader_module(self.handle, None) };
    }
}
