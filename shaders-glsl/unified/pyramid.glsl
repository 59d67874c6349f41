// The pyramid: cell (x, y) of level n covers exactly the pixels (i, j) with i >> n = x, j >> n = y. The cell holds
// their nearest front and their farthest back in reversed depth, so that the closed interval [back, front] bounds every
// block in it; a cell without geometry is empty.
//
// All levels lie in one image, cut into strips of a few columns. A row of the image holds one strip, whose short rows
// follow each other. So the cells above and below a cell lie as near in memory as those beside it, even on a device
// that lays out images row by row. Level n begins at row strips - (strips >> n), where `strips` is twice the number of
// strips of level 0. So the texel of a cell takes shifts and an addition, whatever its level, and no device has to look
// up a mip level for each thread. Passes load the pyramid as an image of one level, since nothing in it is ever
// filtered.

#ifndef UNIFIED_PYRAMID_GLSL
#define UNIFIED_PYRAMID_GLSL

#include "unified/parameters.glsl"

layout(constant_id = 0) const int STRIP = 2; // log2 of the columns to a strip

const vec2 EMPTY_BLOCK = vec2(-1.0, 2.0); // front below every depth, back above

// Twice the number of strips of level 0.
int PyramidStrips() {
    return 2 * unified.padded.x >> STRIP;
}

// The texel of a cell in a level whose first row is `row`.
ivec2 StripTexel(ivec2 cell, int row) {
    int column = cell.x & ((1 << STRIP) - 1);
    return ivec2((cell.y << STRIP) | column, (cell.x >> STRIP) + row);
}

// The texel of the pyramid's image that holds a cell of a level. PixelTexel returns that of a pixel, a cell of level 0.
ivec2 CellTexel(ivec2 cell, int level) {
    int strips = PyramidStrips();
    return StripTexel(cell, strips - (strips >> level));
}

ivec2 PixelTexel(ivec2 pixel) {
    return StripTexel(pixel, 0);
}

#endif
