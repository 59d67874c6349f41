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

// Loads the rays of every second cell. The other cell of the block along x hands on those between.
Gathered[5] Row(ivec2 cell, ivec2 outward, int y) {
    Gathered inner = Load(cell + 2 * outward * ivec2(-1, y));
    Gathered middle = Load(cell + 2 * outward * ivec2(0, y));
    Gathered outer = Load(cell + 2 * outward * ivec2(1, y));
    return Gathered[5](inner, AcrossX(middle, outward.x), middle, AcrossX(inner, outward.x), outer);
}

Gathered[5] RowAcross(Gathered row[5], ivec2 cell, ivec2 outward, int y) {
    return Gathered[5](AcrossY(row[0], outward.y), AcrossY(row[1], outward.y), AcrossY(row[2], outward.y),
                      AcrossY(row[3], outward.y), AcrossY(row[4], outward.y));
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

Gathered[9] RaysAround(ivec2 pixel) {
    // A block at the edge of an image of odd size reaches beyond the image.
    bool inside = all(lessThan(pixel, unified.size));
    Gathered own = Unpacked(inside ? imageLoad(seen_image, pixel) : NO_RECORD);
    ivec2 outward = Outward(pixel);
    Gathered across = AcrossX(own, outward.x);
    Gathered beside = Load(pixel + ivec2(outward.x, 0));
    Gathered under = Load(pixel + ivec2(0, outward.y));
    return Gathered[9](own, across, AcrossY(own, outward.y), AcrossY(across, outward.y), beside,
                      AcrossY(beside, outward.y), under, AcrossX(under, outward.x), Load(pixel + outward));
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
