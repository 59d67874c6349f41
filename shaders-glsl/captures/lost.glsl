// The list of rays that the screen lost: what the passes that trace the screen write, and what captures/follow.comp and
// triangles/follow.comp read.

#ifndef CAPTURES_LOST_GLSL
#define CAPTURES_LOST_GLSL

#include "captures/captures.glsl"

// A ray from where the screen lost it.
struct LostRay {
    vec3 start;     // relative to the eye, world axes, metres
    float before;   // metres that its footprint has widened up to the start
    vec3 direction; // unit, world axes
    float spread;   // width of its footprint for each metre
    uvec4 pixel;    // or cell that it is of: x, y; z: the triangle that it begins on, or NO_TRIANGLE; w unused
};

layout(std430, binding = 18) LOST_ACCESS buffer LostCounts {
    uint groups[3]; // the arguments of an indirect dispatch: a workgroup for LOST_GROUP rays
    uint count;
} lost_counts;

layout(std430, binding = 19) LOST_ACCESS buffer LostRays {
    LostRay rays[];
} lost;

#endif
