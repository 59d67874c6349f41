//! Compiled shaders, and the Rust twins of their blocks, which `build.rs` generates.

/// A compiled stage and what it binds.
#[derive(Debug)]
pub struct Shader {
    /// Path under `shaders-glsl/` and the defined macros, for labels and errors; no other shader has this name.
    pub name: &'static str,
    /// Path under `shaders-glsl/`.
    pub file: &'static str,
    /// Macros that are defined.
    pub defines: &'static [&'static str],
    /// SPIR-V.
    pub spirv: &'static [u8],
    /// Bytes of the push-constant block.
    pub push_constant_size: u32,
    /// Threads of a workgroup (compute).
    pub local_size: [u32; 3],
    /// Bindings of descriptor set 0.
    pub bindings: &'static [Binding],
    /// Binding and format of the image for each output, by location, if this is a compute shader of a program that has
    /// fragment shaders, too; else empty.
    pub stored: &'static [(u32, ash::vk::Format)],
}

/// One descriptor of a shader.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Binding {
    /// The variable's name, or the block's where the variable has none.
    pub name: &'static str,
    /// `layout(binding = …)`.
    pub binding: u32,
    /// Kind of the resource.
    pub kind: BindingKind,
    /// Number of descriptors; above 1 for an array of images.
    pub count: u32,
}

/// The kind of a descriptor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BindingKind {
    /// An image with its sampler.
    SampledImage,
    /// An image for load and store.
    StorageImage,
    /// A buffer that is read as texels of a format.
    StorageTexels,
    /// An acceleration structure for ray queries.
    RayStructure,
    /// A uniform block.
    UniformBuffer,
    /// A storage block.
    StorageBuffer,
}

/// New code, by [`Shader::name`], for shaders whose files changed. Pipelines that are made after the change have it.
#[cfg(feature = "reload")]
#[derive(Debug, Default)]
pub struct ReplacedShaders(std::sync::Mutex<std::collections::HashMap<&'static str, std::sync::Arc<[u8]>>>);

#[cfg(feature = "reload")]
impl ReplacedShaders {
    /// The code that replaces a shader's, if there is any.
    pub fn get(&self, name: &str) -> Option<std::sync::Arc<[u8]>> {
        self.lock().get(name).cloned()
    }

    /// Replaces a shader's code, or goes back to the compiled-in code for `None`. Returns the earlier replacement.
    pub fn set(&self, shader: &Shader, spirv: Option<std::sync::Arc<[u8]>>) -> Option<std::sync::Arc<[u8]>> {
        match spirv {
            Some(spirv) => self.lock().insert(shader.name, spirv),
            None => self.lock().remove(shader.name),
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, std::collections::HashMap<&'static str, std::sync::Arc<[u8]>>> {
        self.0.lock().unwrap_or_else(|e| e.into_inner())
    }
}

include!(concat!(env!("OUT_DIR"), "/blocks.rs"));
