// Stores the pixels that compute programs show (mirror.comp, resolve/narrow.comp, resolve/wide.comp).

#ifndef UNIFIED_STORE_GLSL
#define UNIFIED_STORE_GLSL

layout(constant_id = 7) const bool BESIDE = false; // the reflection is wanted beside what is shown

layout(binding = 11, rgba16f) uniform writeonly image2D color_image;      // the composite, or the reflection
layout(binding = 12, rgba16f) uniform writeonly image2D reflection_image; // without BESIDE, any image of this format

void StorePixel(ivec2 pixel, vec4 color, vec4 reflection) {
    imageStore(color_image, pixel, color);
    if (BESIDE)
        imageStore(reflection_image, pixel, reflection);
}

#endif
