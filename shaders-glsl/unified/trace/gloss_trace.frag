#version 460
#pragma program(TraceNarrow: Screen, NARROW)
#pragma program(TraceNarrow: Confirmed, NARROW, CONFIRMED)
#pragma program(TraceWide: Screen)
#pragma program(TraceWide: Confirmed, CONFIRMED)
// Traces the rays of glossy pixels and cells, drawn over tiles as points or over the whole image.

#include "unified/trace/gloss_trace.glsl"
#include "unified/ends.glsl"

#ifdef NARROW

layout(location = 0) out uvec4 out_record;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec2 ray_end;
    out_record = TraceNarrowPixel(pixel, ray_end);
    StoreRayEnd(pixel, ray_end);
}

#else

layout(location = 0) out vec4 out_place;
layout(location = 1) out vec4 out_color;

// A device shades the texels of a block in step, so that a derivative is the difference between two of them.
void BlockDifferences(vec3 unit, out vec3 across, out vec3 along) {
    across = dFdxFine(unit);
    along = dFdyFine(unit);
}

void main() {
    ivec2 cell = ivec2(gl_FragCoord.xy);
    CellRay traced = TraceWideCell(cell);
    StoreRayEnd(2 * cell, traced.ray_end);
    out_place = traced.place;
    out_color = traced.color;
}

#endif
