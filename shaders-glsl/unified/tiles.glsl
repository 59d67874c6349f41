// Tiles of 8 x 8 pixels: what the classification writes and the traces are drawn over. A tile stands
// on the list of mirrors if it has a pixel that reflects with roughness 0, and on the glossy list if it
// has one that reflects with more; on both if it has both.

#define TILE 8
#define MIRROR_LIST 0
#define GLOSSY_LIST 1

bool Reflects(vec2 material) {
    return material.x > REFLECTS_ABOVE;
}

int ListOf(vec2 material) {
    return material.y > 0.0 ? GLOSSY_LIST : MIRROR_LIST;
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
