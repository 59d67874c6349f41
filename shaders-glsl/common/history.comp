#version 460
#pragma program(HistoryCompute)
// The average of reflections over frames, a thread a pixel. The pixels of a block of 2 x 2 are of one workgroup.

#include "common/history.glsl"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;

layout(binding = 11, rgba16f) uniform writeonly image2D reflection_image;
layout(binding = 12, rgba32ui) uniform writeonly uimage2D guide_image;
layout(binding = 13, rgba16f) uniform writeonly image2D color_image; // any image of this format without COMPOSITE

shared Block blocks[GROUP_SIDE * GROUP_SIDE];

// The sum of a value and its neighbour's, rounded as fragment shaders sum by differences (history.frag).
vec4 Both(vec4 own, vec4 other, float outward) {
    precise vec4 difference = outward > 0.0 ? own - other : other - own;
    precise vec4 sum = own + (own - outward * difference);
    return sum;
}

Block WithNeighbour(Block own, int beside, float outward) {
    int at = int(gl_LocalInvocationIndex);
    blocks[at] = own;
    barrier();
    Block other = blocks[at - int(outward) * beside];
    barrier();
    vec4 count = Both(vec4(own.count), vec4(other.count), outward);
    return Block(Both(own.ends, other.ends, outward), Both(own.movers, other.movers, outward),
        Both(own.sum, other.sum, outward), Both(own.squares, other.squares, outward), count.x);
}

Block OverBlock(ivec2 pixel, Block own) {
    vec2 outward = OutwardOf(pixel);
    return WithNeighbour(WithNeighbour(own, 1, outward.x), GROUP_SIDE, outward.y);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    Averaged averaged = Average(pixel);
    if (any(greaterThanEqual(pixel, ivec2(history.resolution))))
        return;
    imageStore(reflection_image, pixel, averaged.reflection);
    imageStore(guide_image, pixel, averaged.guide);
    if (COMPOSITE)
        imageStore(color_image, pixel, averaged.color);
}
