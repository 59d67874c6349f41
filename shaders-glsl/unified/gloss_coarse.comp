#version 460
// A ray for 2 x 2 pixels of wide lobes: sixteen directions, one a cell of a 4 x 4 block. A workgroup
// has 16 x 16 cells, and threads that follow each other have the same direction of the pattern: rays
// that run alike walk together.

layout(local_size_x = 256) in;

#include "unified/parameters.glsl"
#include "unified/gloss_trace.glsl"

layout(binding = 5, rgba32f) uniform writeonly image2D place_image;
layout(binding = 6, rgba16f) uniform writeonly image2D seen_image;

void main() {
    int thread = int(gl_LocalInvocationID.x);
    ivec2 in_block = ivec2((thread >> 4) & 3, thread >> 6);
    ivec2 cell = 16 * ivec2(gl_WorkGroupID.xy) + 4 * ivec2(thread & 3, (thread >> 2) & 3) + in_block;
    if (any(greaterThanEqual(2 * cell, unified.size)))
        return;
    Seen seen = Seen(vec4(0.0), vec4(0.0));
    // The cell's first pixel that has a wide lobe.
    ivec2 pixel = 2 * cell;
    float roughness = 0.0;
    for (int i = 3; i >= 0; --i) {
        ivec2 p = min(2 * cell + ivec2(i & 1, i >> 1), unified.size - 1);
        vec2 material = texelFetch(material_buffer, p, 0).rg;
        bool wide = material.r > REFLECTS_ABOVE && material.g > COARSE_ABOVE && texelFetch(pyramid, p, 0).r > 0.0;
        pixel = wide ? p : pixel;
        roughness = wide ? material.g : roughness;
    }
    if (roughness > 0.0) {
        // Hammersley's sixteen points in the order of Bayer's matrix: neighbours far apart.
        ivec2 high = in_block >> 1, low = in_block & 1;
        int i = 8 * (low.x ^ low.y) + 4 * low.y + 2 * (high.x ^ high.y) + high.y;
        int reversed = ((i & 1) << 3) | ((i & 2) << 1) | ((i & 4) >> 1) | (i >> 3);
        seen = Look(pixel, roughness, (vec2(i, reversed) + 0.5) / 16.0, 1.0 / 16.0);
    }
    imageStore(place_image, cell, seen.place);
    imageStore(seen_image, cell, seen.color);
}
