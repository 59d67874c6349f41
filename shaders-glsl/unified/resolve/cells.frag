#version 460
#pragma program(Cells)
// The reflections of cells with wide lobes, drawn over tiles as points or over the whole image.

layout(constant_id = 4) const bool WHOLE = false; // over the whole image, not over tiles

#include "unified/resolve/cells.glsl"
#include "unified/resolve/exchanged_rays.glsl"

layout(location = 0) out vec4 out_reflection;
layout(location = 1) out vec4 out_surface;

NeighbourRay LoadCellRay(ivec2 cell) {
    ivec2 clamped_cell = ClampCell(cell);
    return LoadCellRay(clamped_cell, IsDrawn(clamped_cell));
}

// Gathers a ray, and the ray that the block's other cell along y has in its place. `closeness` has that of both.
void GatherWithNeighbour(inout CellSum sum, GatherPoint centre, NeighbourRay ray, int outward, vec2 closeness) {
    GatherRay(sum, centre, ray, closeness.x);
    GatherRay(sum, centre, RayFromNeighbourY(ray, outward), closeness.y);
}

// Gathers the five rays of a row, beginning two cells inwards, and the five rays that the block's other cell along y
// has in their places. `closeness` is that of the middle ray of each of the two rows.
void GatherTwoRows(inout CellSum sum, GatherPoint centre, ivec2 cell, ivec2 outward, vec2 closeness) {
    // The block's other cell along x hands on the rays between the loaded ones.
    NeighbourRay inner = LoadCellRay(cell - ivec2(2 * outward.x, 0));
    NeighbourRay middle = LoadCellRay(cell);
    GatherWithNeighbour(sum, centre, inner, outward.y, vec2(0.0));
    GatherWithNeighbour(sum, centre, RayFromNeighbourX(middle, outward.x), outward.y, 0.5 * closeness);
    GatherWithNeighbour(sum, centre, middle, outward.y, closeness);
    GatherWithNeighbour(sum, centre, RayFromNeighbourX(inner, outward.x), outward.y, 0.5 * closeness);
    GatherWithNeighbour(sum, centre, LoadCellRay(cell + ivec2(2 * outward.x, 0)), outward.y, vec2(0.0));
}

// Gathers the 5 x 5 rays around a cell. The rows are written out without a loop, which SwiftShader of Chromium 156
// would compile for minutes and in gigabytes of memory.
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
    // The cells within two cells of this one can lie only in its own tile and in the tiles on this side.
    LoadNeighbourTiles(cell, 1 - 2 * ivec2(lessThan(cell & (CELLS_TO_A_TILE - 1), ivec2(2))));
    ResolvedCell resolved = ResolveCell(cell);
    out_reflection = resolved.reflection;
    out_surface = resolved.surface;
}
