#version 460
#pragma program(RayTrace)
// `ssct` and `hzct`, split in two (4.2.3): the ray trace alone.

#include "thesis/parameters.glsl"
#include "thesis/ray_trace.glsl"

layout(location = 0) out vec4 out_hit; // texture coordinates, standard depth, PATH_*

void main() {
    Trace trace = TracePixel(gl_FragCoord.xy);
    out_hit = vec4(trace.hit, trace.path);
}
