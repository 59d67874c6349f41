// What a G-buffer of any origin holds as a colour, made fit to be summed and stored in 16 bits: NaN and what is negative
// are no light, infinity is the greatest number. A comparison with NaN is false, which no compiler may assume away as it
// may with isnan.

#ifndef COMMON_SOUND_GLSL
#define COMMON_SOUND_GLSL

#include "common/constants.glsl"

float Sound(float v) {
    return v > 0.0 ? min(v, GREATEST_HALF) : 0.0;
}

vec3 Sound(vec3 color) {
    return vec3(Sound(color.r), Sound(color.g), Sound(color.b));
}

// Keeps what is negative, which is no light either, but which 16 bits hold.
float Finite(float v) {
    return abs(v) <= GREATEST_HALF ? v : v > 0.0 ? GREATEST_HALF : v < 0.0 ? -GREATEST_HALF : 0.0;
}

vec3 Finite(vec3 color) {
    return vec3(Finite(color.r), Finite(color.g), Finite(color.b));
}

#endif
