#version 460
// A ray a pixel for mirrors and narrow lobes: five directions.

#include "unified/parameters.glsl"
#include "unified/gloss_trace.glsl"

layout(location = 0) out vec4 out_place;
layout(location = 1) out vec4 out_color;

// The pattern covers the inner part of the lobe; each ray's footprint reaches into the rest.
#define PART 0.5

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    out_place = vec4(0.0);
    out_color = vec4(0.0);
    vec2 material = texelFetch(material_buffer, pixel, 0).rg;
    if (!(material.r > REFLECTS_ABOVE) || material.g > WIDE_ABOVE || !(imageLoad(pyramid, pixel).r > 0.0))
        return;
    vec2 u = LatticePoint((pixel.x + 2 * pixel.y) % 5, 2, 5);
    Seen seen = Look(pixel, material.g, vec2(u.x * PART, u.y), 0.2);
    out_place = seen.place;
    out_color = seen.color;
}
