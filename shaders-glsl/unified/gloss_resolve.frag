#version 460
#pragma program(ResolveNarrow, NARROW)
#pragma program(Cells, CELLS)
#pragma program(ResolveWide)
// Makes reflections from the rays of gloss_trace.glsl: of each pixel with a narrow lobe (NARROW), of each cell with a
// wide lobe (CELLS), and of each pixel with a wide lobe, between such cells. The programs are drawn over tiles as
// points or over the whole image. Pixels of a block of 2 x 2 hand each other the rays that they loaded.

layout(constant_id = 4) const bool WHOLE = false; // over the whole image, not over tiles

#if defined(NARROW)
#include "unified/resolve_narrow.glsl"
#elif defined(CELLS)
#include "unified/resolve_cells.glsl"
#else
#include "unified/resolve_wide.glsl"
#endif

#if defined(NARROW) || defined(CELLS)

// The ray of the block's other pixel along an axis. `outward` is the asking pixel's direction out of the block along
// this axis.
NeighbourRay RayFromNeighbourX(NeighbourRay r, int outward) {
    return NeighbourRay(r.key - float(outward) * dFdxFine(r.key), r.color - float(outward) * dFdxFine(r.color));
}

NeighbourRay RayFromNeighbourY(NeighbourRay r, int outward) {
    return NeighbourRay(r.key - float(outward) * dFdyFine(r.key), r.color - float(outward) * dFdyFine(r.color));
}

#endif

#ifdef CELLS

layout(location = 0) out vec4 out_reflection;
layout(location = 1) out vec4 out_surface;

NeighbourRay LoadCellRay(ivec2 cell) {
    ivec2 clamped_cell = ClampCell(cell);
    return LoadCellRay(clamped_cell, IsDrawn(clamped_cell));
}

// Gathers a ray, and the ray that the other cell of the block along y has in its place, each with its closeness.
void GatherWithNeighbour(inout CellSum sum, GatherPoint centre, NeighbourRay ray, int outward, vec2 closeness) {
    GatherRay(sum, centre, ray, closeness.x);
    GatherRay(sum, centre, RayFromNeighbourY(ray, outward), closeness.y);
}

// The rays of a row, the first of which is two cells inwards, and those that the other cell of the block along y has in their places.
// `closeness` is that of the middle of both rows.
void GatherTwoRows(inout CellSum sum, GatherPoint centre, ivec2 cell, ivec2 outward, vec2 closeness) {
    // The other cell of the block along x hands on the rays between those that are loaded.
    NeighbourRay inner = LoadCellRay(cell - ivec2(2 * outward.x, 0));
    NeighbourRay middle = LoadCellRay(cell);
    GatherWithNeighbour(sum, centre, inner, outward.y, vec2(0.0));
    GatherWithNeighbour(sum, centre, RayFromNeighbourX(middle, outward.x), outward.y, 0.5 * closeness);
    GatherWithNeighbour(sum, centre, middle, outward.y, closeness);
    GatherWithNeighbour(sum, centre, RayFromNeighbourX(inner, outward.x), outward.y, 0.5 * closeness);
    GatherWithNeighbour(sum, centre, LoadCellRay(cell + ivec2(2 * outward.x, 0)), outward.y, vec2(0.0));
}

// The rows are gathered one by one without a loop, which SwiftShader of Chromium 156 would compile for minutes in
// gigabytes.
void GatherNeighbours(inout CellSum sum, GatherPoint centre, ivec2 cell, ivec2 outward) {
    ivec2 y = ivec2(0, 2 * outward.y);
    GatherTwoRows(sum, centre, cell - y, outward, vec2(0.0, 0.5));
    GatherTwoRows(sum, centre, cell, outward, vec2(1.0, 0.5));
    NeighbourRay inner = LoadCellRay(cell + y - ivec2(2 * outward.x, 0));
    NeighbourRay middle = LoadCellRay(cell + y);
    GatherRay(sum, centre, inner, 0.0);
    GatherRay(sum, centre, RayFromNeighbourX(middle, outward.x), 0.0);
    GatherRay(sum, centre, middle, 0.0);
    GatherRay(sum, centre, RayFromNeighbourX(inner, outward.x), 0.0);
    GatherRay(sum, centre, LoadCellRay(cell + 2 * outward), 0.0);
}

void main() {
    ivec2 cell = ivec2(gl_FragCoord.xy);
    // A reach of two cells can touch only the tiles on this side.
    LoadNeighbourTiles(cell, 1 - 2 * ivec2(lessThan(cell & (CELLS_TO_A_TILE - 1), ivec2(2))));
    ResolvedCell resolved = ResolveCell(cell);
    out_reflection = resolved.reflection;
    out_surface = resolved.surface;
}

#else

layout(location = 0) out vec4 out_color;
layout(location = 1) out vec4 out_reflection; // the reflection, where it is wanted beside the composite

#ifdef NARROW

NeighbourRay LoadPixelRay(ivec2 pixel) {
    // A block at the edge of an image of odd size reaches beyond the image.
    bool inside = all(lessThan(pixel, unified.size));
    return UnpackNeighbourRay(inside ? imageLoad(seen_image, pixel) : NO_RECORD);
}

void GatherNeighbours(inout RayStatistics statistics, NeighbourRay own, ivec2 pixel) {
    ivec2 outward = DirectionOutOfBlock(pixel);
    // All loads stand first, since lavapipe takes longer if they stand between what is gathered.
    NeighbourRay beside = LoadNeighbourRay(pixel + ivec2(outward.x, 0));
    NeighbourRay under = LoadNeighbourRay(pixel + ivec2(0, outward.y));
    NeighbourRay corner = LoadNeighbourRay(pixel + outward);
    NeighbourRay across = RayFromNeighbourX(own, outward.x);
    GatherRay(statistics, own, across);
    GatherRay(statistics, own, RayFromNeighbourY(own, outward.y));
    GatherRay(statistics, own, RayFromNeighbourY(across, outward.y));
    GatherRay(statistics, own, beside);
    GatherRay(statistics, own, RayFromNeighbourY(beside, outward.y));
    GatherRay(statistics, own, under);
    GatherRay(statistics, own, RayFromNeighbourX(under, outward.x));
    GatherRay(statistics, own, corner);
}

#endif

void main() {
    PixelOutput result;
    if (!ShadePixel(ivec2(gl_FragCoord.xy), result))
        discard;
    out_color = result.color;
    out_reflection = result.reflection;
}

#endif
