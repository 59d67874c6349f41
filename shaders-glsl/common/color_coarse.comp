#version 460
#pragma program(ColorCoarse)
// Makes the seven coarsest levels of the colour chain in one dispatch, each as a linear blit of the level below. These
// levels are small: one workgroup makes them all, so that its barriers replace seven commands with a barrier each.

layout(local_size_x = 256) in;

#include "common/linear_blit.glsl"

layout(binding = 0, rgba16f) uniform readonly image2D level_0; // the given level; a side of level 1 has at most 127 texels
layout(binding = 1, rgba16f) uniform coherent image2D level_1;
layout(binding = 2, rgba16f) uniform coherent image2D level_2;
layout(binding = 3, rgba16f) uniform coherent image2D level_3;
layout(binding = 4, rgba16f) uniform coherent image2D level_4;
layout(binding = 5, rgba16f) uniform coherent image2D level_5;
layout(binding = 6, rgba16f) uniform coherent image2D level_6;
layout(binding = 7, rgba16f) uniform writeonly image2D level_7;

// Makes the image `level` from the next finer image `below`. (An array of images would need a feature that not every
// device has.)
#define MAKE(level, below) \
    { \
        ivec2 size = imageSize(level), below_size = imageSize(below); \
        for (int i = int(gl_LocalInvocationIndex); i < size.x * size.y; i += int(gl_WorkGroupSize.x)) { \
            ivec2 texel = ivec2(i % size.x, i / size.x); \
            BilinearTexels corners = FindBilinearTexels(texel, size, below_size); \
            vec4 a = imageLoad(below, corners.low), b = imageLoad(below, ivec2(corners.high.x, corners.low.y)); \
            vec4 c = imageLoad(below, ivec2(corners.low.x, corners.high.y)), d = imageLoad(below, corners.high); \
            imageStore(level, texel, MixBilinear(corners, a, b, c, d)); \
        } \
        memoryBarrierImage(); \
        barrier(); \
    }

void main() {
    MAKE(level_1, level_0)
    MAKE(level_2, level_1)
    MAKE(level_3, level_2)
    MAKE(level_4, level_3)
    MAKE(level_5, level_4)
    MAKE(level_6, level_5)
    MAKE(level_7, level_6)
}
