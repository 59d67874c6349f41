#version 460
// A ray for a cell of 2 x 2 pixels with wide lobes: thirteen directions. (Threads that follow each other
// trace neighbouring cells. To let those of one direction walk together instead took a fifth longer:
// what rays read of the pyramid lies together where they begin, not where they point.)

layout(local_size_x = 8, local_size_y = 8) in;

#include "unified/parameters.glsl"
#include "unified/gloss_trace.glsl"

layout(binding = 5) uniform sampler2D depth_buffer; // reversed
layout(binding = 6, rgba32f) uniform writeonly image2D place_image;
layout(binding = 7, rgba16f) uniform writeonly image2D seen_image;

#include "unified/gloss_cell.glsl"

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(2 * cell, unified.size)))
        return;
    float roughness;
    ivec2 pixel = WidePixel(cell, roughness);
    Seen seen = Seen(vec4(0.0), vec4(0.0));
    if (roughness > 0.0)
        seen = Look(pixel, roughness, LatticePoint((cell.x + 5 * cell.y) % 13, 8, 13), 1.0 / 13.0);
    imageStore(place_image, cell, seen.place);
    imageStore(seen_image, cell, seen.color);
}
