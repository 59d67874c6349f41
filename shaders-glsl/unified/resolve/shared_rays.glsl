// Loads the rays that a workgroup of a compute program gathers once, into memory that its threads share. A program that
// includes this file defines LoadGatheredRay, and REACH: how many texels away along each axis the farthest ray is that
// a texel gathers.

#ifndef UNIFIED_SHARED_RAYS_GLSL
#define UNIFIED_SHARED_RAYS_GLSL

#include "unified/resolve/gathered.glsl"

#define ROOM (GROUP_SIDE + 2 * REACH) // texels along a side of the square that a workgroup loads

shared NeighbourRay loaded[ROOM * ROOM];

// The texel of loaded[0].
ivec2 first;

// The ray of a texel, which may lie beyond the border of the image.
NeighbourRay LoadGatheredRay(ivec2 texel);

// The ray of a texel, after LoadSharedRays has loaded it.
NeighbourRay SharedRay(ivec2 texel) {
    ivec2 offset = texel - first;
    return loaded[offset.y * ROOM + offset.x];
}

// Loads what the workgroup gathers, by the texel of this thread. Every thread of the workgroup must call it.
void LoadSharedRays(ivec2 texel) {
    first = texel - ivec2(gl_LocalInvocationID.xy) - REACH;
    for (int i = int(gl_LocalInvocationIndex); i < ROOM * ROOM; i += GROUP_SIDE * GROUP_SIDE)
        loaded[i] = LoadGatheredRay(first + ivec2(i % ROOM, i / ROOM));
    barrier();
}

// The value of another texel of the block, rounded as in fragment programs (exchanged_rays.glsl): a texel adds the
// rounded difference of the two values to its own value. `outward` is the asking texel's direction out of the block.
vec4 ValueFromNeighbour(vec4 own, vec4 other, int outward) {
    precise vec4 difference = outward > 0 ? own - other : other - own;
    precise vec4 handed = own - float(outward) * difference;
    return handed;
}

NeighbourRay RayFromNeighbour(NeighbourRay own, NeighbourRay other, int outward) {
    return NeighbourRay(ValueFromNeighbour(own.key, other.key, outward), ValueFromNeighbour(own.color, other.color, outward));
}

#endif
