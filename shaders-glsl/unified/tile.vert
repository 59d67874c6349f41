#version 460
#pragma program(Tile)
// Draws the tiles of a list as points of a tile's size, indirectly and without a vertex buffer. A point is a square
// without a diagonal between two triangles, along which devices would shade blocks twice.

#include "unified/parameters.glsl"

layout(push_constant) uniform TileListBlock {
    int list;  // MIRROR_LIST, NARROW_LIST or WIDE_LIST
    int halved; // 1 where the targets have a texel for 2 x 2 pixels, else 0
} tile_list;

layout(std430, binding = 9) readonly buffer Tiles {
    uint tiles[];
};

void main() {
    ivec2 count = TileCount();
    ivec2 tile = UnpackTile(tiles[tile_list.list * count.x * count.y + gl_VertexIndex]);
    ivec2 size = (unified.size + tile_list.halved) >> tile_list.halved;
    int side = TILE_SIDE >> tile_list.halved;
    // A point whose centre is off screen is dropped. The last tiles are therefore moved inwards, over pixels that their
    // neighbours may shade as well, with the same result. They move by an even number of pixels, so that no block of 2
    // x 2 pixels is cut. On a screen smaller than a tile, the point is centred on the screen's middle.
    ivec2 first = min(tile * side, (size - side + 1) & -2);
    vec2 centre = max(vec2(first) + 0.5 * float(side), 0.5 * vec2(min(size, ivec2(side))));
    gl_Position = vec4(centre / vec2(size) * 2.0 - 1.0, 0.0, 1.0);
    gl_PointSize = float(side);
}
