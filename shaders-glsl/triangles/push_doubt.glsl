// Puts a pixel on the list of those that get rays of their own.

#ifndef TRIANGLES_PUSH_DOUBT_GLSL
#define TRIANGLES_PUSH_DOUBT_GLSL

#define DOUBT_ACCESS
#include "triangles/doubt.glsl"

void PushDoubt(Doubt doubt) {
    uint index = atomicAdd(doubt_counts.count, 1u);
    if (index % PixelsToAGroup() == 0u)
        atomicAdd(doubt_counts.groups[0], 1u);
    if (index == 0u) {
        doubt_counts.groups[1] = 1u;
        doubt_counts.groups[2] = 1u;
    }
    if (index < uint(doubts.pixels.length()))
        doubts.pixels[index] = PackDoubt(doubt);
}

#endif
