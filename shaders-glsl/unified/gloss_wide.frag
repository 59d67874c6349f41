#version 460
// A ray for a cell of 2 x 2 pixels with wide lobes: thirteen directions. (A compute shader whose
// threads were ordered so that rays of one direction walk together took a fifth longer: what rays read
// of the pyramid lies together where they begin, not where they point.)

#include "unified/parameters.glsl"
#include "unified/gloss_trace.glsl"

layout(binding = 5) uniform sampler2D depth_buffer; // reversed

layout(location = 0) out vec4 out_place;
layout(location = 1) out vec4 out_color;

#include "unified/gloss_cell.glsl"

void main() {
    ivec2 cell = ivec2(gl_FragCoord.xy);
    float roughness;
    ivec2 pixel = WidePixel(cell, roughness);
    Seen seen = Seen(vec4(0.0), vec4(0.0));
    if (roughness > 0.0)
        seen = Look(pixel, roughness, LatticePoint((cell.x + 5 * cell.y) % 13, 8, 13), 1.0 / 13.0);
    out_place = seen.place;
    out_color = seen.color;
}
