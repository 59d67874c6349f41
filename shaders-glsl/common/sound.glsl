// Makes colours of any G-buffer fit to be summed and stored in 16 bits: NaN and negative values become 0, and infinity
// the greatest number. A comparison with NaN is false, and a compiler may not remove it, as it may remove isnan.

#ifndef COMMON_SOUND_GLSL
#define COMMON_SOUND_GLSL

#include "common/constants.glsl"

float Sound(float v) {
    return v > 0.0 ? min(v, GREATEST_HALF) : 0.0;
}

vec3 Sound(vec3 color) {
    return vec3(Sound(color.r), Sound(color.g), Sound(color.b));
}

// Keeps negative values, which are no light either but fit into 16 bits.
float Finite(float v) {
    return abs(v) <= GREATEST_HALF ? v : v > 0.0 ? GREATEST_HALF : v < 0.0 ? -GREATEST_HALF : 0.0;
}

vec3 Finite(vec3 color) {
    return vec3(Finite(color.r), Finite(color.g), Finite(color.b));
}

#endif
