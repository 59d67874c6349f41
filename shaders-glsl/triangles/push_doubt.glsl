// Puts a pixel on the list of pixels in doubt.

#ifndef TRIANGLES_PUSH_DOUBT_GLSL
#define TRIANGLES_PUSH_DOUBT_GLSL

#include "captures/next_place.glsl"
#include "triangles/doubt.glsl"

void PushDoubt(Doubt doubt) {
    uint index = ReserveListIndex(PixelsPerGroup());
    if (index < uint(doubts.pixels.length()))
        doubts.pixels[index] = PackDoubt(doubt);
}

#endif
