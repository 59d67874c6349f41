// The R2 sequence (Roberts 2018): points of the unit square that fill it evenly, however many there are.

#ifndef COMMON_SEQUENCE_GLSL
#define COMMON_SEQUENCE_GLSL

// Returns point n; point 0 is the corner. Uses integers that wrap around: in floats, a large n would lose the fraction.
vec2 SequencePoint(int n) {
    uvec2 along = uint(n) * uvec2(3242174889u, 2447445414u);
    return vec2(along >> 8) * exp2(-24.0);
}

#endif
