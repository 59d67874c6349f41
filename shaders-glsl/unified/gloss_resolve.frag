#version 460
#pragma program(ResolveNarrow, NARROW)
#pragma program(Cells, CELLS)
#pragma program(ResolveWide)
// From the rays of gloss_trace.glsl to the image: the reflection of each pixel with a narrow lobe (NARROW), of each cell
// with a wide lobe (CELLS), and of each pixel with a wide lobe between such cells, drawn over tiles as points or over the
// whole image. Pixels of a block of 2 x 2 hand each other the rays that they loaded.

layout(constant_id = 4) const bool WHOLE = false; // over the whole image, not over tiles

#if defined(NARROW)
#include "unified/resolve_narrow.glsl"
#elif defined(CELLS)
#include "unified/resolve_cells.glsl"
#else
#include "unified/resolve_wide.glsl"
#endif

#if defined(NARROW) || defined(CELLS)

// What the other pixel along an axis has. `outward` is that of the pixel that asks, along this axis.
Gathered AcrossX(Gathered r, int outward) {
    return Gathered(r.key - float(outward) * dFdxFine(r.key), r.color - float(outward) * dFdxFine(r.color));
}

Gathered AcrossY(Gathered r, int outward) {
    return Gathered(r.key - float(outward) * dFdyFine(r.key), r.color - float(outward) * dFdyFine(r.color));
}

#endif

#ifdef CELLS

layout(location = 0) out vec4 out_reflection;
layout(location = 1) out vec4 out_surface;

Gathered Load(ivec2 cell) {
    ivec2 at = Nearest(cell);
    return Load(at, IsDrawn(at));
}

// Gathers a ray, and the one that the other cell of the block along y has in its place.
void GatherBoth(inout CellSum sum, Here here, Gathered ray, int outward) {
    Gather(sum, here, ray);
    Gather(sum, here, AcrossY(ray, outward));
}

// The rays of a row, the first of which is two cells inwards, and those that the other cell of the block along y has in their places.
void GatherRows(inout CellSum sum, Here here, ivec2 cell, ivec2 outward) {
    // The other cell of the block along x hands on the rays between those that are loaded.
    Gathered inner = Load(cell - ivec2(2 * outward.x, 0));
    Gathered middle = Load(cell);
    GatherBoth(sum, here, inner, outward.y);
    GatherBoth(sum, here, AcrossX(middle, outward.x), outward.y);
    GatherBoth(sum, here, middle, outward.y);
    GatherBoth(sum, here, AcrossX(inner, outward.x), outward.y);
    GatherBoth(sum, here, Load(cell + ivec2(2 * outward.x, 0)), outward.y);
}

// Row by row and not in a loop, which SwiftShader of Chromium 156 compiles for minutes in gigabytes.
void GatherAround(inout CellSum sum, Here here, ivec2 cell, ivec2 outward) {
    ivec2 y = ivec2(0, 2 * outward.y);
    GatherRows(sum, here, cell - y, outward);
    GatherRows(sum, here, cell, outward);
    Gathered inner = Load(cell + y - ivec2(2 * outward.x, 0));
    Gathered middle = Load(cell + y);
    Gather(sum, here, inner);
    Gather(sum, here, AcrossX(middle, outward.x));
    Gather(sum, here, middle);
    Gather(sum, here, AcrossX(inner, outward.x));
    Gather(sum, here, Load(cell + 2 * outward));
}

void main() {
    ivec2 cell = ivec2(gl_FragCoord.xy);
    // A reach of two cells can touch only these of the tiles beside this one.
    LookAround(cell, 1 - 2 * ivec2(lessThan(cell & (CELLS_TO_A_TILE - 1), ivec2(2))));
    Cell resolved = CellOf(cell);
    out_reflection = resolved.reflection;
    out_surface = resolved.surface;
}

#else

layout(location = 0) out vec4 out_color;
layout(location = 1) out vec4 out_reflection; // where it is wanted beside it

#ifdef NARROW

Gathered OwnRay(ivec2 pixel) {
    // A block at the edge of an image of odd size reaches beyond the image.
    bool inside = all(lessThan(pixel, unified.size));
    return Unpacked(inside ? imageLoad(seen_image, pixel) : NO_RECORD);
}

void GatherAround(inout Around around, Gathered own, ivec2 pixel) {
    ivec2 outward = Outward(pixel);
    Gathered across = AcrossX(own, outward.x);
    Gather(around, own, across);
    Gather(around, own, AcrossY(own, outward.y));
    Gather(around, own, AcrossY(across, outward.y));
    Gathered beside = Load(pixel + ivec2(outward.x, 0));
    Gather(around, own, beside);
    Gather(around, own, AcrossY(beside, outward.y));
    Gathered under = Load(pixel + ivec2(0, outward.y));
    Gather(around, own, under);
    Gather(around, own, AcrossX(under, outward.x));
    Gather(around, own, Load(pixel + outward));
}

#endif

void main() {
    Shown shown;
    if (!Show(ivec2(gl_FragCoord.xy), shown))
        discard;
    out_color = shown.color;
    out_reflection = shown.reflection;
}

#endif
