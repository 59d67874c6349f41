// Finds the texel of a thread, in compute programs of `unified` that replace its fragment programs (`--trace-stage`,
// `--resolve-stage`). Workgroups cover the tiles of a list, as many as classify.comp has counted, or the whole image.

#ifndef UNIFIED_GROUPS_GLSL
#define UNIFIED_GROUPS_GLSL

#include "unified/parameters.glsl"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;

layout(constant_id = 4) const bool WHOLE = false; // over the whole image, not over tiles

layout(std430, binding = 9) readonly buffer Tiles {
    uint tiles[];
};
layout(std430, binding = 10) readonly buffer Counts {
    uint counts[]; // as classify.comp wrote them
};

// Finds the texel of a thread; false for all threads of a workgroup beyond the end of the list. `halved` is as in
// GroupsPerTile. The texel may lie beyond the border of the image.
bool ThreadTexel(int list, int halved, out ivec2 texel) {
    texel = ivec2(gl_GlobalInvocationID.xy);
    if (WHOLE)
        return true;
    uint index = gl_WorkGroupID.z * uint(TILES_TO_A_ROW) + gl_WorkGroupID.y;
    if (index >= counts[DrawArguments(list)])
        return false;
    ivec2 count = TileCount();
    ivec2 tile = UnpackTile(tiles[list * count.x * count.y + int(index)]);
    int part = int(gl_WorkGroupID.x), parts = GroupsPerTile(halved);
    ivec2 group = tile * parts + ivec2(part % parts, part / parts);
    texel = group * GROUP_SIDE + ivec2(gl_LocalInvocationID.xy);
    return true;
}

// Whether a texel lies inside the image, or with `halved` 1 inside an image with a texel for 2 x 2 pixels.
bool IsInside(ivec2 texel, int halved) {
    return all(lessThan(texel, (unified.size + halved) >> halved));
}

#endif
