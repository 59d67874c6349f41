#!/usr/bin/env bash
# Lavapipe (Mesa): what a shader writes to a target of half floats (R16G16B16A16_SFLOAT) is cut off toward zero, and not rounded to the
# nearest half float. Expected: the nearest, as pack2x16float of the same driver gives it, and infinity above 65520.
# Seen, with Debian 12's Mesa 22.3.6: all 256 numbers lie at or below what was written, by half of the last place on average, and 1e6
# becomes 65504. Numbers that the shader itself rounds by pack2x16float first come out without a lean. Vulkan leaves the rounding open,
# so that averages over many frames in half floats lean to dark here and not on a driver that rounds.
#
# findings/lavapipe.sh installs what this needs.
set -euo pipefail

. "$(dirname "$0")/lavapipe.sh"
cat >"$scratch/half.py" <<'PY'
import sys

import numpy as np
import wgpu

SIDE = 256
SHADER = """
@vertex
fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.5, 1.0);
}
@fragment
fn shade(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let number = 1.0 + floor(pixel.x) * 0.0037;
    return vec4f(number, unpack2x16float(pack2x16float(vec2f(number))).x, 1e6, 1.0);
}
"""
adapters = wgpu.gpu.enumerate_adapters_sync()
lavapipe = next(a for a in adapters if a.info["backend_type"] == "Vulkan" and "llvmpipe" in a.info["device"])
device = lavapipe.request_device_sync()
module = device.create_shader_module(code=SHADER)
pipeline = device.create_render_pipeline(
    layout="auto", vertex={"module": module, "entry_point": "corner"}, primitive={"topology": "triangle-list"},
    fragment={"module": module, "entry_point": "shade", "targets": [{"format": "rgba16float"}]},
)
use = wgpu.TextureUsage
target = device.create_texture(size=(SIDE, 1, 1), format="rgba16float", usage=use.RENDER_ATTACHMENT | use.COPY_SRC)
encoder = device.create_command_encoder()
attachment = {"view": target.create_view(), "load_op": "clear", "store_op": "store", "clear_value": (0, 0, 0, 0)}
work = encoder.begin_render_pass(color_attachments=[attachment])
work.set_pipeline(pipeline)
work.draw(3)
work.end()
device.queue.submit([encoder.finish()])
data = device.queue.read_texture({"texture": target}, {"bytes_per_row": 8 * SIDE}, (SIDE, 1, 1))
found = np.frombuffer(data, np.float16).reshape(SIDE, 4).astype(np.float64)
numbers = 1.0 + np.arange(SIDE) * 0.0037
leans = {}
for name, column in (("written", 0), ("rounded first", 1)):
    error = (found[:, column] - numbers) * 1024.0  # in units of the last place, which is 1/1024 from 1 to 2
    leans[name] = error.mean()
    print(f"{name}: {(error > 1e-3).sum()} of {SIDE} above, mean error {error.mean():+.2f} of the last place")
print(f"1e6 becomes {found[0, 2]:.0f}")
above = (found[:, 0] - numbers > 1e-6).sum()
if above or leans["written"] > -0.4 or abs(leans["rounded first"]) > 0.1 or found[0, 2] != 65504:
    sys.exit("this changed: none lay above, by half of the last place on average, and 1e6 became 65504")
PY
python "$scratch/half.py"
