// Shared by the passes of `stochastic`: its parameters, and the numbers that stand for chance.

#ifndef STOCHASTIC_STOCHASTIC_GLSL
#define STOCHASTIC_STOCHASTIC_GLSL

#include "common/lobe.glsl"
#include "common/sequence.glsl"
#include "unified/view.glsl"

// Filled in by src/methods/stochastic.rs, for each ray of a pixel anew.
layout(push_constant) uniform StochasticBlock {
    int turn;     // number of the ray in the pixel's sequence, which goes on from frame to frame
    float part;   // part of the lobe's distribution that directions are drawn from; 1 is all of it
    float radius; // pixels within which neighbours are gathered
    int gathered; // rays that a pixel gathers of those traced in this turn, its own among them
    int first;    // 1: the first ray of this frame
    int last;     // 1: the last one
} stochastic;

#define TAU 6.2831853

// Interleaved gradient noise (Jimenez 2014): between 0 and 1, and well spread within any 3 x 3 pixels.
float GradientNoise(vec2 pixel) {
    return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715))));
}

// Two numbers between 0 and 1 for a ray of a pixel: a point of the R2 sequence (Roberts 2018), which each pixel shifts
// by other numbers.
vec2 RaySample2D(ivec2 pixel, int turn) {
    vec2 pixel_shift = vec2(GradientNoise(vec2(pixel)), GradientNoise(vec2(pixel.yx) + vec2(47.0, 17.0)));
    return fract(pixel_shift + SequencePoint(turn));
}

#endif
