// The length of a list that passes fill, and the arguments of an indirect dispatch over the list. The entries are lost
// rays (lost.glsl), or pixels in doubt, which get rays of their own (triangles/doubt.glsl).

#ifndef CAPTURES_COUNTS_GLSL
#define CAPTURES_COUNTS_GLSL

layout(std430, binding = 18) LIST_ACCESS buffer LostCounts {
    uint groups[3]; // the arguments of the dispatch
    uint count;
} lost_counts;

#endif
