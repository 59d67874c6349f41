#version 460
#pragma program(GaussianBlur)
#pragma program(GaussianBlurMasked, MASKED)
#pragma in_either_stage
// Blurs a level of the colour chain in one direction by the Gaussian of thesis 4.3.2, which 4.2.6 names as the
// alternative to the hardware's mip chain. The horizontal pass also halves the level, as its bilinear taps lie at the
// texel centres of the coarse level. MASKED is what chapter 6 proposes: "a mask buffer in the blur pass for the color
// buffer". The mask is read from the Hi-Z buffer, at the level that is written, whose texels lie where the taps do.

#include "common/either_stage.glsl"
#include "thesis/gaussian_blur.glsl"

layout(binding = 0) uniform sampler2D tex; // the level below (horizontal), or the horizontal result

#ifdef MASKED
layout(binding = 1) uniform sampler2D hiZ; // the level that is written: standard depth, nearest
layout(constant_id = 0) const bool SURFACE = false; // a tap on another surface is masked, not one on none

layout(push_constant) uniform MaskedBlurBlock {
    vec2 invSize;    // 1 / size of the level that is written
    vec2 direction;  // (invTexWidth, 0) or (0, invTexHeight)
    float near;      // near plane, metres
    float far;       // far plane, metres
    float tolerance; // depths of one surface differ by no more than this part of the lesser one
} blur;

vec4 central;
float centralDepth;

float ViewDepth(float depth) {
    return blur.near * blur.far / (blur.far - depth * (blur.far - blur.near));
}

// Whether the tap at a place counts: the mask buffer of 4.3.2.
bool Mask(vec2 texCoord) {
    float depth = textureLod(hiZ, texCoord, 0.0).r;
    if (!SURFACE)
        return depth < 1.0;
    float a = ViewDepth(depth), b = ViewDepth(centralDepth);
    return abs(a - b) <= blur.tolerance * min(a, b);
}

// "If a 'miss' is read from the mask buffer (i.e. the value zero), then always the central pixel is used."
vec4 Color(vec2 texCoord) {
    return Mask(texCoord) ? textureLod(tex, texCoord, 0.0) : central;
}
#else
layout(push_constant) uniform BlurBlock {
    vec2 invSize;   // 1 / size of the level that is written
    vec2 direction; // (invTexWidth, 0) or (0, invTexHeight)
} blur;

vec4 Color(vec2 texCoord) {
    return textureLod(tex, texCoord, 0.0);
}
#endif

OUTPUT(0, rgba16f, vec4, color);

SHADE(color) {
    vec2 texCoord = PIXEL_CENTRE * blur.invSize;
#ifdef MASKED
    central = textureLod(tex, texCoord, 0.0);
    centralDepth = textureLod(hiZ, texCoord, 0.0).r;
#endif
    color = GAUSSIAN_BLUR(Color, texCoord, blur.direction);
}
