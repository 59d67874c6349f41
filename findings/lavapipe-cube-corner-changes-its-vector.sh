#!/usr/bin/env bash
# Lavapipe (Mesa): what a thread reads of a cube map depends on where the other threads of its vector look. One would expect a sample
# with an explicit level to depend on its own direction and level alone. If one thread looks at a corner of the cube, where three faces
# meet, all threads of its vector filter by another formula, which rounds otherwise. So a shader that takes its work from a list that
# atomics fill makes other last bits in each run, even where each thread does the same work.
# Seen, with Debian 12's Mesa 22.3.6: of 4096 samples well within a face, 1660 change, by at most 1.2e-07, when another thread looks at a
# corner; none does when that thread looks across an edge, at another face, or at another level.
#
# findings/lavapipe.sh installs what this needs.
set -euo pipefail

. "$(dirname "$0")/lavapipe.sh"
cat >"$scratch/cube.py" <<'PY'
import sys

import numpy as np
import wgpu

SIDE, LEVELS, VECTORS, LANES = 16, 5, 4096, 8
SHADER = """
@group(0) @binding(0) var faces: texture_cube<f32>;
@group(0) @binding(1) var linear: sampler;
@group(0) @binding(2) var<storage, read> directions: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> seen: array<f32>;
@compute @workgroup_size(8)
fn main(@builtin(global_invocation_id) thread: vec3u) {
    let looked = directions[thread.x];
    seen[thread.x] = textureSampleLevel(faces, linear, looked.xyz, looked.w).x;
}
"""
adapters = wgpu.gpu.enumerate_adapters_sync()
lavapipe = next(a for a in adapters if a.info["backend_type"] == "Vulkan" and "llvmpipe" in a.info["device"])
device = lavapipe.request_device_sync()
random = np.random.default_rng(1)
use = wgpu.TextureUsage
texture = device.create_texture(
    size=(SIDE, SIDE, 6),
    mip_level_count=LEVELS,
    format="rgba16float",
    usage=use.TEXTURE_BINDING | use.COPY_DST,
)
for level in range(LEVELS):
    side = SIDE >> level
    texels = random.random((6, side, side, 4)).astype(np.float16)
    target = {"texture": texture, "mip_level": level}
    device.queue.write_texture(target, texels.tobytes(), {"bytes_per_row": 8 * side, "rows_per_image": side}, (side, side, 6))
cube = texture.create_view(dimension="cube")
linear = device.create_sampler(mag_filter="linear", min_filter="linear", mipmap_filter="linear")
module = device.create_shader_module(code=SHADER)
pipeline = device.create_compute_pipeline(layout="auto", compute={"module": module, "entry_point": "main"})

# Directions well within the face +x, and level 0.
directions = np.ones((VECTORS, LANES, 4), np.float32)
directions[:, :, 1:3] = random.uniform(-0.8, 0.8, (VECTORS, LANES, 2))
directions[:, :, 3] = 0


def seen_beside(last):
    """What the first thread of each vector sees while the last one looks in the direction and level `last`."""
    directions[:, -1] = last
    given = device.create_buffer_with_data(data=directions, usage=wgpu.BufferUsage.STORAGE)
    seen = device.create_buffer(size=4 * VECTORS * LANES, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC)
    resources = [cube, linear, {"buffer": given}, {"buffer": seen}]
    entries = [{"binding": n, "resource": resource} for n, resource in enumerate(resources)]
    group = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
    commands = device.create_command_encoder()
    work = commands.begin_compute_pass()
    work.set_pipeline(pipeline)
    work.set_bind_group(0, group)
    work.dispatch_workgroups(VECTORS)
    work.end()
    device.queue.submit([commands.finish()])
    return np.frombuffer(device.queue.read_buffer(seen), np.float32).reshape(VECTORS, LANES)[:, 0]


within = seen_beside((1, 0.1, 0.2, 0))
beside = {"edge": (1, 0.999, 0.2, 0), "face": (0.1, 1, 0.2, 0), "level": (1, 0.1, 0.2, 1), "corner": (1, 0.999, 0.999, 0)}
changes = {name: np.abs(seen_beside(last) - within) for name, last in beside.items()}
for name, change in changes.items():
    print(f"beside another {name}: {int((change > 0).sum())} of {VECTORS} samples change, by at most {change.max():.1e}")
corner = changes.pop("corner")
is_as_seen = 0 < corner.max() < 1e-6 and not any(change.any() for change in changes.values())
sys.exit(0 if is_as_seen else "this has changed: only the corner is expected to change samples")
PY
python "$scratch/cube.py"
