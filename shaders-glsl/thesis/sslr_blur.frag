#version 460
#pragma program(SslrBlur)
#pragma in_either_stage
// `sslr`, stage 2: blurs one level of both chains in one direction (thesis 4.3.2). The chains are the ray trace colour,
// weighted by the mask, and the mask itself.

#include "common/either_stage.glsl"
#include "thesis/gaussian_blur.glsl"

layout(binding = 0) uniform sampler2D tex;  // ray trace colour, the level below or the horizontal result
layout(binding = 1) uniform sampler2D mask; // the same of the mask

layout(push_constant) uniform BlurBlock {
    vec2 invSize;   // 1 / size of the level that is written
    vec2 direction; // (invTexWidth, 0) or (0, invTexHeight)
} blur;

OUTPUT(0, rgba32f, vec4, color);
OUTPUT(1, r8, float, coarseMask);

vec4 central;

float Mask(vec2 texCoord) {
    return textureLod(mask, texCoord, 0.0).r;
}

// "If a 'miss' is read from the mask buffer (i.e. the value zero), then always the central pixel is used."
vec4 Color(vec2 texCoord) {
    return Mask(texCoord) > 0.0 ? textureLod(tex, texCoord, 0.0) : central;
}

SHADE_ALL(color, STORE(coarseMask)) {
    vec2 texCoord = PIXEL_CENTRE * blur.invSize;
    central = textureLod(tex, texCoord, 0.0);
    color = GAUSSIAN_BLUR(Color, texCoord, blur.direction);
    coarseMask = GAUSSIAN_BLUR(Mask, texCoord, blur.direction);
}
