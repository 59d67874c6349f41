#version 460
#pragma program(PlanarCopy)
#pragma in_either_stage
// Copies what was drawn of the mirrored scene inside the stencil pattern (thesis 3.1.2, first method, step 4). Outside
// of the pattern nothing was drawn.

#include "common/either_stage.glsl"

layout(binding = 0) uniform sampler2D mirrored_depth; // reversed
layout(binding = 1) uniform sampler2D mirrored_color;

OUTPUT(0, rgba16f, vec4, out_reflection);

SHADE(out_reflection) {
    ivec2 pixel = ivec2(PIXEL_CENTRE);
    if (texelFetch(mirrored_depth, pixel, 0).r <= 0.0)
        DISCARD;
    out_reflection = vec4(texelFetch(mirrored_color, pixel, 0).rgb, 1.0);
}
