#version 460
#pragma program(History)
// The average of reflections over frames, drawn over the whole image.

#include "common/history.glsl"

layout(location = 0) out vec4 out_reflection;
layout(location = 1) out uvec4 out_guide;
layout(location = 2) out vec4 out_color; // where it is wanted

// The pixels of a block are shaded in step.
vec4 OverBlock(ivec2 pixel, vec4 v) {
    vec2 outward = OutwardOf(pixel);
    v += v - outward.x * dFdxFine(v);
    return v + v - outward.y * dFdyFine(v);
}

Block OverBlock(ivec2 pixel, Block own) {
    return Block(OverBlock(pixel, own.ends), OverBlock(pixel, own.movers), OverBlock(pixel, own.sum),
        OverBlock(pixel, own.squares), OverBlock(pixel, vec4(own.count)).x);
}

void main() {
    Averaged averaged = Average(ivec2(gl_FragCoord.xy));
    out_reflection = averaged.reflection;
    out_guide = averaged.guide;
    if (COMPOSITE)
        out_color = averaged.color;
}
