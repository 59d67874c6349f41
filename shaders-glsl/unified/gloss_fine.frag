#version 460
// A ray a pixel for mirrors and narrow lobes: four directions, one a pixel of a 2 x 2 block.

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
    if (!(material.r > REFLECTS_ABOVE) || material.g > COARSE_ABOVE || !(texelFetch(pyramid, pixel, 0).r > 0.0))
        return;
    // Hammersley's four points, neighbours far apart.
    int i = ((pixel.x ^ pixel.y) & 1) * 2 + (pixel.y & 1);
    vec2 u = vec2((float(i) + 0.5) * 0.25, (float((i & 1) * 2 + (i >> 1)) + 0.5) * 0.25);
    Seen seen = Look(pixel, material.g, vec2(u.x * PART, u.y), 0.25);
    out_place = seen.place;
    out_color = seen.color;
}
