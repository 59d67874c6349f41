// The sky along a ray, and the test whether a texel of the lit colour shows sky.

#ifndef CAPTURES_SKY_ALONG_GLSL
#define CAPTURES_SKY_ALONG_GLSL

#include "captures/captures.glsl"

// The colour of the sky along a direction in view space.
vec3 SampleSkyView(vec3 direction) {
    return SampleSkyWorld(ToWorld(direction));
}

// Whether a texel of the lit colour shows nothing but sky. Always false where sky is not looked up along rays.
bool ShowsSky(vec4 seen) {
    return unified.sky != 0 && seen.a == 0.0;
}

#endif
