#!/usr/bin/env bash
# SwiftShader and lavapipe, the Vulkan drivers on CPUs: how finely they filter images of half floats. Expected: weights in steps of
# 1/256 between two texels, and of 1/16 (lavapipe) or 1/64 (SwiftShader) between two levels, as their limits subTexelPrecisionBits and
# mipmapPrecisionBits say; and one level for the four pixels of a block.
# Seen, with the SwiftShader of @sparticuz/chromium 153.0.0 and Debian 12's lavapipe of Mesa 22.3.6: each of 4096 places between two
# texels, and each of 2048 between two levels, has a weight of its own, without an error; and a pixel that asks for a level of its own
# (textureSampleLevel) gets it. Small differences between the images of these drivers therefore do not come from the filter's steps,
# and code that was tuned on them meets coarser steps on a GPU that keeps to its limits.
#
# Debian's libvulkan1 and mesa-vulkan-drivers are installed where they are missing (as root).
set -euo pipefail

icd=/usr/share/vulkan/icd.d/lvp_icd.$(uname -m).json
[ -s "$icd" ] || { apt-get update -q && apt-get install -y -q --no-install-recommends libvulkan1 mesa-vulkan-drivers; } >/dev/null
. "$(dirname "$0")/npm.sh" @sparticuz/chromium@153.0.0
node -e '
const archive = require("fs").readFileSync("node_modules/@sparticuz/chromium/bin/swiftshader.tar.br");
require("fs").writeFileSync("swiftshader.tar", require("zlib").brotliDecompressSync(archive));'
tar -xf swiftshader.tar
python3 -m venv venv
venv/bin/pip install --quiet wgpu==0.32.0 numpy==2.4.6 vulkan==1.3.275.1 cffi==2.1.1
export XDG_RUNTIME_DIR=$PWD
cat >limits.py <<'PY'
import vulkan as vk

application = vk.VkApplicationInfo(apiVersion=vk.VK_MAKE_VERSION(1, 1, 0))
instance = vk.vkCreateInstance(vk.VkInstanceCreateInfo(pApplicationInfo=application), None)
properties = vk.vkGetPhysicalDeviceProperties(vk.vkEnumeratePhysicalDevices(instance)[0])
limits = properties.limits
print(f"{properties.deviceName}: {limits.subTexelPrecisionBits} bits between texels, {limits.mipmapPrecisionBits} between levels")
PY
cat >filters.py <<'PY'
import sys

import numpy as np
import wgpu

use, uses = wgpu.TextureUsage, wgpu.BufferUsage
adapter = next(a for a in wgpu.gpu.enumerate_adapters_sync() if a.info["backend_type"] == "Vulkan")
device = adapter.request_device_sync()
sampler = device.create_sampler(min_filter="linear", mag_filter="linear", mipmap_filter="linear")


def image(levels):
    """A square image whose level n has the texels levels[n], in its first channel."""
    side = levels[0].shape[0]
    made = device.create_texture(size=(side, side, 1), format="rgba16float", mip_level_count=len(levels),
                                 usage=use.TEXTURE_BINDING | use.COPY_DST)
    for level, values in enumerate(levels):
        texels = np.zeros((*values.shape, 4), np.float16)
        texels[..., 0] = values
        to = {"texture": made, "mip_level": level}
        device.queue.write_texture(to, texels, {"bytes_per_row": 8 * len(values)}, (len(values), len(values), 1))
    return made.create_view()


def sampled(view, count, place, level):
    """What `count` threads sample at places and levels that are expressions of the thread's number i."""
    module = device.create_shader_module(code=f"""
        @group(0) @binding(0) var<storage, read_write> found: array<f32>;
        @group(0) @binding(1) var image: texture_2d<f32>;
        @group(0) @binding(2) var filtered: sampler;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {{
            let i = id.x;
            found[i] = textureSampleLevel(image, filtered, {place}, {level}).x;
        }}""")
    pipeline = device.create_compute_pipeline(layout="auto", compute={"module": module, "entry_point": "main"})
    found = device.create_buffer(size=4 * count, usage=uses.STORAGE | uses.COPY_SRC)
    resources = [{"buffer": found, "offset": 0, "size": 4 * count}, view, sampler]
    group = device.create_bind_group(layout=pipeline.get_bind_group_layout(0),
                                     entries=[{"binding": n, "resource": r} for n, r in enumerate(resources)])
    encoder = device.create_command_encoder()
    work = encoder.begin_compute_pass()
    work.set_pipeline(pipeline)
    work.set_bind_group(0, group)
    work.dispatch_workgroups(count // 64)
    work.end()
    device.queue.submit([encoder.finish()])
    return np.frombuffer(device.queue.read_buffer(found), np.float32)


def drawn(view):
    """What each of 16 x 16 pixels samples at a level of its own, less that level."""
    module = device.create_shader_module(code="""
        @group(0) @binding(0) var image: texture_2d<f32>;
        @group(0) @binding(1) var filtered: sampler;
        @vertex
        fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
            return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.5, 1.0);
        }
        @fragment
        fn shade(@builtin(position) p: vec4f) -> @location(0) vec4f {
            let level = f32((u32(p.x) * 7u + u32(p.y) * 13u) % 13u) * 0.25;
            return vec4f(textureSampleLevel(image, filtered, p.xy / 16.0, level).x - level);
        }""")
    pipeline = device.create_render_pipeline(
        layout="auto", vertex={"module": module, "entry_point": "corner"}, primitive={"topology": "triangle-list"},
        fragment={"module": module, "entry_point": "shade", "targets": [{"format": "rgba32float"}]})
    group = device.create_bind_group(layout=pipeline.get_bind_group_layout(0),
                                     entries=[{"binding": 0, "resource": view}, {"binding": 1, "resource": sampler}])
    target = device.create_texture(size=(16, 16, 1), format="rgba32float", usage=use.RENDER_ATTACHMENT | use.COPY_SRC)
    encoder = device.create_command_encoder()
    attachment = {"view": target.create_view(), "load_op": "clear", "store_op": "store", "clear_value": (0, 0, 0, 0)}
    work = encoder.begin_render_pass(color_attachments=[attachment])
    work.set_pipeline(pipeline)
    work.set_bind_group(0, group)
    work.draw(3)
    work.end()
    device.queue.submit([encoder.finish()])
    data = device.queue.read_texture({"texture": target}, {"bytes_per_row": 256}, (16, 16, 1))
    return np.frombuffer(data, np.float32)


step = image([np.array([[0.0, 1.0], [0.0, 1.0]])])
pyramid = image([np.full((16 >> level, 16 >> level), level) for level in range(5)])
between_texels = sampled(step, 4096, "vec2f(0.25 + 0.5 * f32(i) / 4096.0, 0.5)", "0.0")
between_levels = sampled(pyramid, 2048, "vec2f(0.5)", "f32(i) / 2048.0")
errors = [np.abs(between_texels - np.arange(4096) / 4096).max(), np.abs(between_levels - np.arange(2048) / 2048).max()]
counts = [len(np.unique(between_texels)), len(np.unique(between_levels))]
apart = np.abs(drawn(pyramid)).max()
print(f"  {counts[0]} weights between texels, {counts[1]} between levels, errors {errors}; own levels are off by {apart}")
if counts != [4096, 2048] or max(errors) > 1e-6 or apart > 1e-6:
    sys.exit("this changed: each place had a weight of its own, and each pixel its level")
PY
for driver in "$PWD/vk_swiftshader_icd.json" "$icd"; do
    export VK_DRIVER_FILES=$driver VK_ICD_FILENAMES=$driver
    venv/bin/python limits.py
    venv/bin/python filters.py
done
