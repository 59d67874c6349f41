#version 460
#pragma program(History)
// The average of reflections over frames, drawn over the whole image.

// The stage of CPU drivers, where a loop costs a turn more than it takes (findings/lavapipe-runs-a-loop-once-more.sh).
#define SEARCH_LOOP [[unroll]]

#include "common/history.glsl"

layout(location = 0) out vec4 out_reflection;
layout(location = 1) out uvec4 out_guide;
layout(location = 2) out vec4 out_color; // where it is wanted

// The pixels of a block are shaded in step. Nothing is fused, so that history.comp sums to the same bits.
vec4 OverBlock(ivec2 pixel, vec4 v) {
    vec2 outward = OutwardOf(pixel);
    precise vec4 both = v + (v - outward.x * dFdxFine(v));
    precise vec4 all = both + (both - outward.y * dFdyFine(both));
    return all;
}

Sums OverBlock(ivec2 pixel, Sums own) {
    return Sums(OverBlock(pixel, own.first), OverBlock(pixel, own.second));
}

Sums set_aside;

void SetAside(Sums values) {
    set_aside = values;
}

Sums TakenBack() {
    return set_aside;
}

void main() {
    Averaged averaged = Average(ivec2(gl_FragCoord.xy));
    out_reflection = averaged.reflection;
    out_guide = averaged.guide;
    if (COMPOSITE)
        out_color = averaged.color;
}
