#version 460
// As mirror.frag, with the hits beside the image and with normals of any format: for studies, not for speed.

#define ANY_NORMALS
#include "unified/parameters.glsl"
#include "unified/mirror.glsl"

layout(location = 0) out vec4 out_color;
layout(location = 1) out vec4 out_reflection; // where it is wanted
layout(location = 2) out vec4 out_hit; // texture coordinates, standard depth, HIT_* or MISS_*

void main() {
    Mirror mirror = TraceMirror(ivec2(gl_FragCoord.xy));
    out_reflection = mirror.reflection;
    out_color = mirror.composite;
    precise vec2 uv = mirror.hit.position * unified.pixel_to_clip;
    precise float depth = 1.0 - mirror.hit.depth;
    vec3 place = mirror.hit.code == HIT_SURFACE ? vec3(uv, depth) : vec3(-1.0);
    int code = mirror.hit.code == HIT_NOTHING ? WhyMissed(mirror.ray) : mirror.hit.code;
    out_hit = vec4(place, float(code));
}
