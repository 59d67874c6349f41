// Makes colours of any G-buffer fit to be summed and stored in 16 bits: NaN and negative values become 0, and infinity
// the greatest number. A comparison with NaN is false, and a compiler may not remove it, as it may remove isnan.

#ifndef COMMON_SOUND_GLSL
#define COMMON_SOUND_GLSL

#include "common/constants.glsl"

// Makes NaN and negative values 0, and clamps the rest to the greatest 16-bit float.
float Sound(float v) {
    return v > 0.0 ? min(v, GREATEST_HALF) : 0.0;
}

vec3 Sound(vec3 color) {
    return vec3(Sound(color.r), Sound(color.g), Sound(color.b));
}

// Makes NaN 0, and clamps a value to what fits into 16 bits. Negative values stay, though they are no light.
float Finite(float v) {
    return abs(v) <= GREATEST_HALF ? v : v > 0.0 ? GREATEST_HALF : v < 0.0 ? -GREATEST_HALF : 0.0;
}

vec3 Finite(vec3 color) {
    return vec3(Finite(color.r), Finite(color.g), Finite(color.b));
}

#endif
