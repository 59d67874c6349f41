#version 460
#pragma program(HiZ)
#pragma in_either_stage
#pragma in_either_stage(MINIMUM)
// Hi-Z buffer generation: one level from the level below (thesis 4.2.4, Alg. 3, Eq. 4.1). If the target has a second
// channel, the maximum is kept beside the minimum, as in the author's program.

#include "common/either_stage.glsl"

// The format of the chain in compute shaders: of two channels, or with MINIMUM of one.
#ifdef MINIMUM
#define OUTPUT_FORMAT r32f
#else
#define OUTPUT_FORMAT rg32f
#endif

layout(binding = 0) uniform sampler2D Tex; // the level below, as a view of one level

layout(push_constant) uniform HiZBlock {
    ivec2 Offset; // Eq. 4.1: 1 where the level below has an even side, else 2
} hiz;

OUTPUT(0, OUTPUT_FORMAT, vec2, z_min_max); // g is lost in a target of one channel

vec2 ReadDepth(ivec2 p) {
    // Departure: the level below may be one texel wide, and a fetch outside an image has no
    // defined value in Vulkan; the thesis does not clamp.
    return texelFetch(Tex, min(p, textureSize(Tex, 0) - 1), 0).rg;
}

// Print: §4.2.4, Alg. 3.
// 1: HiZPixelShader(Tex, P_pixel, Offset); Input parameters for the Hi-Z pixel shader
SHADE(z_min_max) {
    // 2: P_sample <- P_pixel * 2; Sample position is twice the pixel coordinate
    ivec2 P_sample = ivec2(PIXEL_CENTRE) * 2;
    // 3: z_0 <- ReadDepth(Tex, P_sample + (0, 0))
    vec2 z0 = ReadDepth(P_sample + ivec2(0, 0));
    // 4: z_1 <- ReadDepth(Tex, P_sample + (Offset_x, 0))
    // Erratum, kept: an Offset of 2 skips a texel of an odd side.
    vec2 z1 = ReadDepth(P_sample + ivec2(hiz.Offset.x, 0));
    // 5: z_2 <- ReadDepth(Tex, P_sample + (0, Offset_y))
    vec2 z2 = ReadDepth(P_sample + ivec2(0, hiz.Offset.y));
    // 6: z_3 <- ReadDepth(Tex, P_sample + (Offset_x, Offset_y))
    vec2 z3 = ReadDepth(P_sample + ivec2(hiz.Offset.x, hiz.Offset.y));
    // 7: z_min <- min {z_0, z_1, z_2, z_3}; Write z_min to the pixel output
    float z_min = min(min(z0.r, z1.r), min(z2.r, z3.r));
    float z_max = max(max(z0.g, z1.g), max(z2.g, z3.g));
    z_min_max = vec2(z_min, z_max);
}
