#!/usr/bin/env bash
# Lavapipe (Mesa): a loop costs one run of its body more than it has turns. One would expect a loop whose condition is false at once to
# be jumped over, and therefore a loop that runs once or not to be the way to leave out work that no thread of a group wants. The driver
# asks whether some thread goes on where a turn ends, and nowhere else: the first turn, and the last in which all threads have left the
# loop, run with no thread in them.
# Seen, with Debian 12's Mesa 22.3.6: if a loop of one turn takes 2 units of time, one of no turn takes 1, and one of three takes 4.
#
# Only ratios of the least of many times count, with wide bounds. findings/lavapipe.sh installs what this needs.
set -euo pipefail

. "$(dirname "$0")/lavapipe.sh"
cat >"$scratch/loop.py" <<'PY'
import sys
import time

import numpy as np
import wgpu

THREADS = 1 << 18
# A body that is long beside all that is around it: each step needs the one before it.
BODY = "\n".join(["x = fract(x * 1.37 + y) + 0.5 * x * x; y = fract(y * 2.11 + x) - 0.25 * y;"] * 120)
SHADER = f"""
@group(0) @binding(0) var<storage, read_write> seen: array<f32>;
@group(0) @binding(1) var<storage, read> turns: u32;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) thread: vec3u) {{
    var x = f32(thread.x) / 1000.0;
    var y = x * 0.5;
    for (var i = 0u; i < turns; i++) {{
{BODY}
    }}
    seen[thread.x] = x + y;
}}
"""

adapters = wgpu.gpu.enumerate_adapters_sync()
lavapipe = next(a for a in adapters if a.info["backend_type"] == "Vulkan" and "llvmpipe" in a.info["device"])
device = lavapipe.request_device_sync()
module = device.create_shader_module(code=SHADER)
pipeline = device.create_compute_pipeline(layout="auto", compute={"module": module, "entry_point": "main"})
use = wgpu.BufferUsage
seen = device.create_buffer(size=4 * THREADS, usage=use.STORAGE | use.COPY_SRC)


def least_time(turns):
    block = device.create_buffer_with_data(data=np.array([turns], np.uint32), usage=use.STORAGE)
    bound = [{"buffer": seen}, {"buffer": block}]
    entries = [{"binding": n, "resource": resource} for n, resource in enumerate(bound)]
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
    return min(times)


none, one, three = (least_time(turns) for turns in (0, 1, 3))
print(f"time of a loop over that of one turn: no turn {none / one:.2f}, three turns {three / one:.2f}")
sys.exit(0 if 0.2 < none / one < 0.8 and 1.4 < three / one < 2.6 else "this has changed: 0.5 and 2 are expected")
PY
python "$scratch/loop.py"
