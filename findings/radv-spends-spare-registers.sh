#!/usr/bin/env bash
# Mesa's RADV (AMD): the registers that its compiler states are not those that a program needs. One shader gets twice as many where
# it declares more shared memory, although its code is the same.
#
# Expected: the count of vector registers ("VGPRs" of VK_KHR_pipeline_executable_properties) says how much a shader holds at a time,
# and a shader with fewer registers runs in more subgroups.
# Seen, with Debian 12's Mesa 22.3.6 and the GPU NAVI21: a shader that needs 10 registers ("Pre-Sched VGPRs") gets 32 with 2 KiB of
# shared memory for a workgroup of 64 threads, so that a SIMD unit holds 32 subgroups. With 4 KiB, shared memory lets it hold 16, and
# the compiler gives each of these 64 registers, in order to load earlier. So a lower count is no gain where shared memory is what
# limits the subgroups, and the need stands in "Pre-Sched VGPRs".
set -euo pipefail
. "$(dirname "$0")/radv.sh"

wanted='2 KiB: 32 registers of 10 needed, 32 subgroups
4 KiB: 64 registers of 10 needed, 16 subgroups'
cat >"$scratch/loads.comp" <<'GLSL'
#version 460
layout(local_size_x = 64) in;
layout(constant_id = 0) const int PLACES = 1; // of 8 bytes, for each thread
layout(binding = 0, rgba32f) uniform readonly image2D seen;
layout(binding = 1, rgba32f) uniform writeonly image2D shown;
shared vec2 held[PLACES * 64];

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    int own = int(gl_LocalInvocationIndex);
    held[own] = vec2(pixel);
    barrier();
    vec4 sum = vec4(held[7 * own % (PLACES * 64)], 0.0, 1.0);
    for (int i = 0; i < 12; ++i) {
        vec4 texel = imageLoad(seen, pixel + ivec2(i, 3 * i));
        sum = sqrt(sum * texel + 0.1) + sin(texel);
    }
    imageStore(shown, pixel, sum);
}
GLSL
seen=
for places in 4 8; do
    said=$(statistics "$scratch/loads.comp" $places)
    line="$((places * 512 / 1024)) KiB: $(number VGPRs <<<"$said") registers of $(number 'Pre-Sched VGPRs' <<<"$said") needed"
    seen+="$line, $(number 'Subgroups per SIMD' <<<"$said") subgroups"$'\n'
done
printf '%s' "$seen"
if [ "${seen%$'\n'}" != "$wanted" ]; then
    printf 'this changed: it was\n%s\n' "$wanted" >&2
    exit 1
fi
