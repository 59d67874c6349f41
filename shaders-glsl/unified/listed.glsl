// Which cells of 2 x 2 pixels have been drawn for wide lobes: those of tiles on their list. Elsewhere their images
// hold anything. With WHOLE every cell has been. Needs parameters.glsl and tiles.glsl.

#ifdef WHOLE

#define LISTED_AROUND(cell, side)
#define IS_DRAWN(at) true

#else

layout(std430, binding = 8) readonly buffer Listed {
    uint listed[]; // for each tile, a bit for each list that it stands on
};

#define CELLS (TILE / 2) // along a side of a tile

// The tile of a cell with a wide lobe, which is drawn, and whether those beside it are.
struct Around {
    ivec2 home;
    bool across, along, corner;
};

bool IsListed(ivec2 tile) {
    ivec2 count = TileCount();
    ivec2 at = clamp(tile, ivec2(0), count - 1);
    return (listed[at.y * count.x + at.x] >> WIDE_LIST & 1u) != 0u;
}

// Of the tiles to a side, 1 or -1 along each axis.
Around ListedAround(ivec2 cell, ivec2 side) {
    ivec2 home = cell / CELLS;
    return Around(home, IsListed(home + ivec2(side.x, 0)), IsListed(home + ivec2(0, side.y)), IsListed(home + side));
}

// A cell of the home tile or of one to that side.
bool IsDrawn(Around around, ivec2 at) {
    bvec2 beside = notEqual(at / CELLS, around.home);
    return beside.x ? (beside.y ? around.corner : around.across) : !beside.y || around.along;
}

#define LISTED_AROUND(cell, side) Around around = ListedAround(cell, side)
#define IS_DRAWN(at) IsDrawn(around, at)

#endif
