#version 460
#pragma program(MirrorCompute)
// What a mirror pixel shows, a thread a pixel, over tiles or over the whole image.

#include "unified/groups.glsl"
#include "unified/mirror.glsl"

layout(constant_id = 7) const bool BESIDE = false; // the reflection is wanted beside what is shown

layout(binding = 11, rgba16f) uniform writeonly image2D color_image;      // the composite, or the reflection
layout(binding = 12, rgba16f) uniform writeonly image2D reflection_image; // any image without BESIDE
layout(binding = 13, rgba32f) uniform writeonly image2D hits_image;       // any image without HITS

void main() {
    ivec2 pixel;
    Shown shown;
    if (!ThreadTexel(MIRROR_LIST, 0, pixel) || !IsInside(pixel, 0) || !Show(pixel, shown))
        return;
    imageStore(color_image, pixel, shown.color);
    if (BESIDE)
        imageStore(reflection_image, pixel, shown.reflection);
    if (HITS)
        imageStore(hits_image, pixel, shown.hit);
}
