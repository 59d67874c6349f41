#version 460
// A ray for a cell of 2 x 2 pixels with wide lobes: thirteen directions. A workgroup has 13 x 13 cells,
// each direction thirteen times, and threads that follow each other have the same direction: rays that
// run alike walk together.

layout(local_size_x = 169) in;

#include "unified/parameters.glsl"
#include "unified/gloss_trace.glsl"

layout(binding = 5) uniform sampler2D depth_buffer; // reversed
layout(binding = 6, rgba32f) uniform writeonly image2D place_image;
layout(binding = 7, rgba16f) uniform writeonly image2D seen_image;

#include "unified/gloss_cell.glsl"

void main() {
    int index = int(gl_LocalInvocationID.x) / 13, row = int(gl_LocalInvocationID.x) % 13;
    // The column in this row whose direction it is: (x + 5 y) mod 13 = index.
    int column = (index + 8 * row) % 13;
    // Whole tiles of 13, so that the pattern goes on across them.
    ivec2 cell = 13 * ivec2(gl_WorkGroupID.xy) + ivec2(column, row);
    if (any(greaterThanEqual(2 * cell, unified.size)))
        return;
    float roughness;
    ivec2 pixel = WidePixel(cell, roughness);
    Seen seen = Seen(vec4(0.0), vec4(0.0));
    if (roughness > 0.0)
        seen = Look(pixel, roughness, LatticePoint(index, 8, 13), 1.0 / 13.0);
    imageStore(place_image, cell, seen.place);
    imageStore(seen_image, cell, seen.color);
}
