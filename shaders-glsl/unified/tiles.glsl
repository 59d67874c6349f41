// Tiles of pixels: what the classification writes and the passes are drawn over. A tile stands on the list
// of each kind of reflector that it has a pixel of, on several if it has several.

#define TILE 16 // pixels along a side
#define MIRROR_LIST 0
#define NARROW_LIST 1
#define WIDE_LIST 2
#define LISTS 3

// As passes::WIDE_ABOVE. Of a roughness up to this, a ray a pixel is traced; above, one for 2 x 2, of which
// more are gathered: a wider lobe needs more rays, and those of farther neighbours fit it.
#define WIDE_ABOVE 0.2

bool Reflects(vec2 material) {
    return material.x > REFLECTS_ABOVE;
}

// The list of a pixel that reflects.
int ListOf(vec2 material) {
    return material.y > WIDE_ABOVE ? WIDE_LIST : material.y > 0.0 ? NARROW_LIST : MIRROR_LIST;
}

ivec2 TileCount() {
    return (unified.size + TILE - 1) / TILE;
}

// A tile's place in a word.
uint PackTile(uvec2 tile) {
    return tile.x | tile.y << 16;
}

ivec2 UnpackTile(uint word) {
    return ivec2(word & 0xffffu, word >> 16);
}
