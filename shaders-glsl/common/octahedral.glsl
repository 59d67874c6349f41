// Unit vectors as two numbers from -1 to 1.

#ifndef COMMON_OCTAHEDRAL_GLSL
#define COMMON_OCTAHEDRAL_GLSL

// The octahedral map of the unit sphere (Cigolle et al. 2014).
vec2 EncodeOctahedral(vec3 v) {
    v /= abs(v.x) + abs(v.y) + abs(v.z);
    vec2 folded = 1.0 - abs(v.yx);
    return v.z >= 0.0 ? v.xy : vec2(v.x >= 0.0 ? folded.x : -folded.x, v.y >= 0.0 ? folded.y : -folded.y);
}

// Decodes the direction of a unit vector. The result ends on the octahedron, and so does not have unit length.
vec3 DecodeOctahedralUnnormalized(vec2 o) {
    float z = 1.0 - abs(o.x) - abs(o.y);
    float fold = max(-z, 0.0);
    return vec3(o.x + (o.x >= 0.0 ? -fold : fold), o.y + (o.y >= 0.0 ? -fold : fold), z);
}

vec3 DecodeOctahedral(vec2 o) {
    return normalize(DecodeOctahedralUnnormalized(o));
}

#endif
