#version 460
// As mirror.frag, with the hits beside the image: for studies, not for speed.

#include "unified/parameters.glsl"
#include "unified/mirror.glsl"

layout(location = 0) out vec4 out_reflection;
layout(location = 1) out vec4 out_color;
layout(location = 2) out vec4 out_hit; // texture coordinates, standard depth, HIT_*

void main() {
    Mirror mirror = TraceMirror(ivec2(gl_FragCoord.xy));
    out_reflection = mirror.reflection;
    out_color = mirror.composite;
    vec3 place = mirror.hit.code == HIT_SURFACE
        ? vec3(mirror.hit.position / vec2(unified.size), 1.0 - mirror.hit.depth) : vec3(-1.0);
    out_hit = vec4(place, float(mirror.hit.code));
}
