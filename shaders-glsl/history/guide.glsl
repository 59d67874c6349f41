// The guide of a history, which is packed into 128 bits for each pixel.

#ifndef COMMON_HISTORY_GUIDE_GLSL
#define COMMON_HISTORY_GUIDE_GLSL

#include "history/inputs.glsl"
#include "common/octahedral.glsl"

// Bounds of a history's Lag: of the length of its mean, in standard deviations of the lobe (1 / sqrt(alpha + 1)), and
// of the mean of its square.
#define MOST_LAG 0.35
#define MOST_SQUARE 0.5

// Steps of a packed age to a frame, and steps of the packed root of a mean square from 0 to the root of MOST_SQUARE.
#define AGE_STEPS 4.0
#define SQUARE_STEPS 63.0

// How far the mirror directions of the averaged frames miss the reflected point now, in standard deviations of the
// lobe.
struct Lag {
    vec3 mean;
    float square; // the mean of the squared length
};

// What a history keeps of a pixel beside its colour.
struct Guide {
    float depth;            // reversed
    vec3 normal;            // view space, of any length
    float age;              // frames averaged; 0 for no history
    float inverse_distance; // 1 / metres from the eye over the surface to the reflected point; 0 if that is not known
    vec2 lag;               // Lag.mean along the two Tangents of the mirror direction
    float lag_square;       // Lag.square
};

// Packs a guide. One byte of the mean lag replaces the last byte of the depth, which stays precise enough without it.
// The other byte of the lag is the last byte of the hash. The third word has the age in its lowest 10 bits, the root of
// the mean square in the next 6, and the inverse distance as a 16-bit float above them.
uvec4 PackGuide(Guide guide, uint hash) {
    uint depth = floatBitsToUint(guide.depth) + 128u, lag = packSnorm4x8(vec4(guide.lag / MOST_LAG, 0.0, 0.0));
    uint age = uint(min(guide.age * AGE_STEPS + 0.5, 1023.0));
    uint square = uint(min(sqrt(guide.lag_square / MOST_SQUARE), 1.0) * SQUARE_STEPS + 0.5);
    uint third = packHalf2x16(vec2(0.0, guide.inverse_distance)) | square << 10 | age;
    return uvec4((depth & ~255u) | (lag & 255u), packSnorm2x16(EncodeOctahedral(guide.normal)), third,
                 hash | (lag >> 8));
}

Guide UnpackGuide(uvec4 words) {
    vec2 lag = MOST_LAG * unpackSnorm4x8((words.x & 255u) | (words.w & 255u) << 8).xy;
    float age = float(words.z & 1023u) / AGE_STEPS, root_square = float(words.z >> 10 & 63u) / SQUARE_STEPS;
    float depth = uintBitsToFloat(words.x & ~255u), inverse_distance = unpackHalf2x16(words.z).y;
    return Guide(depth, DecodeOctahedralUnnormalized(unpackSnorm2x16(words.y)), age, inverse_distance, lag,
                 MOST_SQUARE * root_square * root_square);
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
