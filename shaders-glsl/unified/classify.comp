#version 460
// Which tiles hold mirrors and which hold gloss, as lists with the arguments of an indirect draw.
// A thread looks at a tile. `counts` has been cleared to 0.

layout(local_size_x = 8, local_size_y = 8) in;

#include "unified/parameters.glsl"
#include "unified/tiles.glsl"

layout(binding = 1) uniform sampler2D material_buffer; // reflectivity, roughness
layout(std430, binding = 2) buffer Counts {
    uint counts[]; // for each list: vertices (a point a tile), instances, first vertex, first instance
};
layout(std430, binding = 3) writeonly buffer Tiles {
    uint tiles[]; // for each list, room for every tile
};

void main() {
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    ivec2 tile_count = TileCount();
    if (gl_GlobalInvocationID.xy == uvec2(0)) {
        counts[4 * MIRROR_LIST + 1] = 1;
        counts[4 * GLOSSY_LIST + 1] = 1;
    }
    if (any(greaterThanEqual(tile, tile_count)))
        return;
    bvec2 found = bvec2(false);
    ivec2 first = tile * TILE, last = min(first + TILE, unified.size) - 1;
    for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x) {
            vec2 material = texelFetch(material_buffer, ivec2(x, y), 0).xy;
            bool reflects = Reflects(material);
            int list = ListOf(material);
            found.x = found.x || (reflects && list == MIRROR_LIST);
            found.y = found.y || (reflects && list == GLOSSY_LIST);
        }
    }
    uint room = uint(tile_count.x * tile_count.y);
    if (found.x)
        tiles[atomicAdd(counts[4 * MIRROR_LIST], 1u)] = PackTile(uvec2(tile));
    if (found.y)
        tiles[room + atomicAdd(counts[4 * GLOSSY_LIST], 1u)] = PackTile(uvec2(tile));
}
