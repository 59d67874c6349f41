// The R2 sequence (Roberts 2018): points of the unit square that fill it evenly, however many there are.

#ifndef COMMON_SEQUENCE_GLSL
#define COMMON_SEQUENCE_GLSL

// Returns point n; point 0 is the corner. The factors are 1 / g and 1 / g^2, with the plastic number g, in units of
// 2^-32. The products wrap around, which keeps the fraction; in floats, a large n would lose it.
vec2 SequencePoint(int n) {
    uvec2 along = uint(n) * uvec2(3242174889u, 2447445414u);
    return vec2(along >> 8) * exp2(-24.0);
}

#endif
