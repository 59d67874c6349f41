// How many entries a list has that passes fill for an indirect dispatch over it: rays that the screen lost (lost.glsl), or
// pixels that get rays of their own (triangles/doubt.glsl).

#ifndef CAPTURES_COUNTS_GLSL
#define CAPTURES_COUNTS_GLSL

layout(std430, binding = 18) LIST_ACCESS buffer LostCounts {
    uint groups[3]; // the arguments of the dispatch
    uint count;
} lost_counts;

#endif
