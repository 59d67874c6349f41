#version 460
#pragma program(PlanarLookup)
#pragma in_either_stage
// Uses the render target of the mirrored scene as a texture on the mirror (thesis 3.1.2, second method). A pixel reads
// the texel at its own position, since the mirrored camera sees there what the pixel reflects. Where this camera saw
// nothing, the ray escaped, which is a miss.

#include "common/either_stage.glsl"
#include "planar/plane.glsl"

layout(binding = 3) uniform sampler2D mirrored_depth; // reversed
layout(binding = 4) uniform sampler2D mirrored_color;

OUTPUT(0, rgba16f, vec4, out_reflection);

SHADE(out_reflection) {
    ivec2 pixel = ivec2(PIXEL_CENTRE);
    if (!OnPlane(pixel) || texelFetch(mirrored_depth, pixel, 0).r <= 0.0)
        DISCARD;
    out_reflection = vec4(texelFetch(mirrored_color, pixel, 0).rgb, 1.0);
}
