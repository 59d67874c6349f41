# Sourced by findings about RADV, Mesa's Vulkan driver for AMD's GPUs, which compiles for a GPU that is not there where RADV_FORCE_FAMILY
# names one. `statistics SHADER VALUE` prints what the driver states of a compute shader with two storage images, whose constant 0 is VALUE,
# as lines "NAME: NUMBER". What it needs is installed by findings/vulkan.sh.

. "$(dirname "$0")/vulkan.sh" radeon
export RADV_FORCE_FAMILY=NAVI21

cat >"$scratch/statistics.py" <<'PY'
import sys

import vulkan as vk

application = vk.VkApplicationInfo(apiVersion=vk.VK_MAKE_VERSION(1, 3, 0))
instance = vk.vkCreateInstance(vk.VkInstanceCreateInfo(pApplicationInfo=application), None)
gpu = vk.vkEnumeratePhysicalDevices(instance)[0]
feature = vk.VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR(pipelineExecutableInfo=1)
queue = vk.VkDeviceQueueCreateInfo(queueFamilyIndex=0, pQueuePriorities=[1.0])
extensions = ["VK_KHR_pipeline_executable_properties"]
device = vk.vkCreateDevice(
    gpu, vk.VkDeviceCreateInfo(pNext=feature, pQueueCreateInfos=[queue], ppEnabledExtensionNames=extensions), None
)
with open(sys.argv[1], "rb") as file:
    code = file.read()
module = vk.vkCreateShaderModule(device, vk.VkShaderModuleCreateInfo(codeSize=len(code), pCode=code), None)
image, compute = vk.VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, vk.VK_SHADER_STAGE_COMPUTE_BIT
bindings = [vk.VkDescriptorSetLayoutBinding(i, image, 1, compute) for i in range(2)]
set_layout = vk.vkCreateDescriptorSetLayout(device, vk.VkDescriptorSetLayoutCreateInfo(pBindings=bindings), None)
layout = vk.vkCreatePipelineLayout(device, vk.VkPipelineLayoutCreateInfo(pSetLayouts=[set_layout]), None)
value = vk.ffi.new("int32_t *", int(sys.argv[2]))
entry = vk.VkSpecializationMapEntry(0, 0, 4)
constants = vk.VkSpecializationInfo(pMapEntries=[entry], dataSize=4, pData=value)
stage = vk.VkPipelineShaderStageCreateInfo(stage=compute, module=module, pName="main", pSpecializationInfo=constants)
flags = vk.VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR
info = vk.VkComputePipelineCreateInfo(flags=flags, stage=stage, layout=layout)
pipeline = vk.vkCreateComputePipelines(device, None, 1, [info], None)[0]
ask = vk.vkGetDeviceProcAddr(device, "vkGetPipelineExecutableStatisticsKHR")
for statistic in ask(device, vk.VkPipelineExecutableInfoKHR(pipeline=pipeline, executableIndex=0)):
    name = statistic.name if isinstance(statistic.name, str) else vk.ffi.string(statistic.name).decode()
    print(f"{name}: {statistic.value.u64}")
PY

statistics() {
    glslangValidator -V "$1" -o "$1.spv" >/dev/null
    python "$scratch/statistics.py" "$1.spv" "$2" 2>/dev/null
}

# The number of a statistic, by its name, from those that stand in the standard input.
number() {
    sed -n "s/^$1: //p"
}
