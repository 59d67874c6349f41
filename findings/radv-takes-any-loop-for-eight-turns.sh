#!/usr/bin/env bash
# Mesa's RADV (AMD): the cycles that its compiler states of a shader ("Inverse Throughput" and "Latency") do not depend on how often a loop
# runs, not even where the number is a constant.
#
# Expected: a loop of 1000 turns is stated to take far longer than one of two turns, and two turns as long as the same lines twice.
# Seen, with Debian 12's Mesa 22.3.6 and the GPU NAVI21: a loop of 1, 2 and 1000 turns is stated to take 512 cycles each, as if it had
# eight turns. The same two turns unrolled take 128. So whoever compares two shaders by these numbers sees a gain of four
# times in unrolling alone, and no gain at all in fewer turns.
set -euo pipefail
. "$(dirname "$0")/radv.sh"

write() { # file, attribute of the loop, its turns
    cat >"$scratch/$1" <<GLSL
#version 460
#extension GL_EXT_control_flow_attributes : require
layout(local_size_x = 64) in;
layout(constant_id = 0) const int TURNS = 1;
layout(binding = 0, rgba32f) uniform readonly image2D seen;
layout(binding = 1, rgba32f) uniform writeonly image2D shown;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    vec4 sum = imageLoad(seen, pixel);
    [[$2]] for (int i = 0; i < TURNS; ++i)
        sum = sqrt(sum * sum.yzwx + 0.1) + sin(sum);
    imageStore(shown, pixel, sum);
}
GLSL
}

write loop.comp dont_unroll
write unrolled.comp unroll
cycles() {
    statistics "$scratch/$1" "$2" | number 'Inverse Throughput'
}
seen="loop of 1, 2, 1000 turns: $(cycles loop.comp 1), $(cycles loop.comp 2), $(cycles loop.comp 1000); two turns unrolled: $(cycles unrolled.comp 2)"
echo "$seen"
wanted='loop of 1, 2, 1000 turns: 512, 512, 512; two turns unrolled: 128'
if [ "$seen" != "$wanted" ]; then
    printf 'this changed: it was\n%s\n' "$wanted" >&2
    exit 1
fi
