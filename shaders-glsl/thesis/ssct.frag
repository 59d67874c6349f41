#version 460
#pragma program(Ssct)
#pragma in_either_stage
// `ssct` and `hzct`: ray trace and cone trace in one shader, as the thesis combined them (4.2.3).

#include "common/either_stage.glsl"
#include "thesis/parameters.glsl"
#include "thesis/ray_trace.glsl"
#include "thesis/cone_trace.glsl"

layout(constant_id = 1) const bool HITS = false; // whether out_hit is wanted

OUTPUT(0, rgba16f, vec4, out_reflection); // colour, and fade in alpha
OUTPUT(1, rgba32f, vec4, out_hit);        // texture coordinates, standard depth, PATH_*

SHADE_ALL(out_reflection, STORE_IF(HITS, out_hit)) {
    Trace trace = TracePixel(PIXEL_CENTRE);
    out_reflection = Reflection(PIXEL_CENTRE / thesis.resolution, trace.hit, trace.reflection, trace.roughness);
    if (HITS)
        out_hit = vec4(trace.hit, trace.path);
}
