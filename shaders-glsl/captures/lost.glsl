// The list of lost rays. The passes that trace the screen write the list, and captures/follow.comp and
// triangles/follow.comp read it.

#ifndef CAPTURES_LOST_GLSL
#define CAPTURES_LOST_GLSL

#include "captures/captures.glsl"
#include "captures/counts.glsl"

// The resources of every program that writes or reads the list.
#pragma group(LostRayResources, captures, environment, lost_counts, lost)

// A lost ray, from the place where the screen lost it.
struct LostRay {
    vec3 start;     // relative to the eye, world axes, metres
    float before;   // metres over which its footprint widened before the start
    vec3 direction; // unit, world axes
    float spread;   // width of its footprint for each metre
    uvec4 pixel;    // x, y: the pixel or cell that it belongs to; z: the triangle that it begins on, or NO_TRIANGLE; w unused
};

layout(std430, binding = 19) LIST_ACCESS buffer LostRays {
    LostRay rays[];
} lost;

#endif
