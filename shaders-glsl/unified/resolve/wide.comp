#version 460
#pragma program(ResolveWide)
// The reflections of pixels with wide lobes, a thread a pixel, over tiles or over the whole image.

#include "unified/groups.glsl"
#include "unified/resolve/wide.glsl"
#include "unified/store.glsl"

void main() {
    ivec2 pixel;
    if (!ThreadTexel(WIDE_LIST, 0, pixel))
        return;
    PixelOutput result;
    if (!IsInside(pixel, 0) || !ShadePixel(pixel, result))
        return;
    StorePixel(pixel, result.color, result.reflection);
}
