#version 460
#pragma program(History)
// The average of reflections over frames, a thread a pixel. The pixels of a block of 2 x 2 belong to one workgroup.

// Unrolled, the search would need more registers than a GPU has for enough waves.
#define SEARCH_LOOP [[dont_unroll]]

#include "history/history.glsl"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;

layout(binding = 11, rgba16f) uniform writeonly image2D reflection_image;
layout(binding = 12, rgba32ui) uniform writeonly uimage2D guide_image;
layout(binding = 13, rgba16f) uniform writeonly image2D color_image; // without COMPOSITE, any image of this format

shared BlockSums sums[GROUP_SIDE * GROUP_SIDE];

// The sum of a pixel's value and its neighbour's, rounded as in fragment shaders, which sum by differences
// (history.frag). `outward` is the pixel's direction out of the block, 1 or -1.
vec4 AddNeighbour(vec4 own, vec4 other, float outward) {
    precise vec4 difference = outward > 0.0 ? own - other : other - own;
    precise vec4 sum = own + (own - outward * difference);
    return sum;
}

// Adds the sums of the block's other pixel along an axis, whose thread is `offset` threads away. Every thread must call
// this function.
BlockSums AddNeighbourSums(BlockSums own, int offset, float outward) {
    int index = int(gl_LocalInvocationIndex);
    sums[index] = own;
    barrier();
    BlockSums other = sums[index - int(outward) * offset];
    barrier();
    return BlockSums(AddNeighbour(own.first, other.first, outward), AddNeighbour(own.second, other.second, outward));
}

// The sums over the four pixels of a block, by memory that threads share.
BlockSums SumOverBlock(ivec2 pixel, BlockSums own) {
    vec2 outward = DirectionOutOfBlock(pixel);
    return AddNeighbourSums(AddNeighbourSums(own, 1, outward.x), GROUP_SIDE, outward.y);
}

// Keeps values in shared memory for ReloadValues. The barriers keep a compiler from holding the values in registers
// after all. No other thread reads these values.
void SpillValues(BlockSums values) {
    sums[gl_LocalInvocationIndex] = values;
    memoryBarrierShared();
}

BlockSums ReloadValues() {
    memoryBarrierShared();
    return sums[gl_LocalInvocationIndex];
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    AccumulatedPixel accumulated = AccumulatePixel(pixel);
    if (any(greaterThanEqual(pixel, history.size)))
        return;
    imageStore(reflection_image, pixel, accumulated.reflection);
    imageStore(guide_image, pixel, accumulated.guide);
    if (COMPOSITE)
        imageStore(color_image, pixel, accumulated.color);
}
