// What a history keeps of each pixel beside its colour, packed into 128 bits.

#ifndef COMMON_HISTORY_GUIDE_GLSL
#define COMMON_HISTORY_GUIDE_GLSL

#include "common/history_inputs.glsl"
#include "common/octahedral.glsl"

// Bounds of a history's Lag: of the length of its mean, in standard deviations of the lobe (1 / sqrt(alpha + 1)), and
// of the mean of its square.
#define MOST_LAG 0.35
#define MOST_SQUARE 0.5

// Steps of a packed age to a frame, and steps of the packed root of a mean square from 0 to the root of MOST_SQUARE.
#define AGE_STEPS 4.0
#define SQUARE_STEPS 63.0

// How far the frames that were averaged point past what is reflected, in standard deviations of the lobe.
struct Lag {
    vec3 mean;
    float square; // the mean of the squared length
};

// What is kept of a pixel.
struct Guide {
    float depth;
    vec3 normal;   // view space, of any length
    float age;     // frames averaged; 0 for no history
    float inverse; // 1 / the distance from the eye over the surface to the reflected point; 0 if this point is not known
    vec2 lag;      // the mean of Lag along the two Tangents of the mirrored direction
    float square;  // Lag.square
};

// Packs a guide. One byte of the mean lag replaces the last byte of the depth, which stays precise enough without it.
// The other byte of the lag is the last byte of the hash. The third word has the age in its lowest 10 bits, the root of
// the mean square in the next 6, and `inverse` as a 16-bit float above them.
uvec4 PackGuide(Guide g, uint hash) {
    uint depth = floatBitsToUint(g.depth) + 128u, lag = packSnorm4x8(vec4(g.lag / MOST_LAG, 0.0, 0.0));
    uint age = uint(min(g.age * AGE_STEPS + 0.5, 1023.0)), square = uint(min(sqrt(g.square / MOST_SQUARE), 1.0) * SQUARE_STEPS + 0.5);
    uint more = packHalf2x16(vec2(0.0, g.inverse)) | square << 10 | age;
    return uvec4((depth & ~255u) | (lag & 255u), packSnorm2x16(EncodeOctahedral(g.normal)), more, hash | (lag >> 8));
}

Guide UnpackGuide(uvec4 words) {
    vec2 lag = MOST_LAG * unpackSnorm4x8((words.x & 255u) | (words.w & 255u) << 8).xy;
    float age = float(words.z & 1023u) / AGE_STEPS, root = float(words.z >> 10 & 63u) / SQUARE_STEPS;
    float depth = uintBitsToFloat(words.x & ~255u), inverse = unpackHalf2x16(words.z).y;
    return Guide(depth, DecodeOctahedralUnnormalized(unpackSnorm2x16(words.y)), age, inverse, lag, MOST_SQUARE * root * root);
}

// A hash of a reflection in the upper 24 bits, by which reflections of two frames are compared; the last byte is zero.
uint ReflectionHash(vec4 reflection) {
    uint first = packHalf2x16(reflection.rg), second = packHalf2x16(reflection.ba);
    return (first * 0x9e3779b1u ^ second * 0x85ebca6bu) & ~255u;
}

// The guide that the frame before kept for a pixel. A pixel beyond the image reads the nearest pixel of the image.
Guide LoadGuide(ivec2 pixel) {
    return UnpackGuide(imageLoad(guide_before, clamp(pixel, ivec2(0), history.size - 1)));
}

#endif
