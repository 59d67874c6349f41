//! Statistics of a device's compiler about the programs of frames, by VK_KHR_pipeline_executable_properties: they exist
//! only on a device that was opened with [`DeviceQuery::compiles_only`](super::DeviceQuery::compiles_only).

use super::device::{Gpu, text, vulkan};
use super::pipeline::SharedPipeline;
use crate::error::{Error, Result};
use ash::vk;
use std::ffi::CStr;
use std::sync::{Arc, Mutex, PoisonError};

/// The code that a device compiled for a stage of a pipeline (a pipeline executable of Vulkan).
#[derive(Debug, Clone, PartialEq)]
pub struct Executable {
    /// The driver's own name.
    pub name: String,
    /// Stage that the code is for, such as "fragment" or "compute"; several stages have "+" between them.
    pub stage: String,
    /// Invocations of a subgroup.
    pub subgroup_size: u32,
    /// The driver's statistics, in its order.
    pub statistics: Vec<Statistic>,
}

/// A number that a driver states about an executable.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistic {
    /// The driver's own name.
    pub name: String,
    /// What the number counts, in the driver's words.
    pub about: String,
    /// The number; a truth value is 0 or 1.
    pub value: f64,
}

/// A program that a pass of a frame ran.
#[derive(Debug, Clone, PartialEq)]
pub struct CompiledProgram {
    /// Label of the pass.
    pub pass: String,
    /// Whether the pass counts towards the method's time.
    pub counted: bool,
    /// Name of the program: the path of its shader under `shaders-glsl/`, and the macros that are defined for it.
    pub program: String,
    /// Ids and bits of the specialization constants.
    pub constants: Vec<(u32, u32)>,
    /// The code that the stages were compiled to.
    pub executables: Vec<Executable>,
}

/// The functions of the extension, and the passes of frames with the pipelines that they ran.
pub(crate) struct Executables {
    functions: ash::khr::pipeline_executable_properties::Device,
    pass_pipelines: Mutex<Vec<PassPipeline>>,
}

/// A pass of a frame, whether it counts towards the method's time, and a pipeline that it ran.
struct PassPipeline {
    pass: String,
    counted: bool,
    pipeline: Arc<SharedPipeline>,
}

impl Executables {
    /// The extension by which a driver describes compiled pipelines.
    pub const EXTENSION: &'static CStr = ash::khr::pipeline_executable_properties::NAME;

    /// Loads the functions of a device on which the extension is on.
    pub fn new(instance: &ash::Instance, device: &ash::Device) -> Self {
        let functions = ash::khr::pipeline_executable_properties::Device::new(instance, device);
        Self { functions, pass_pipelines: Mutex::default() }
    }

    /// Notes that a pass runs a pipeline.
    pub fn note(&self, pass: &str, counted: bool, pipeline: &Arc<SharedPipeline>) {
        let pass_pipeline = PassPipeline { pass: pass.to_owned(), counted, pipeline: Arc::clone(pipeline) };
        self.pass_pipelines.lock().unwrap_or_else(PoisonError::into_inner).push(pass_pipeline);
    }

    /// Takes out the passes that were noted since the last call.
    fn take_passes(&self) -> Vec<PassPipeline> {
        std::mem::take(&mut *self.pass_pipelines.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Asks the driver for the code that each stage of a pipeline was compiled to.
    fn compiled_code(&self, pipeline: &SharedPipeline) -> Result<Vec<Executable>> {
        let failure = |call: &str| vulkan(format!("{call} for {}", pipeline.name));
        let info = vk::PipelineInfoKHR::default().pipeline(pipeline.handle);
        // SAFETY: the pipeline is alive and was made with its statistics captured.
        let properties = unsafe { self.functions.get_pipeline_executable_properties(&info) }
            .map_err(failure("vkGetPipelineExecutablePropertiesKHR"))?;
        let executable = |(index, stage): (usize, &vk::PipelineExecutablePropertiesKHR)| {
            let info =
                vk::PipelineExecutableInfoKHR::default().pipeline(pipeline.handle).executable_index(index as u32);
            // SAFETY: the pipeline is alive, and the index is below the number of its executables.
            let statistics = unsafe { self.functions.get_pipeline_executable_statistics(&info) }
                .map_err(failure("vkGetPipelineExecutableStatisticsKHR"))?;
            Ok(Executable {
                name: text(stage.name_as_c_str()),
                stage: stages(stage.stages),
                subgroup_size: stage.subgroup_size,
                statistics: statistics.iter().map(statistic).collect(),
            })
        };
        properties.iter().enumerate().map(executable).collect()
    }
}

/// Returns the names of shader stages, with "+" between them.
fn stages(flags: vk::ShaderStageFlags) -> String {
    let known = [
        (vk::ShaderStageFlags::VERTEX, "vertex"),
        (vk::ShaderStageFlags::FRAGMENT, "fragment"),
        (vk::ShaderStageFlags::COMPUTE, "compute"),
    ];
    let names: Vec<&str> = known.iter().filter(|(flag, _)| flags.contains(*flag)).map(|(_, name)| *name).collect();
    if names.is_empty() { format!("{flags:?}") } else { names.join("+") }
}

/// Converts a driver's statistic, whatever the type of its number, to one with an f64.
fn statistic(stated: &vk::PipelineExecutableStatisticKHR) -> Statistic {
    use vk::PipelineExecutableStatisticFormatKHR as Format;
    // SAFETY: the format says which field of the union the driver wrote.
    let value = unsafe {
        match stated.format {
            Format::BOOL32 => f64::from(stated.value.b32),
            Format::INT64 => stated.value.i64 as f64,
            Format::FLOAT64 => stated.value.f64,
            _ => stated.value.u64 as f64,
        }
    };
    Statistic { name: text(stated.name_as_c_str()), about: text(stated.description_as_c_str()), value }
}

impl Gpu {
    /// Returns the programs of the passes that were recorded since the last call, in order, with their compiled code.
    ///
    /// # Errors
    /// [`Error::Usage`] on a device that was not opened to compile only; errors of the driver.
    pub fn take_programs(&self) -> Result<Vec<CompiledProgram>> {
        let Some(executables) = &self.shared().executables else {
            return Err(Error::Usage("this device was not opened to tell what its compiler made".into()));
        };
        let program = |pass_pipeline: PassPipeline| {
            Ok(CompiledProgram {
                executables: executables.compiled_code(&pass_pipeline.pipeline)?,
                program: pass_pipeline.pipeline.name.to_owned(),
                constants: pass_pipeline.pipeline.constants.clone(),
                pass: pass_pipeline.pass,
                counted: pass_pipeline.counted,
            })
        };
        executables.take_passes().into_iter().map(program).collect()
    }
}
