#version 460
#pragma program(SslrReflection)
#pragma in_either_stage
// `sslr`, stage 3: the reflection from the mip level that roughness and ray length ask for (thesis 4.3.3, the listing).

#include "common/either_stage.glsl"

layout(binding = 0) uniform sampler2D rayTraceColorBuffer; // blurred, trilinear; a: ray length
layout(binding = 1) uniform sampler2D maskBuffer;
layout(binding = 2) uniform sampler2D materialBuffer;      // reflectivity, roughness

layout(push_constant) uniform SslrReflectionBlock {
    vec2 resolution;       // pixels
    float mipCount;        // levels of the chain
    float spreadingFactor; // 1 in print
} sslr;

OUTPUT(0, rgba16f, vec4, out_reflection); // colour; a: 1 where a ray hit

// Print: §4.3.3, listing.
SHADE(out_reflection) {
    vec2 texCoord = PIXEL_CENTRE / sslr.resolution;
    float roughness = texelFetch(materialBuffer, ivec2(PIXEL_CENTRE), 0).g;

    // 1-3: Determine MIP lod for reflection color
    // Departure: times a factor, which is 1 as published (--spreading-factor).
    float spreading = textureLod(rayTraceColorBuffer, texCoord, 0.0).a * sslr.spreadingFactor;
    float mipLod = sslr.mipCount * roughness * spreading;

    // 5-7: Sample final scene- and ray-trace colors
    // Departure: line 6, the scene's colour, is the composite's.
    vec3 rayTraceColor = textureLod(rayTraceColorBuffer, texCoord, mipLod).rgb;

    // 9, 10: Add reflection color times 'reflectivity' factor
    // Departure: the composite adds it. A miss has length 0 and reads its own black pixel, but for the rounding of the
    // filter's weights.
    bool hit = texelFetch(maskBuffer, ivec2(PIXEL_CENTRE), 0).r > 0.0;
    out_reflection = hit ? vec4(rayTraceColor, 1.0) : vec4(0.0);
}
