#version 460
// A ray a pixel for narrow lobes: five directions. (One for two pixels, over a chequerboard, takes 0.7 of
// the time; the error is 1.5 times as large, and a third more changes under a moving camera.)

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
    bool narrow = Reflects(material) && ListOf(material) == NARROW_LIST;
    if (!narrow || !(imageLoad(pyramid, pixel).r > 0.0))
        return;
    vec2 u = LatticePoint((pixel.x + 2 * pixel.y) % 5, 2, 5, vec2(0.5));
    Seen seen = Look(pixel, material.g, vec2(u.x * PART, u.y), 5.0, 1, 1.0);
    out_place = seen.place;
    out_color = seen.color;
}
