#version 460
// Mirrors where all that reflects is one: trace and composite of the whole image in one pass.

#define WHOLE
#include "unified/parameters.glsl"
#include "unified/mirror.glsl"

layout(location = 0) out vec4 out_reflection;
layout(location = 1) out vec4 out_color;

void main() {
    Mirror mirror = TraceMirror(ivec2(gl_FragCoord.xy));
    out_reflection = mirror.reflection;
    out_color = mirror.composite;
}
