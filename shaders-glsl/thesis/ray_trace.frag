#version 460
#pragma program(RayTrace)
#pragma in_either_stage
// `ssct` and `hzct`, split in two (4.2.3): the ray trace alone.

#include "common/either_stage.glsl"
#include "thesis/parameters.glsl"
#include "thesis/ray_trace.glsl"

OUTPUT(0, rgba32f, vec4, out_hit); // texture coordinates, standard depth, PATH_*

SHADE(out_hit) {
    Trace trace = TracePixel(PIXEL_CENTRE);
    out_hit = vec4(trace.hit, trace.path);
}
