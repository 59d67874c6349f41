#version 460
#pragma program(ColorFirst)
// Level 1 of the colour chain, if the sky is kept apart from the lit colour: a linear blit of level 0 in which sky is
// black. A texel then holds the weighted sum of the lit colours, and in alpha the part that is lit. For the other part,
// readers add the sky along their own ray.

layout(local_size_x = 8, local_size_y = 8) in;

#include "common/linear_blit.glsl"

layout(binding = 0, rgba16f) uniform readonly image2D finest; // a is 0 where sky is, else 1
layout(binding = 1, rgba16f) uniform writeonly image2D coarser;

vec4 LoadWithoutSky(ivec2 pixel) {
    vec4 color = imageLoad(finest, pixel);
    return color.a == 0.0 ? vec4(0.0) : color;
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(coarser);
    if (any(greaterThanEqual(texel, size)))
        return;
    BilinearTexels corners = FindBilinearTexels(texel, size, imageSize(finest));
    vec4 a = LoadWithoutSky(corners.low), b = LoadWithoutSky(ivec2(corners.high.x, corners.low.y));
    vec4 c = LoadWithoutSky(ivec2(corners.low.x, corners.high.y)), d = LoadWithoutSky(corners.high);
    imageStore(coarser, texel, MixBilinear(corners, a, b, c, d));
}
