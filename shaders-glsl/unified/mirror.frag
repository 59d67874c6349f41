#version 460
#pragma program(Mirror)
#pragma program(MirrorConfirmed, CONFIRMED)
// What a mirror pixel shows, drawn over tiles as points or over the whole image.

layout(constant_id = 4) const bool WHOLE = false; // over the whole image, not over tiles

#include "unified/mirror.glsl"

layout(location = 0) out vec4 out_color;      // the composite, or the reflection
layout(location = 1) out vec4 out_reflection; // where it is wanted beside it
layout(location = 2) out vec4 out_hit;        // where it is wanted

void main() {
    Shown shown;
    if (!Show(ivec2(gl_FragCoord.xy), shown))
        discard;
    out_color = shown.color;
    out_reflection = shown.reflection;
    if (HITS)
        out_hit = shown.hit;
}
