#version 460
#pragma program(Mirror: Screen)
#pragma program(Mirror: Confirmed, CONFIRMED)
#pragma program(Mirror: Tree, AMONG_TRIANGLES)
#pragma program(Mirror: Query, AMONG_TRIANGLES, RAY_QUERY)
// Shades mirror pixels, a thread a pixel, over tiles or over the whole image.

#ifdef RAY_QUERY
#extension GL_EXT_ray_query : require
#endif

#include "unified/groups.glsl"
#include "unified/trace/mirror.glsl"
#include "unified/store.glsl"

layout(binding = 13, rgba32f) uniform writeonly image2D hits_image; // without HITS, any image of this format

void main() {
    ivec2 pixel;
    PixelOutput result;
    if (!ThreadTexel(MIRROR_LIST, 0, pixel) || !IsInside(pixel, 0) || !ShadePixel(pixel, result))
        return;
    StorePixel(pixel, result.color, result.reflection);
    if (HITS)
        imageStore(hits_image, pixel, result.hit);
}
