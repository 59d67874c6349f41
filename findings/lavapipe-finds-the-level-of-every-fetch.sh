#!/usr/bin/env bash
# Lavapipe (Mesa): a load from a sampled image of one level, with the constant level 0, takes two to three times as long as a load from a storage
# image of the same format and content. One would expect one price, since neither filters. The driver makes a function of each kind of
# fetch, calls it, and finds there for each of eight threads the level, its size, its row length and its place, constant or not; a
# storage image has no levels, and its load stands in place.
# Seen, with Debian 12's Mesa 22.3.6: 2.9 times as long, with the same values.
#
# Only ratios of the least of many times count, with wide bounds. findings/lavapipe.sh installs what this needs.
set -euo pipefail

. "$(dirname "$0")/lavapipe.sh"
cat >"$scratch/load.py" <<'PY'
import sys
import time

import numpy as np
import wgpu

THREADS = 1 << 18
SIDE = 64
# Places that no compiler knows, the same in both programs.
BODY = "\n".join(["p = vec2i((p.x * 5 + p.y + 1) & 63, (p.y * 3 + p.x + 7) & 63); sum += LOAD;"] * 48)
SHADER = f"""
@group(0) @binding(0) var<storage, read_write> seen: array<f32>;
@group(0) @binding(1) var map: KIND;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u) {{
    var p = vec2i(i32(thread.x) & 63, i32(thread.x >> 6u) & 63);
    var sum = 0.0;
{BODY}
    seen[thread.x] = sum;
}}
"""
KINDS = {
    "sampled": ("texture_2d<f32>", "textureLoad(map, p, 0).r", wgpu.TextureUsage.TEXTURE_BINDING),
    "storage": ("texture_storage_2d<r32float, read>", "textureLoad(map, p).r", wgpu.TextureUsage.STORAGE_BINDING),
}

adapters = wgpu.gpu.enumerate_adapters_sync()
lavapipe = next(a for a in adapters if a.info["backend_type"] == "Vulkan" and "llvmpipe" in a.info["device"])
device = lavapipe.request_device_sync()
texels = np.random.default_rng(1).random((SIDE, SIDE), dtype=np.float32)
use = wgpu.BufferUsage


def measured(kind):
    """The least time of a dispatch in seconds, and the sums that the threads found."""
    type_, load, texture_use = KINDS[kind]
    code = SHADER.replace("KIND", type_).replace("LOAD", load)
    pipeline = device.create_compute_pipeline(
        layout="auto", compute={"module": device.create_shader_module(code=code), "entry_point": "main"}
    )
    texture = device.create_texture(size=(SIDE, SIDE, 1), format="r32float", usage=texture_use | wgpu.TextureUsage.COPY_DST)
    device.queue.write_texture({"texture": texture}, texels, {"bytes_per_row": 4 * SIDE}, (SIDE, SIDE, 1))
    seen = device.create_buffer(size=4 * THREADS, usage=use.STORAGE | use.COPY_SRC)
    entries = [{"binding": 0, "resource": {"buffer": seen}}, {"binding": 1, "resource": texture.create_view()}]
    group = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
    times = []
    for _ in range(15):
        begin = time.perf_counter()
        commands = device.create_command_encoder()
        work = commands.begin_compute_pass()
        work.set_pipeline(pipeline)
        work.set_bind_group(0, group)
        work.dispatch_workgroups(THREADS // 64)
        work.end()
        device.queue.submit([commands.finish()])
        device.queue.read_buffer(seen, 0, 4)
        times.append(time.perf_counter() - begin)
    return min(times), np.frombuffer(device.queue.read_buffer(seen), np.float32)


(sampled, first), (storage, second) = measured("sampled"), measured("storage")
print(f"loads of a sampled image take {sampled / storage:.2f} of the time of a storage image's; same values: {(first == second).all()}")
sys.exit(0 if sampled / storage > 1.4 and (first == second).all() else "this has changed: they took more than twice the time")
PY
python "$scratch/load.py"
