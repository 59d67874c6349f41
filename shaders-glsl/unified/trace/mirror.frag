#version 460
#pragma program(Mirror: Screen)
#pragma program(Mirror: Confirmed, CONFIRMED)
// Shades mirror pixels, drawn over tiles as points or over the whole image.

layout(constant_id = 4) const bool WHOLE = false; // over the whole image, not over tiles

#include "unified/trace/mirror.glsl"

layout(location = 0) out vec4 out_color;      // the composite, or the reflection
layout(location = 1) out vec4 out_reflection; // the reflection, where it is wanted beside the composite
layout(location = 2) out vec4 out_hit;        // the hit, where it is wanted

void main() {
    PixelOutput result;
    if (!ShadePixel(ivec2(gl_FragCoord.xy), result))
        discard;
    out_color = result.color;
    out_reflection = result.reflection;
    if (HITS)
        out_hit = result.hit;
}
