#version 460
#pragma program(Depth)
#pragma in_either_stage
#pragma in_either_stage(MINIMUM)
// Writes level 0 of the Hi-Z buffer, the post-projected depth (thesis 4.2.1): standard depth from the G-buffer's reversed
// depth (docs/definitions.md, "Spaces"), as minimum, and as maximum if that is kept.

#include "common/either_stage.glsl"

// The format of the chain in compute shaders: of two channels, or with MINIMUM of one.
#ifdef MINIMUM
#define OUTPUT_FORMAT r32f
#else
#define OUTPUT_FORMAT rg32f
#endif

layout(binding = 0) uniform sampler2D depth_buffer;

OUTPUT(0, OUTPUT_FORMAT, vec2, min_max);

SHADE(min_max) {
    min_max = vec2(1.0 - texelFetch(depth_buffer, ivec2(PIXEL_CENTRE), 0).r);
}
