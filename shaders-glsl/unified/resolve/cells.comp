#version 460
#pragma program(Cells)
// The reflections of cells with wide lobes, a thread a cell, over tiles or over the whole image.

#include "unified/groups.glsl"
#include "unified/resolve/cells.glsl"

#define REACH 2
#include "unified/resolve/shared_rays.glsl"

layout(binding = 11, rgba16f) uniform writeonly image2D reflection_image;
layout(binding = 12, rgba16f) uniform writeonly image2D surface_image;

NeighbourRay LoadGatheredRay(ivec2 cell) {
    ivec2 clamped_cell = ClampCell(cell);
    return LoadCellRay(clamped_cell, WHOLE || IsWideTile(clamped_cell / CELLS_TO_A_TILE));
}

// The ray of one of the five cells around x in the row y. Columns 0 to 4 follow each other in the direction `outward`
// out of the block; column 2 is x itself. The rays of even columns are read. The rays of odd columns are rounded as in
// fragment programs, from two rays: one that is read, and the ray that the block's other cell along x reads in its
// place. Column 1 is made from column 2, and column 3 from column 0.
NeighbourRay RayInRow(int x, int y, int outward, int column) {
    int read_offset = column == 0 || column == 3 ? -2 : column == 4 ? 2 : 0;
    NeighbourRay ray = SharedRay(ivec2(x + read_offset * outward, y));
    if ((column & 1) == 0)
        return ray;
    return RayFromNeighbour(ray, SharedRay(ivec2(x + (column - 2) * outward, y)), outward);
}

// Gathers the 5 x 5 rays around a cell. Each ray is made when it is needed, so that the loop holds no other ray.
void GatherNeighbours(inout CellSum sum, GatherPoint centre, ivec2 cell, ivec2 outward) {
    for (int y = -1; y <= 1; ++y)
        for (int column = 0; column < 5; ++column) {
            NeighbourRay ray = RayInRow(cell.x, cell.y + 2 * outward.y * y, outward.x, column);
            float closeness = column == 2 ? 1.0 : (column & 1) != 0 ? 0.5 : 0.0;
            GatherRay(sum, centre, ray, y == 0 ? closeness : 0.0);
            if (y < 1) {
                NeighbourRay other = RayInRow(cell.x, cell.y - outward.y * (1 + 2 * y), outward.x, column);
                GatherRay(sum, centre, RayFromNeighbour(ray, other, outward.y), 0.5 * closeness);
            }
        }
}

void main() {
    ivec2 cell;
    if (!ThreadTexel(WIDE_LIST, 1, cell))
        return;
    LoadSharedRays(cell);
    if (!IsInside(cell, 1))
        return;
    ResolvedCell resolved = ResolveCell(cell);
    imageStore(reflection_image, cell, resolved.reflection);
    imageStore(surface_image, cell, resolved.surface);
}
