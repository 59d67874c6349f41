#version 460
#pragma program(Classify)
// Which tiles hold mirrors, narrow lobes and wide ones, as lists with the arguments of an indirect draw.
// A thread looks at a tile. `counts` has been cleared to 0.

layout(local_size_x = 8, local_size_y = 8) in;

#include "unified/parameters.glsl"

layout(binding = 1, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness
layout(std430, binding = 2) buffer Counts {
    uint counts[]; // for each list: vertices (a point a tile), instances, first vertex, first instance
};
layout(std430, binding = 3) writeonly buffer Tiles {
    uint tiles[]; // for each list, room for every tile
};
layout(binding = 4, r32ui) uniform writeonly uimage2D listed_image; // for each tile, a bit for each list it stands on

void main() {
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    ivec2 tile_count = TileCount();
    if (gl_GlobalInvocationID.xy == uvec2(0)) {
        for (int list = 0; list < LISTS; ++list)
            counts[4 * list + 1] = 1;
    }
    if (any(greaterThanEqual(tile, tile_count)))
        return;
    uint found = 0;
    ivec2 first = tile * TILE_SIDE, last = min(first + TILE_SIDE, unified.size) - 1;
    for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x) {
            vec2 material = imageLoad(material_buffer, ivec2(x, y)).xy;
            found |= Reflects(material) ? 1u << ListOf(material) : 0u;
        }
    }
    imageStore(listed_image, tile, uvec4(found));
    int room = tile_count.x * tile_count.y;
    for (int list = 0; list < LISTS; ++list) {
        if ((found >> list & 1u) != 0u)
            tiles[list * room + int(atomicAdd(counts[4 * list], 1u))] = PackTile(uvec2(tile));
    }
}
