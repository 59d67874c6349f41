#!/usr/bin/env bash
# The Khronos validation layer gives the same best-practices message under another identifier in a younger version.
#
# Expected: pMessageIdName, by which programs and CI keep lists of messages that they accept, names a check for good.
# Seen with one dispatch of no workgroups, which Vulkan allows: layer 1.3.239 (Debian 12) says
# "UNASSIGNED-BestPractices-vkCmdDispatch-group-count-zero", and the layer of Chromium 156 says
# "BestPractices-vkCmdDispatch-group-count-zero". A list of accepted messages that was made with the one is silent about the
# other, so that a list needs both names, each with the versions that give it.
#
# Installs Debian's libvulkan1, mesa-vulkan-drivers and vulkan-validationlayers where they are missing (as root); unpacks
# Debian's chromium-common for its layer, and `vulkan` 1.3.275.1 from PyPI, into a temporary folder.
set -euo pipefail

packages=(libvulkan1 mesa-vulkan-drivers vulkan-validationlayers)
dpkg-query -W "${packages[@]}" >/dev/null 2>&1 ||
    { apt-get update -q && apt-get install -y -q --no-install-recommends "${packages[@]}"; } >/dev/null
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
python3 -m venv "$scratch/venv"
"$scratch/venv/bin/pip" install --quiet vulkan==1.3.275.1 cffi==2.1.1
(cd "$scratch" && apt-get download -q chromium-common >/dev/null 2>&1 && dpkg-deb -x chromium-common_*.deb unpacked)
library=$(find "$scratch/unpacked" -name libVkLayer_khronos_validation.so)
mkdir "$scratch/younger"
cat >"$scratch/younger/layer.json" <<JSON
{"file_format_version": "1.1.0", "layer": {"name": "VK_LAYER_KHRONOS_validation", "type": "GLOBAL",
 "library_path": "$library", "api_version": "1.3.0", "implementation_version": "1", "description": "of Chromium",
 "instance_extensions": [{"name": "VK_EXT_debug_utils", "spec_version": "1"},
  {"name": "VK_EXT_validation_features", "spec_version": "2"}]}}
JSON

cat >"$scratch/dispatch.py" <<'PY'
import struct

import vulkan as vk

# void main() {} of one thread a group.
WORDS = [0x07230203, 0x00010000, 0, 5, 0, 0x00020011, 1, 0x0003000E, 0, 1,
         0x0005000F, 5, 1, 0x6E69616D, 0, 0x00060010, 1, 17, 1, 1, 1,
         0x00020013, 2, 0x00030021, 3, 2, 0x00050036, 2, 1, 0, 3, 0x000200F8, 4, 0x000100FD, 0x00010038]
found = set()


def said(severity, kinds, data, user):
    name = vk.ffi.string(data.pMessageIdName).decode() if data.pMessageIdName else ""
    if "group-count-zero" in name:
        found.add(name)
    return 0


messenger = vk.VkDebugUtilsMessengerCreateInfoEXT(
    messageSeverity=0x1111, messageType=vk.VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT
    | vk.VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT, pfnUserCallback=said)
features = vk.VkValidationFeaturesEXT(
    enabledValidationFeatureCount=1,
    pEnabledValidationFeatures=[vk.VK_VALIDATION_FEATURE_ENABLE_BEST_PRACTICES_EXT])
instance = vk.vkCreateInstance(vk.VkInstanceCreateInfo(
    pNext=features, pApplicationInfo=vk.VkApplicationInfo(apiVersion=vk.VK_MAKE_VERSION(1, 1, 0)),
    ppEnabledLayerNames=["VK_LAYER_KHRONOS_validation"],
    ppEnabledExtensionNames=["VK_EXT_debug_utils", "VK_EXT_validation_features"]), None)
vk.vkGetInstanceProcAddr(instance, "vkCreateDebugUtilsMessengerEXT")(instance, messenger, None)
gpu = vk.vkEnumeratePhysicalDevices(instance)[0]
device = vk.vkCreateDevice(gpu, vk.VkDeviceCreateInfo(
    pQueueCreateInfos=[vk.VkDeviceQueueCreateInfo(queueFamilyIndex=0, pQueuePriorities=[1.0])]), None)
code = struct.pack(f"<{len(WORDS)}I", *WORDS)
module = vk.vkCreateShaderModule(device, vk.VkShaderModuleCreateInfo(codeSize=len(code), pCode=code), None)
layout = vk.vkCreatePipelineLayout(device, vk.VkPipelineLayoutCreateInfo(), None)
stage = vk.VkPipelineShaderStageCreateInfo(stage=vk.VK_SHADER_STAGE_COMPUTE_BIT, module=module, pName="main")
pipeline = vk.vkCreateComputePipelines(
    device, None, 1, [vk.VkComputePipelineCreateInfo(stage=stage, layout=layout)], None)[0]
pool = vk.vkCreateCommandPool(device, vk.VkCommandPoolCreateInfo(queueFamilyIndex=0), None)
commands = vk.vkAllocateCommandBuffers(device, vk.VkCommandBufferAllocateInfo(
    commandPool=pool, level=vk.VK_COMMAND_BUFFER_LEVEL_PRIMARY, commandBufferCount=1))[0]
vk.vkBeginCommandBuffer(commands, vk.VkCommandBufferBeginInfo())
vk.vkCmdBindPipeline(commands, vk.VK_PIPELINE_BIND_POINT_COMPUTE, pipeline)
vk.vkCmdDispatch(commands, 0, 0, 0)
vk.vkEndCommandBuffer(commands)
print(" ".join(sorted(found)) or "nothing")
PY

identifier() { # folder of the layer
    VK_ICD_FILENAMES=$(echo /usr/share/vulkan/icd.d/lvp_icd.*.json) VK_LAYER_PATH=$1 \
        "$scratch/venv/bin/python" "$scratch/dispatch.py" 2>/dev/null | tail -n 1
}
echo "vulkan-validationlayers $(dpkg-query -W -f '${Version}' vulkan-validationlayers), $(basename "$scratch"/chromium-common_*.deb)"
older=$(identifier /usr/share/vulkan/explicit_layer.d)
younger=$(identifier "$scratch/younger")
echo "older: $older"
echo "younger: $younger"
if [ "$older" != UNASSIGNED-BestPractices-vkCmdDispatch-group-count-zero ] ||
    [ "$younger" != BestPractices-vkCmdDispatch-group-count-zero ]; then
    echo 'this changed: the younger identifier was the older one without UNASSIGNED-' >&2
    exit 1
fi
