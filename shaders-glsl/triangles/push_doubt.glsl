// Puts a pixel on the list of those that get rays of their own.

#ifndef TRIANGLES_PUSH_DOUBT_GLSL
#define TRIANGLES_PUSH_DOUBT_GLSL

#include "captures/next_place.glsl"
#include "triangles/doubt.glsl"

void PushDoubt(Doubt doubt) {
    uint place = NextPlace(PixelsToAGroup());
    if (place < uint(doubts.pixels.length()))
        doubts.pixels[place] = PackDoubt(doubt);
}

#endif
