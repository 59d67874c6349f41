#version 460
#pragma program(TraceNarrow, NARROW)
#pragma program(TraceNarrowConfirmed, NARROW, CONFIRMED)
#pragma program(TraceWide)
#pragma program(TraceWideConfirmed, CONFIRMED)
// The rays of glossy pixels and cells, drawn over tiles as points or over the whole image.

#include "unified/gloss_trace.glsl"

#ifdef NARROW

layout(location = 0) out uvec4 out_record;

void main() {
    out_record = RecordOf(ivec2(gl_FragCoord.xy));
}

#else

layout(location = 0) out vec4 out_place;
layout(location = 1) out vec4 out_color;

// A device shades the texels of a block in step, so that a derivative is the difference between two of them.
void Turn(vec3 unit, out vec3 across, out vec3 along) {
    across = dFdxFine(unit);
    along = dFdyFine(unit);
}

void main() {
    CellRay traced = RayOf(ivec2(gl_FragCoord.xy));
    out_place = traced.place;
    out_color = traced.color;
}

#endif
