#version 460
#pragma program(SslrBlur)
// `sslr`: one direction of one level of both chains (thesis 4.3.2): the ray trace colour, weighted by
// the mask, and the mask itself.

#include "thesis/gaussian_blur.glsl"

layout(binding = 0) uniform sampler2D tex;  // ray trace colour, the level below or the horizontal result
layout(binding = 1) uniform sampler2D mask; // the same of the mask

layout(push_constant) uniform BlurBlock {
    vec2 invSize;   // 1 / size of the level that is written
    vec2 direction; // (invTexWidth, 0) or (0, invTexHeight)
} blur;

layout(location = 0) out vec4 color;
layout(location = 1) out float coarseMask;

vec4 central;

float Mask(vec2 texCoord) {
    return textureLod(mask, texCoord, 0.0).r;
}

// "If a 'miss' is read from the mask buffer (i.e. the value zero), then always the central pixel is used."
vec4 Color(vec2 texCoord) {
    return Mask(texCoord) > 0.0 ? textureLod(tex, texCoord, 0.0) : central;
}

void main() {
    vec2 texCoord = gl_FragCoord.xy * blur.invSize;
    central = textureLod(tex, texCoord, 0.0);
    color = GAUSSIAN_BLUR(Color, texCoord, blur.direction);
    coarseMask = GAUSSIAN_BLUR(Mask, texCoord, blur.direction);
}
