#!/usr/bin/env bash
# SwiftShader (the Vulkan driver in Chromium for machines without a GPU): a number far above 65536 that is written as a half float
# becomes "not a number". Vulkan rounds a finite number beyond the greatest half float, 65504, to that or to infinity, and lavapipe and
# pack2x16float of other drivers do so. Expected: 65504 or infinity.
# Seen, with the SwiftShader of @sparticuz/chromium 153.0.0 and wgpu 0.32.0: 65519 becomes 65504 and 65536 infinity, as they should; 70000,
# 1e6 and 1e30 become NaN in a target of R16G16B16A16_SFLOAT, in a storage image, in a cleared target, and by pack2x16float. A bright
# pixel is therefore black or spreads over an image as it is blurred, in headless Chromium and not on a GPU, unless the shader cuts it
# off at 65504 itself.
set -euo pipefail

. "$(dirname "$0")/npm.sh" @sparticuz/chromium@153.0.0
node -e '
const archive = require("fs").readFileSync("node_modules/@sparticuz/chromium/bin/swiftshader.tar.br");
require("fs").writeFileSync("swiftshader.tar", require("zlib").brotliDecompressSync(archive));'
tar -xf swiftshader.tar
python3 -m venv venv
venv/bin/pip install --quiet wgpu==0.32.0 numpy==2.4.6
export VK_DRIVER_FILES=$PWD/vk_swiftshader_icd.json VK_ICD_FILENAMES=$PWD/vk_swiftshader_icd.json XDG_RUNTIME_DIR=$PWD
cat >halves.py <<'PY'
import sys

import numpy as np
import wgpu

NUMBERS = [65519.0, 65536.0, 70000.0, 1e6, 1e30]
COUNT = len(NUMBERS)
LIST = f"array<f32, {COUNT}>({', '.join(str(n) for n in NUMBERS)})"
use, uses = wgpu.TextureUsage, wgpu.BufferUsage
adapters = wgpu.gpu.enumerate_adapters_sync()
device = next(a for a in adapters if "SwiftShader" in a.info["device"]).request_device_sync()


def texture(more):
    return device.create_texture(size=(COUNT, 1, 1), format="rgba16float", usage=use.COPY_SRC | more)


def read(image):
    data = device.queue.read_texture({"texture": image}, {"bytes_per_row": 8 * COUNT}, (COUNT, 1, 1))
    return np.frombuffer(data, np.float16)[::4].tolist()


def target(clear, pipeline=None):
    image = texture(use.RENDER_ATTACHMENT)
    encoder = device.create_command_encoder()
    attachment = {"view": image.create_view(), "load_op": "clear", "store_op": "store", "clear_value": (clear, 0, 0, 0)}
    work = encoder.begin_render_pass(color_attachments=[attachment])
    if pipeline:
        work.set_pipeline(pipeline)
        work.draw(3)
    work.end()
    device.queue.submit([encoder.finish()])
    return read(image)


drawn = device.create_shader_module(code="""
@vertex
fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.5, 1.0);
}
@fragment
fn shade(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    var numbers = LIST;
    return vec4f(numbers[u32(pixel.x)], 0.0, 0.0, 1.0);
}
""".replace("LIST", LIST))
stored = device.create_shader_module(code="""
@group(0) @binding(0) var image: texture_storage_2d<rgba16float, write>;
@group(0) @binding(1) var<storage, read_write> packed: array<u32>;
@compute @workgroup_size(COUNT)
fn store(@builtin(local_invocation_index) i: u32) {
    var numbers = LIST;
    textureStore(image, vec2u(i, 0u), vec4f(numbers[i], 0.0, 0.0, 1.0));
    packed[i] = pack2x16float(vec2f(numbers[i], 0.0));
}
""".replace("LIST", LIST).replace("COUNT", str(COUNT)))
draw = device.create_render_pipeline(
    layout="auto", vertex={"module": drawn, "entry_point": "corner"}, primitive={"topology": "triangle-list"},
    fragment={"module": drawn, "entry_point": "shade", "targets": [{"format": "rgba16float"}]},
)
store = device.create_compute_pipeline(layout="auto", compute={"module": stored, "entry_point": "store"})
image, packed = texture(use.STORAGE_BINDING), device.create_buffer(size=4 * COUNT, usage=uses.STORAGE | uses.COPY_SRC)
group = device.create_bind_group(layout=store.get_bind_group_layout(0), entries=[
    {"binding": 0, "resource": image.create_view()},
    {"binding": 1, "resource": {"buffer": packed, "offset": 0, "size": 4 * COUNT}},
])
encoder = device.create_command_encoder()
work = encoder.begin_compute_pass()
work.set_pipeline(store)
work.set_bind_group(0, group)
work.dispatch_workgroups(1)
work.end()
device.queue.submit([encoder.finish()])
found = {
    "drawn": target(0.0, draw),
    "cleared": [target(number)[0] for number in NUMBERS],
    "stored": read(image),
    "packed": np.frombuffer(device.queue.read_buffer(packed), np.float16)[::2].tolist(),
}
seen = ["65504.0", "inf", "nan", "nan", "nan"]
for name, halves in found.items():
    print(f"{name}: " + ", ".join(f"{n:g} -> {half}" for n, half in zip(NUMBERS, halves)))
if any([str(half) for half in halves] != seen for halves in found.values()):
    sys.exit("this changed: 65504, infinity and three times NaN were seen in each")
PY
venv/bin/python halves.py
