#version 460
#pragma program(TraceNarrow: Screen, NARROW)
#pragma program(TraceNarrow: Confirmed, NARROW, CONFIRMED)
#pragma program(TraceNarrow: Tree, NARROW, AMONG_TRIANGLES)
#pragma program(TraceNarrow: Query, NARROW, AMONG_TRIANGLES, RAY_QUERY)
#pragma program(TraceWide: Screen)
#pragma program(TraceWide: Confirmed, CONFIRMED)
#pragma program(TraceWide: Tree, AMONG_TRIANGLES)
#pragma program(TraceWide: Query, AMONG_TRIANGLES, RAY_QUERY)
// Traces the rays of glossy pixels and cells, a thread a ray, over tiles or over the whole image.

#ifdef RAY_QUERY
#extension GL_EXT_ray_query : require
#endif

#include "unified/groups.glsl"
#include "unified/trace/gloss_trace.glsl"
#include "unified/ends.glsl"

#ifdef NARROW

layout(binding = 11, rgba32ui) uniform writeonly uimage2D record_image;

void main() {
    ivec2 pixel;
    if (!ThreadTexel(NARROW_LIST, 0, pixel) || !IsInside(pixel, 0))
        return;
    uvec2 ray_end;
    imageStore(record_image, pixel, TraceNarrowPixel(pixel, ray_end));
    StoreRayEnd(pixel, ray_end);
}

#else

layout(binding = 11, rgba32f) uniform writeonly image2D place_image;
layout(binding = 12, rgba16f) uniform writeonly image2D seen_image;

shared vec3 units[GROUP_SIDE * GROUP_SIDE];

// The differences of a unit vector within a block of 2 x 2 cells, by memory that threads share.
void BlockDifferences(vec3 unit, out vec3 across, out vec3 along) {
    uint thread = gl_LocalInvocationIndex;
    units[thread] = unit;
    barrier();
    uint right = 1u, lower = uint(GROUP_SIDE);
    across = units[thread | right] - units[thread & ~right];
    along = units[thread | lower] - units[thread & ~lower];
}

void main() {
    ivec2 cell;
    if (!ThreadTexel(WIDE_LIST, 1, cell))
        return;
    CellRay traced = TraceWideCell(cell);
    if (!IsInside(cell, 1))
        return;
    imageStore(place_image, cell, traced.place);
    imageStore(seen_image, cell, traced.color);
    StoreRayEnd(2 * cell, traced.ray_end);
}

#endif
