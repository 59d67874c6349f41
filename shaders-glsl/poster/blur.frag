#version 460
#pragma program(PosterBlurAcross, ACROSS)
#pragma program(PosterBlurDown)
#pragma in_either_stage
// Blurs one slice of the volumes in one direction, by a Gaussian of depth, normal and colour at once. With ACROSS it
// reads a slice and writes plain images; without ACROSS it reads these images and writes the next slice. Taps are those
// of thesis 4.3.2, `blur.direction` apart.

#if defined(COMPUTE) && !defined(ACROSS)
#define OUTPUT_IMAGE image3D
#define OUTPUT_TEXEL ivec3(ivec2(gl_GlobalInvocationID.xy), blur.into)
#endif

#include "common/either_stage.glsl"
#include "thesis/gaussian_blur.glsl"

layout(push_constant) uniform PosterBlurBlock {
    vec2 inverse_size; // 1 / pixels
    vec2 direction;    // from tap to tap, in texture coordinates
    float slice;       // texture coordinate of the slice that is read
    int into;          // the slice that is written
} blur;

#ifdef ACROSS
#define SOURCE sampler3D
#define READ(name, texCoord) textureLod(name, vec3(texCoord, blur.slice), 0.0)
#else
#define SOURCE sampler2D
#define READ(name, texCoord) textureLod(name, texCoord, 0.0)
#endif

layout(binding = 0) uniform SOURCE depth_source;
layout(binding = 1) uniform SOURCE normal_source;
layout(binding = 2) uniform SOURCE color_source;

OUTPUT(0, r32f, float, out_depth);
OUTPUT(1, rgba16f, vec4, out_normal);
OUTPUT(2, rgba16f, vec4, out_color);

float Depth(vec2 texCoord) {
    return READ(depth_source, texCoord).r;
}

vec4 Normal(vec2 texCoord) {
    return READ(normal_source, texCoord);
}

vec4 Color(vec2 texCoord) {
    return READ(color_source, texCoord);
}

SHADE_ALL(out_depth, STORE(out_normal) STORE(out_color)) {
    vec2 texCoord = PIXEL_CENTRE * blur.inverse_size;
    out_depth = GAUSSIAN_BLUR(Depth, texCoord, blur.direction);
    out_normal = GAUSSIAN_BLUR(Normal, texCoord, blur.direction);
    out_color = GAUSSIAN_BLUR(Color, texCoord, blur.direction);
}
