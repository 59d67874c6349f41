#version 460
#pragma program(Ssct)
// `ssct` and `hzct`: ray trace and cone trace in one shader, as the thesis combined them (4.2.3).

#include "thesis/parameters.glsl"
#include "thesis/ray_trace.glsl"
#include "thesis/cone_trace.glsl"

layout(constant_id = 1) const bool HITS = false; // whether out_hit is wanted

layout(location = 0) out vec4 out_reflection; // colour, and fade in a
layout(location = 1) out vec4 out_hit;        // texture coordinates, standard depth, PATH_*

void main() {
    Trace trace = TracePixel(gl_FragCoord.xy);
    out_reflection = Reflection(gl_FragCoord.xy / thesis.resolution, trace.hit, trace.reflection, trace.roughness);
    if (HITS)
        out_hit = vec4(trace.hit, trace.path);
}
