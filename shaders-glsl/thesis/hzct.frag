#version 460
// `hzct`: ray trace and cone trace in one shader, as the thesis combined them (4.2.3).

#include "thesis/parameters.glsl"
#include "thesis/ray_trace.glsl"
#include "thesis/cone_trace.glsl"

layout(location = 0) out vec4 out_reflection; // colour, and fade in a

void main() {
    Trace trace = TracePixel(gl_FragCoord.xy);
    out_reflection = Reflection(gl_FragCoord.xy / thesis.resolution, trace.hit, trace.reflection, trace.roughness);
}
