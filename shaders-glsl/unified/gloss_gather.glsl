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
// rays hit has its own colour, and fades by how many miss; the product is the same.
vec4 Reflection(Sum sum) {
    float colors = OVER != 0 ? sum.hits : sum.weight;
    float fades = OVER != 0 ? sum.weight : sum.hits;
    return sum.hits > 0.0 ? vec4(sum.color.rgb / colors, sum.color.a / fades) : vec4(0.0);
}
