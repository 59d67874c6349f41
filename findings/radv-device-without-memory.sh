#!/usr/bin/env bash
# Mesa's RADV lists a discrete GPU without a single type of memory where RADV_FORCE_FAMILY names a GPU that is not there.
#
# Expected: a physical device has at least one type of memory that the host sees and that is coherent, as the Vulkan
# specification promises (chapter "Device Memory"), and a program that picks a discrete GPU first can use it.
# Seen, with Debian 12's Mesa 22.3.6: "Null hardware (RADV NAVI21)" says that it is a discrete GPU of Vulkan 1.3, and has no
# memory types and no heaps. It compiles pipelines, and takes no memory and no work. A program that ranks devices by their
# type must therefore also ask for memory types.
#
# findings/vulkan.sh installs what this needs.
set -euo pipefail

. "$(dirname "$0")/vulkan.sh" radeon
wanted='type 2, memory types 0, heaps 0'
cat >"$scratch/list.py" <<'PY'
import vulkan as vk

application = vk.VkApplicationInfo(apiVersion=vk.VK_MAKE_VERSION(1, 3, 0))
instance = vk.vkCreateInstance(vk.VkInstanceCreateInfo(pApplicationInfo=application), None)
for device in vk.vkEnumeratePhysicalDevices(instance):
    of_device = vk.vkGetPhysicalDeviceProperties(device)
    memory = vk.vkGetPhysicalDeviceMemoryProperties(device)
    print(f"{of_device.deviceName}: type {of_device.deviceType}, memory types {memory.memoryTypeCount}, "
          f"heaps {memory.memoryHeapCount}")
PY
seen=$(RADV_FORCE_FAMILY=NAVI21 python "$scratch/list.py")
echo "$seen"
case "$seen" in
*"$wanted"*) ;;
*)
    echo "this changed: it was \"$wanted\"" >&2
    exit 1
    ;;
esac
