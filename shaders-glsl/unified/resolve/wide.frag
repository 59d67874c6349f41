#version 460
#pragma program(ResolveWide)
// The reflections of pixels with wide lobes, drawn over tiles as points or over the whole image.

layout(constant_id = 4) const bool WHOLE = false; // over the whole image, not over tiles

#include "unified/resolve/wide.glsl"

layout(location = 0) out vec4 out_color;
layout(location = 1) out vec4 out_reflection; // the reflection, where it is wanted beside the composite

void main() {
    PixelOutput result;
    if (!ShadePixel(ivec2(gl_FragCoord.xy), result))
        discard;
    out_color = result.color;
    out_reflection = result.reflection;
}
