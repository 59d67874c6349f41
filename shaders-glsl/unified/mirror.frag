#version 460
// Mirrors: trace and composite in one pass, over the tiles of a list.

#include "unified/parameters.glsl"
#include "unified/mirror.glsl"

layout(location = 0) out vec4 out_reflection;
layout(location = 1) out vec4 out_color;

void main() {
    Mirror mirror = TraceMirror(ivec2(gl_FragCoord.xy));
    out_reflection = mirror.reflection;
    out_color = mirror.composite;
}
