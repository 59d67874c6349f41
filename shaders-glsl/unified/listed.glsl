// Which cells of 2 x 2 pixels have been drawn for wide lobes: those of tiles on their list. Elsewhere their images
// hold anything. With WHOLE every cell has been. Needs parameters.glsl and tiles.glsl.

#ifdef WHOLE

void LookAround(ivec2 cell, ivec2 side) {}

bool IsDrawn(ivec2 cell) {
    return true;
}

#else

layout(binding = 8, r32ui) uniform readonly uimage2D listed_image; // for each tile, a bit for each list it stands on

#define CELLS (TILE / 2) // along a side of a tile

// The tile of a cell with a wide lobe, which is drawn, and whether those beside it are.
struct Around {
    ivec2 home;
    bool across, along, corner;
} around;

bool IsListed(ivec2 tile) {
    ivec2 at = clamp(tile, ivec2(0), TileCount() - 1);
    return (imageLoad(listed_image, at).r >> WIDE_LIST & 1u) != 0u;
}

// Before IsDrawn: around a cell, the tiles to a side, 1 or -1 along each axis.
void LookAround(ivec2 cell, ivec2 side) {
    ivec2 home = cell / CELLS;
    around = Around(home, IsListed(home + ivec2(side.x, 0)), IsListed(home + ivec2(0, side.y)), IsListed(home + side));
}

// A cell of the home tile or of one to that side.
bool IsDrawn(ivec2 cell) {
    bvec2 beside = notEqual(cell / CELLS, around.home);
    return beside.x ? (beside.y ? around.corner : around.across) : !beside.y || around.along;
}

#endif
