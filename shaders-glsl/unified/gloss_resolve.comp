#version 460
#pragma program(ResolveNarrowCompute, NARROW)
#pragma program(CellsCompute, CELLS)
#pragma program(ResolveWideCompute)
// What gloss_resolve.frag makes, a thread a pixel or cell, over tiles or over the whole image. A workgroup loads the rays of
// its texels and of those around them once, into memory that its threads share.

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
#define ROOM (GROUP_SIDE + 2 * REACH) // texels along a side of what a workgroup loads

shared Gathered loaded[ROOM * ROOM];

// The texel of loaded[0].
ivec2 first;

Gathered At(ivec2 texel) {
    ivec2 at = texel - first;
    return loaded[at.y * ROOM + at.x];
}

// Loads what the workgroup gathers, by the texel of this thread. Every thread of the workgroup must call it.
void LoadAll(ivec2 texel) {
    first = texel - ivec2(gl_LocalInvocationID.xy) - REACH;
    for (int i = int(gl_LocalInvocationIndex); i < ROOM * ROOM; i += GROUP_SIDE * GROUP_SIDE) {
        ivec2 at = first + ivec2(i % ROOM, i / ROOM);
#ifdef NARROW
        loaded[i] = Load(at);
#else
        at = Nearest(at);
        loaded[i] = Load(at, WHOLE || IsListed(at / CELLS_TO_A_TILE));
#endif
    }
    barrier();
}

// What another texel of the block has, rounded as fragment programs hand it on (gloss_resolve.frag): a texel adds the
// difference of the two to its own value, and that difference has been rounded.
vec4 Handed(vec4 own, vec4 other, int outward) {
    precise vec4 difference = outward > 0 ? own - other : other - own;
    precise vec4 handed = own - float(outward) * difference;
    return handed;
}

Gathered Handed(Gathered own, Gathered other, int outward) {
    return Gathered(Handed(own.key, other.key, outward), Handed(own.color, other.color, outward));
}

#endif

#ifdef CELLS

layout(binding = 11, rgba16f) uniform writeonly image2D reflection_image;
layout(binding = 12, rgba16f) uniform writeonly image2D surface_image;

// The ray of a column, 0 to 4 from the inside of a block outwards, around a cell at x, of the cells that lie at y. The other cell
// of the block along x hands on those of columns 1 and 3.
Gathered InRow(int x, int y, int outward, int column) {
    int steps = column == 0 || column == 3 ? -2 : column == 4 ? 2 : 0;
    Gathered ray = At(ivec2(x + steps * outward, y));
    if ((column & 1) == 0)
        return ray;
    return Handed(ray, At(ivec2(x + (column - 2) * outward, y)), outward);
}

// Each ray is made by itself: a loop holds no other.
void GatherAround(inout CellSum sum, Here here, ivec2 cell, ivec2 outward) {
    for (int y = -1; y <= 1; ++y)
        for (int column = 0; column < 5; ++column) {
            Gathered ray = InRow(cell.x, cell.y + 2 * outward.y * y, outward.x, column);
            Gather(sum, here, ray);
            if (y < 1) {
                Gathered other = InRow(cell.x, cell.y - outward.y * (1 + 2 * y), outward.x, column);
                Gather(sum, here, Handed(ray, other, outward.y));
            }
        }
}

void main() {
    ivec2 cell;
    if (!ThreadTexel(WIDE_LIST, 1, cell))
        return;
    LoadAll(cell);
    if (!IsInside(cell, 1))
        return;
    Cell resolved = CellOf(cell);
    imageStore(reflection_image, cell, resolved.reflection);
    imageStore(surface_image, cell, resolved.surface);
}

#else

#include "unified/store.glsl"

#ifdef NARROW

#define LIST NARROW_LIST

// The ray of a pixel of the block. A pixel beyond the border of the image has none.
Gathered OwnRay(ivec2 pixel) {
    if (IsInside(pixel, 0))
        return At(pixel);
    return Unpacked(NO_RECORD);
}

// The ray of a pixel of the block, or of one outside of it.
Gathered RayOf(ivec2 pixel, bool in_block) {
    if (in_block)
        return OwnRay(pixel);
    return At(pixel);
}

// Each ray is made by itself: a loop holds no other.
void GatherAround(inout Around around, Gathered own, ivec2 pixel) {
    ivec2 outward = Outward(pixel);
    ivec2 x = ivec2(outward.x, 0), y = ivec2(0, outward.y);
    for (int n = 1; n < 9; ++n) {
        // Bits of the rays that other pixels of the block hand on, along x and along y.
        bool across_x = (0x8a >> n & 1) != 0, across_y = (0x2c >> n & 1) != 0, in_block = n < 4;
        ivec2 first = pixel + (n == 4 || n == 5 || n == 8 ? x : ivec2(0)) + (n >= 6 ? y : ivec2(0));
        Gathered ray = RayOf(first, in_block);
        if (across_x)
            ray = Handed(ray, RayOf(first - x, in_block), outward.x);
        if (across_y) {
            Gathered other = RayOf(first - y, in_block);
            if (across_x)
                other = Handed(other, RayOf(first - outward, in_block), outward.x);
            ray = Handed(ray, other, outward.y);
        }
        Gather(around, own, ray);
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
    LoadAll(pixel);
#endif
    Shown shown;
    if (!IsInside(pixel, 0) || !Show(pixel, shown))
        return;
    Store(pixel, shown.color, shown.reflection);
}

#endif
