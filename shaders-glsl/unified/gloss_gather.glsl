// A pixel's reflection as a weighted mean of rays.

struct Sum {
    vec4 color;    // and fade
    float weight;  // of all rays
    float hits;    // of those that hit
};

void Add(inout Sum sum, float weight, bool hit, vec4 color) {
    float hits = hit ? weight : 0.0;
    sum.weight += weight;
    sum.color += hits * color;
    sum.hits += hits;
}

// Reflection colour, and its fade in a. What rays missed is black. Over another reflection it is not: what the
// rays hit has its own colour, and fades by how many miss. The product is the same, by the fade that 16 bits hold.
vec4 Reflection(Sum sum) {
    if (!(sum.hits > 0.0))
        return vec4(0.0);
    vec4 reflection = vec4(sum.color.rgb / sum.weight, sum.color.a / sum.hits);
    if (OVER != 0) {
        float fade = unpackHalf2x16(packHalf2x16(vec2(sum.color.a / sum.weight, 0.0))).x;
        reflection = fade > 0.0 ? vec4(reflection.rgb * (reflection.a / fade), fade) : vec4(0.0);
    }
    return reflection;
}
