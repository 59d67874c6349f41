#!/usr/bin/env bash
# Lavapipe (Mesa): packSnorm4x8 of constants has other bits than packSnorm4x8 of the same numbers from a buffer. A negative component among
# the first three sets every bit above its own byte. Expected: one result, with eight bits for each component, as GLSL defines it.
# Seen, with Debian 12's Mesa 22.3.6: (-0.5, 0.5, 0.25, 1) from a buffer is 7f2040c0. The constant is ffffffc0, whose other three components
# are read as -1/127. packSnorm2x16 is right both ways. The driver folds the constant: the shader that it gets still calls the function.
#
# findings/vulkan.sh installs what this needs.
set -euo pipefail

. "$(dirname "$0")/vulkan.sh" lvp
cat >"$scratch/pack.comp" <<'GLSL'
#version 460
layout(local_size_x = 1) in;
layout(std430, binding = 0) writeonly buffer Seen { uint seen[4]; };
layout(std430, binding = 1) readonly buffer Given { vec4 given; };
void main() {
    seen[0] = packSnorm4x8(vec4(-0.5, 0.5, 0.25, 1.0));
    seen[1] = packSnorm4x8(given);
    seen[2] = packSnorm2x16(vec2(-0.5, 0.5));
    seen[3] = packSnorm2x16(given.xy);
}
GLSL
glslangValidator -V "$scratch/pack.comp" -o "$scratch/pack.spv" >/dev/null
spirv-val "$scratch/pack.spv"
echo "calls of packSnorm4x8 in the shader: $(spirv-dis "$scratch/pack.spv" | grep -c PackSnorm4x8)"
cat >"$scratch/pack.py" <<'PY'
import struct
import sys

import vulkan as vk

SIZE = 16
application = vk.VkApplicationInfo(apiVersion=vk.VK_MAKE_VERSION(1, 3, 0))
instance = vk.vkCreateInstance(vk.VkInstanceCreateInfo(pApplicationInfo=application), None)
gpu = vk.vkEnumeratePhysicalDevices(instance)[0]
families = [vk.VkDeviceQueueCreateInfo(queueFamilyIndex=0, pQueuePriorities=[1.0])]
device = vk.vkCreateDevice(gpu, vk.VkDeviceCreateInfo(pQueueCreateInfos=families), None)
queue = vk.vkGetDeviceQueue(device, 0, 0)
memory = vk.vkGetPhysicalDeviceMemoryProperties(gpu)
host = vk.VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | vk.VK_MEMORY_PROPERTY_HOST_COHERENT_BIT
kind = next(i for i in range(memory.memoryTypeCount) if memory.memoryTypes[i].propertyFlags & host == host)
storage, compute = vk.VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, vk.VK_SHADER_STAGE_COMPUTE_BIT


def buffer():
    made = vk.vkCreateBuffer(device, vk.VkBufferCreateInfo(size=SIZE, usage=vk.VK_BUFFER_USAGE_STORAGE_BUFFER_BIT), None)
    size = vk.vkGetBufferMemoryRequirements(device, made).size
    held = vk.vkAllocateMemory(device, vk.VkMemoryAllocateInfo(allocationSize=size, memoryTypeIndex=kind), None)
    vk.vkBindBufferMemory(device, made, held, 0)
    return made, vk.vkMapMemory(device, held, 0, SIZE, 0)


seen, words = buffer()
given, numbers = buffer()
numbers[0:SIZE] = struct.pack("<4f", -0.5, 0.5, 0.25, 1.0)
with open(sys.argv[1], "rb") as file:
    code = file.read()
module = vk.vkCreateShaderModule(device, vk.VkShaderModuleCreateInfo(codeSize=len(code), pCode=code), None)
bindings = [vk.VkDescriptorSetLayoutBinding(i, storage, 1, compute) for i in range(2)]
set_layout = vk.vkCreateDescriptorSetLayout(device, vk.VkDescriptorSetLayoutCreateInfo(pBindings=bindings), None)
layout = vk.vkCreatePipelineLayout(device, vk.VkPipelineLayoutCreateInfo(pSetLayouts=[set_layout]), None)
stage = vk.VkPipelineShaderStageCreateInfo(stage=compute, module=module, pName="main")
pipeline = vk.vkCreateComputePipelines(device, None, 1, [vk.VkComputePipelineCreateInfo(stage=stage, layout=layout)], None)[0]
sizes = [vk.VkDescriptorPoolSize(storage, 2)]
pool = vk.vkCreateDescriptorPool(device, vk.VkDescriptorPoolCreateInfo(maxSets=1, pPoolSizes=sizes), None)
info = vk.VkDescriptorSetAllocateInfo(descriptorPool=pool, pSetLayouts=[set_layout])
bound = vk.vkAllocateDescriptorSets(device, info)[0]
writes = [
    vk.VkWriteDescriptorSet(dstSet=bound, dstBinding=i, descriptorCount=1, descriptorType=storage,
                            pBufferInfo=[vk.VkDescriptorBufferInfo(made, 0, SIZE)])
    for i, made in enumerate((seen, given))
]
vk.vkUpdateDescriptorSets(device, len(writes), writes, 0, None)
commands = vk.vkCreateCommandPool(device, vk.VkCommandPoolCreateInfo(queueFamilyIndex=0), None)
primary = vk.VK_COMMAND_BUFFER_LEVEL_PRIMARY
info = vk.VkCommandBufferAllocateInfo(commandPool=commands, level=primary, commandBufferCount=1)
work = vk.vkAllocateCommandBuffers(device, info)[0]
vk.vkBeginCommandBuffer(work, vk.VkCommandBufferBeginInfo())
vk.vkCmdBindPipeline(work, vk.VK_PIPELINE_BIND_POINT_COMPUTE, pipeline)
vk.vkCmdBindDescriptorSets(work, vk.VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, [bound], 0, None)
vk.vkCmdDispatch(work, 1, 1, 1)
vk.vkEndCommandBuffer(work)
vk.vkQueueSubmit(queue, 1, [vk.VkSubmitInfo(pCommandBuffers=[work])], None)
vk.vkQueueWaitIdle(queue)
found = [f"{word:08x}" for word in struct.unpack("<4I", bytes(words[0:SIZE]))]
print(f"packSnorm4x8: constant {found[0]}, from a buffer {found[1]}\npackSnorm2x16: constant {found[2]}, from a buffer {found[3]}")
if found != ["ffffffc0", "7f2040c0", "4000c000", "4000c000"]:
    sys.exit("this changed: it was ffffffc0 and 7f2040c0, and 4000c000 twice")
PY
python "$scratch/pack.py" "$scratch/pack.spv"
