// The image of where glossy rays ended, for a history. It has an end in each pixel with a narrow lobe, and in the first
// pixel of each cell of 2 x 2 pixels with a wide lobe. The passes that trace or follow rays (captures/finish.glsl)
// write the image, and history/history.glsl reads it.

#ifndef UNIFIED_ENDS_GLSL
#define UNIFIED_ENDS_GLSL

layout(constant_id = 13) const bool STORES_ENDS = false; // the ends are wanted

// The ray's length in units of ViewPoint, as bits of a float, and the triangle that it met (PackRayEnd); 0 for a miss.
layout(binding = 13, rg32ui) uniform writeonly uimage2D ends_image; // without STORES_ENDS, any image of this format is bound

void StoreRayEnd(ivec2 pixel, uvec2 ray_end) {
    if (STORES_ENDS)
        imageStore(ends_image, pixel, uvec4(ray_end, 0u, 0u));
}

#endif
