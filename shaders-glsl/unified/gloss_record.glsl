// What a ray of a narrow lobe saw, and the lobe that it is of, as neighbours gather them: four words, so that
// one load brings it all.

#define NO_RECORD uvec4(0)

struct Record {
    vec3 mirror; // the lobe's middle, a unit vector
    float root;  // of alpha + 1; negative for a miss; 0 for no ray
    vec4 color;  // of the hit, and its fade in a; a miss is 0
};

// The octahedral map of the unit sphere (Cigolle et al. 2014).
vec2 Octahedral(vec3 v) {
    v /= abs(v.x) + abs(v.y) + abs(v.z);
    vec2 folded = 1.0 - abs(v.yx);
    return v.z >= 0.0 ? v.xy : vec2(v.x >= 0.0 ? folded.x : -folded.x, v.y >= 0.0 ? folded.y : -folded.y);
}

vec3 FromOctahedral(vec2 o) {
    float z = 1.0 - abs(o.x) - abs(o.y);
    float fold = max(-z, 0.0);
    return normalize(vec3(o.x + (o.x >= 0.0 ? -fold : fold), o.y + (o.y >= 0.0 ? -fold : fold), z));
}

uvec4 Pack(Record r) {
    return uvec4(packSnorm2x16(Octahedral(r.mirror)), floatBitsToUint(r.root), packHalf2x16(r.color.rg),
                 packHalf2x16(r.color.ba));
}

Record Unpack(uvec4 words) {
    return Record(FromOctahedral(unpackSnorm2x16(words.x)), uintBitsToFloat(words.y),
                  vec4(unpackHalf2x16(words.z), unpackHalf2x16(words.w)));
}
