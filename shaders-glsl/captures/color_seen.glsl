// The sky that a ray sees where the screen shows sky.

#ifndef CAPTURES_COLOR_SEEN_GLSL
#define CAPTURES_COLOR_SEEN_GLSL

#include "captures/captures.glsl"

// The sky along a ray.
vec3 SkyAlong(vec3 direction) {
    return Sky(ToWorld(direction));
}

#endif
