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

// Row for a cell at x and `outward`, along x, of the cells that lie at y.
Gathered[5] RowAt(int x, int y, int outward) {
    Gathered inner = At(ivec2(x - 2 * outward, y)), middle = At(ivec2(x, y)), outer = At(ivec2(x + 2 * outward, y));
    Gathered before = At(ivec2(x - outward, y)), behind = At(ivec2(x + outward, y));
    return Gathered[5](inner, Handed(middle, before, outward), middle, Handed(inner, behind, outward), outer);
}

Gathered[5] Row(ivec2 cell, ivec2 outward, int y) {
    return RowAt(cell.x, cell.y + 2 * outward.y * y, outward.x);
}

Gathered[5] RowAcross(Gathered row[5], ivec2 cell, ivec2 outward, int y) {
    Gathered other[5] = RowAt(cell.x, cell.y - outward.y * (1 + 2 * y), outward.x);
    return Gathered[5](Handed(row[0], other[0], outward.y), Handed(row[1], other[1], outward.y),
                      Handed(row[2], other[2], outward.y), Handed(row[3], other[3], outward.y),
                      Handed(row[4], other[4], outward.y));
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
Gathered Own(ivec2 pixel) {
    if (IsInside(pixel, 0))
        return At(pixel);
    return Unpacked(NO_RECORD);
}

Gathered[9] RaysAround(ivec2 pixel) {
    ivec2 outward = Outward(pixel);
    ivec2 x = ivec2(outward.x, 0), y = ivec2(0, outward.y);
    Gathered own = Own(pixel), above = Own(pixel - y);
    Gathered across = Handed(own, Own(pixel - x), outward.x);
    Gathered across_above = Handed(above, Own(pixel - outward), outward.x);
    Gathered beside = At(pixel + x), under = At(pixel + y);
    return Gathered[9](own, across, Handed(own, above, outward.y), Handed(across, across_above, outward.y), beside,
                      Handed(beside, At(pixel + x - y), outward.y), under, Handed(under, At(pixel - x + y), outward.x),
                      At(pixel + outward));
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
