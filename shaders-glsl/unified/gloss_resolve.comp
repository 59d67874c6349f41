#version 460
#pragma program(ResolveNarrow, NARROW)
#pragma program(Cells, CELLS)
#pragma program(ResolveWide)
// Makes what gloss_resolve.frag draws, with a thread for each pixel or cell, over tiles or over the whole image. A
// workgroup loads the rays of its texels and of those around them once, into memory that its threads share.

#include "unified/groups.glsl"

#if defined(NARROW)
#include "unified/resolve_narrow.glsl"
#elif defined(CELLS)
#include "unified/resolve_cells.glsl"
#else
#include "unified/resolve_wide.glsl"
#endif

#if defined(NARROW) || defined(CELLS)

#ifdef NARROW
#define REACH 1 // texels, along each axis, from a texel to the farthest that it gathers
#else
#define REACH 2
#endif
#define ROOM (GROUP_SIDE + 2 * REACH) // texels along a side of the square that a workgroup loads

shared NeighbourRay loaded[ROOM * ROOM];

// The texel of loaded[0].
ivec2 first;

NeighbourRay SharedRay(ivec2 texel) {
    ivec2 offset = texel - first;
    return loaded[offset.y * ROOM + offset.x];
}

// Loads what the workgroup gathers, by the texel of this thread. Every thread of the workgroup must call it.
void LoadSharedRays(ivec2 texel) {
    first = texel - ivec2(gl_LocalInvocationID.xy) - REACH;
    for (int i = int(gl_LocalInvocationIndex); i < ROOM * ROOM; i += GROUP_SIDE * GROUP_SIDE) {
        ivec2 neighbour = first + ivec2(i % ROOM, i / ROOM);
#ifdef NARROW
        loaded[i] = LoadNeighbourRay(neighbour);
#else
        neighbour = ClampCell(neighbour);
        loaded[i] = LoadCellRay(neighbour, WHOLE || IsWideTile(neighbour / CELLS_TO_A_TILE));
#endif
    }
    barrier();
}

// The value of another texel of the block, rounded as in fragment programs (gloss_resolve.frag): a texel adds the
// rounded difference of the two values to its own value.
vec4 ValueFromNeighbour(vec4 own, vec4 other, int outward) {
    precise vec4 difference = outward > 0 ? own - other : other - own;
    precise vec4 handed = own - float(outward) * difference;
    return handed;
}

NeighbourRay RayFromNeighbour(NeighbourRay own, NeighbourRay other, int outward) {
    return NeighbourRay(ValueFromNeighbour(own.key, other.key, outward), ValueFromNeighbour(own.color, other.color, outward));
}

#endif

#ifdef CELLS

layout(binding = 11, rgba16f) uniform writeonly image2D reflection_image;
layout(binding = 12, rgba16f) uniform writeonly image2D surface_image;

// The ray of a column, 0 to 4 from the inside of a block outwards, in the row y around a cell at x. The other cell of
// the block along x hands on the rays of columns 1 and 3.
NeighbourRay RayInRow(int x, int y, int outward, int column) {
    int steps = column == 0 || column == 3 ? -2 : column == 4 ? 2 : 0;
    NeighbourRay ray = SharedRay(ivec2(x + steps * outward, y));
    if ((column & 1) == 0)
        return ray;
    return RayFromNeighbour(ray, SharedRay(ivec2(x + (column - 2) * outward, y)), outward);
}

// Each ray is made by itself, so that the loop holds no other ray.
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

#else

#include "unified/store.glsl"

#ifdef NARROW

#define LIST NARROW_LIST

// The ray of a pixel of the block. A pixel beyond the border of the image has none.
NeighbourRay LoadPixelRay(ivec2 pixel) {
    if (IsInside(pixel, 0))
        return SharedRay(pixel);
    return UnpackNeighbourRay(NO_RECORD);
}

// The ray of a pixel of the block, or of one outside of it.
NeighbourRay LoadBlockRay(ivec2 pixel, bool in_block) {
    if (in_block)
        return LoadPixelRay(pixel);
    return SharedRay(pixel);
}

// Each ray is made by itself, so that the loop holds no other ray.
void GatherNeighbours(inout RayStatistics statistics, NeighbourRay own, ivec2 pixel) {
    ivec2 outward = DirectionOutOfBlock(pixel);
    ivec2 x = ivec2(outward.x, 0), y = ivec2(0, outward.y);
    for (int n = 1; n < 9; ++n) {
        // Bits of the rays that other pixels of the block hand on, along x and along y.
        bool across_x = (0x8a >> n & 1) != 0, across_y = (0x2c >> n & 1) != 0, in_block = n < 4;
        ivec2 first = pixel + (n == 4 || n == 5 || n == 8 ? x : ivec2(0)) + (n >= 6 ? y : ivec2(0));
        NeighbourRay ray = LoadBlockRay(first, in_block);
        if (across_x)
            ray = RayFromNeighbour(ray, LoadBlockRay(first - x, in_block), outward.x);
        if (across_y) {
            NeighbourRay other = LoadBlockRay(first - y, in_block);
            if (across_x)
                other = RayFromNeighbour(other, LoadBlockRay(first - outward, in_block), outward.x);
            ray = RayFromNeighbour(ray, other, outward.y);
        }
        GatherRay(statistics, own, ray);
    }
}

#else

#define LIST WIDE_LIST

#endif

void main() {
    ivec2 pixel;
    if (!ThreadTexel(LIST, 0, pixel))
        return;
#ifdef NARROW
    LoadSharedRays(pixel);
#endif
    PixelOutput result;
    if (!IsInside(pixel, 0) || !ShadePixel(pixel, result))
        return;
    StorePixel(pixel, result.color, result.reflection);
}

#endif
