#version 460
#pragma program(Classify)
// Finds which tiles hold mirrors, narrow lobes and wide lobes, and writes a list of tiles for each kind, with the
// arguments of indirect draws and dispatches over it. A thread looks at one tile. `counts` has been cleared to 0.

layout(local_size_x = 8, local_size_y = 8) in;

#include "unified/parameters.glsl"

layout(binding = 1, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness
layout(std430, binding = 2) buffer Counts {
    uint counts[]; // at DrawArguments and DispatchArguments
};
layout(std430, binding = 3) writeonly buffer Tiles {
    uint tiles[]; // for each list, room for every tile
};
layout(binding = 4, r32ui) uniform writeonly uimage2D listed_image; // for each tile, a bit for each list it stands on

void main() {
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    ivec2 tile_count = TileCount();
    if (gl_GlobalInvocationID.xy == uvec2(0)) {
        for (int list = 0; list < LISTS; ++list) {
            counts[DrawArguments(list) + 1] = 1;
            for (int halved = 0; halved < 2; ++halved) {
                int groups_per_side = GroupsPerTile(halved);
                counts[DispatchArguments(list, halved)] = uint(groups_per_side * groups_per_side);
            }
        }
    }
    if (any(greaterThanEqual(tile, tile_count)))
        return;
    uint lists_of_tile = 0;
    ivec2 first_pixel = tile * TILE_SIDE, last_pixel = min(first_pixel + TILE_SIDE, unified.size) - 1;
    for (int y = first_pixel.y; y <= last_pixel.y; ++y) {
        for (int x = first_pixel.x; x <= last_pixel.x; ++x) {
            vec2 material = imageLoad(material_buffer, ivec2(x, y)).xy;
            lists_of_tile |= Reflects(material) ? 1u << TileListOf(material) : 0u;
        }
    }
    imageStore(listed_image, tile, uvec4(lists_of_tile));
    int list_capacity = tile_count.x * tile_count.y;
    for (int list = 0; list < LISTS; ++list) {
        if ((lists_of_tile >> list & 1u) == 0u)
            continue;
        int index = int(atomicAdd(counts[DrawArguments(list)], 1u));
        tiles[list * list_capacity + index] = PackTile(uvec2(tile));
        // The dispatch has rows of up to TILES_TO_A_ROW tiles, and each multiple of that number begins another row.
        for (int halved = 0; halved < 2; ++halved) {
            if (index < TILES_TO_A_ROW)
                atomicAdd(counts[DispatchArguments(list, halved) + 1], 1u);
            if (index % TILES_TO_A_ROW == 0)
                atomicAdd(counts[DispatchArguments(list, halved) + 2], 1u);
        }
    }
}
