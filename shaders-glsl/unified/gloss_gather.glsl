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

// Reflection colour, and its fade in a.
vec4 Reflection(Sum sum) {
    return sum.hits > 0.0 ? vec4(sum.color.rgb / sum.weight, sum.color.a / sum.hits) : vec4(0.0);
}
