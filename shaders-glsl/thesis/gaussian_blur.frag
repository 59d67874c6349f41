#version 460
#pragma program(GaussianBlur)
// The Gaussian of thesis 4.3.2, which 4.2.6 names as the alternative to the hardware's mip chain. One
// direction; the horizontal pass also halves the level, as its bilinear taps lie at the coarse
// level's texel centres.

#include "thesis/gaussian_blur.glsl"

layout(binding = 0) uniform sampler2D tex; // the level below (horizontal), or the horizontal result

layout(push_constant) uniform BlurBlock {
    vec2 invSize;   // 1 / size of the level that is written
    vec2 direction; // (invTexWidth, 0) or (0, invTexHeight)
} blur;

layout(location = 0) out vec4 color;

vec4 Color(vec2 texCoord) {
    return textureLod(tex, texCoord, 0.0);
}

void main() {
    color = GAUSSIAN_BLUR(Color, gl_FragCoord.xy * blur.invSize, blur.direction);
}
