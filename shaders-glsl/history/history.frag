#version 460
#pragma program(History)
// The average of reflections over frames, drawn over the whole image.

// CPU drivers use this stage, and with them a loop costs one turn more than it takes
// (findings/lavapipe-runs-a-loop-once-more.sh).
#define SEARCH_LOOP [[unroll]]

#include "history/history.glsl"

layout(location = 0) out vec4 out_reflection;
layout(location = 1) out uvec4 out_guide;
layout(location = 2) out vec4 out_color; // the composite, where it is wanted

// Sums over a block by derivatives, which works because the pixels of a block are shaded in step. No operations are
// fused, so that history.comp sums to the same bits.
vec4 SumOverBlock(ivec2 pixel, vec4 v) {
    vec2 outward = DirectionOutOfBlock(pixel);
    precise vec4 both = v + (v - outward.x * dFdxFine(v));
    precise vec4 all = both + (both - outward.y * dFdyFine(both));
    return all;
}

BlockSums SumOverBlock(ivec2 pixel, BlockSums own) {
    return BlockSums(SumOverBlock(pixel, own.first), SumOverBlock(pixel, own.second));
}

BlockSums spilled;

void SpillValues(BlockSums values) {
    spilled = values;
}

BlockSums ReloadValues() {
    return spilled;
}

void main() {
    AccumulatedPixel accumulated = AccumulatePixel(ivec2(gl_FragCoord.xy));
    out_reflection = accumulated.reflection;
    out_guide = accumulated.guide;
    if (COMPOSITE)
        out_color = accumulated.color;
}
