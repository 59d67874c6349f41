// Tests which cells have been drawn: the cells of tiles on the list of wide lobes. Elsewhere the images of cells are
// undefined. With WHOLE every cell has been drawn.

#ifndef UNIFIED_DRAWN_CELLS_GLSL
#define UNIFIED_DRAWN_CELLS_GLSL

#include "unified/parameters.glsl"

layout(binding = 8, r32ui) uniform readonly uimage2D listed_image; // for each tile, a bit for each list it stands on

#define CELLS_TO_A_TILE (TILE_SIDE / 2) // along a side

// The tile of a cell with a wide lobe, which is drawn, and whether three of the tiles beside it are drawn: the next
// along x, the next along y, and the diagonal one.
struct NeighbourTiles {
    ivec2 home;
    bool next_x, next_y, diagonal;
} drawn;

bool IsWideTile(ivec2 tile) {
    ivec2 clamped_tile = clamp(tile, ivec2(0), TileCount() - 1);
    return (imageLoad(listed_image, clamped_tile).r >> WIDE_LIST & 1u) != 0u;
}

// Loads whether the three tiles beside a cell's own tile are drawn. `side` is 1 or -1 along each axis: on which side
// they lie. Must be called before IsDrawn.
void LoadNeighbourTiles(ivec2 cell, ivec2 side) {
    if (WHOLE)
        return;
    ivec2 home = cell / CELLS_TO_A_TILE;
    drawn = NeighbourTiles(home, IsWideTile(home + ivec2(side.x, 0)), IsWideTile(home + ivec2(0, side.y)), IsWideTile(home + side));
}

// Whether a cell has been drawn. The cell must lie in the tile of the cell that was passed to LoadNeighbourTiles, or in
// one of the three tiles beside that tile.
bool IsDrawn(ivec2 cell) {
    if (WHOLE)
        return true;
    bvec2 beside = notEqual(cell / CELLS_TO_A_TILE, drawn.home);
    return beside.x ? (beside.y ? drawn.diagonal : drawn.next_x) : !beside.y || drawn.next_y;
}

#endif
