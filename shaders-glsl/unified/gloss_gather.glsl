// Rays as samples of a pixel's lobe. Needs parameters.glsl, ray.glsl, gloss.glsl.

// What a ray weighs at least, so that a pixel without a fitting neighbour takes what there is.
#define LEAST_WEIGHT 1e-4

struct Lobe {
    vec3 point;  // of the pixel, in ViewPoint's scale
    vec3 normal;
    vec3 mirror;
    float power; // alpha + 1
};

Lobe LobeOf(ivec2 pixel, float depth, vec3 normal, float roughness) {
    Lobe lobe;
    lobe.point = ViewPoint(vec2(pixel) + 0.5, depth);
    lobe.normal = normal;
    lobe.mirror = MirrorDirection(lobe.point, normal);
    lobe.power = LobePower(roughness);
    return lobe;
}

struct Sum {
    vec4 color;    // and fade
    float weight;  // of all rays
    float hits;    // of those that hit
};

// Adds a ray. Its weight is lobe / density, bounded: 2 f / (f + q) is f / q where they agree, and never
// above 2, however little a neighbour expected what matters here (the balance heuristic between the
// two pixels; Veach and Guibas 1995). Densities of different roughness compare as they stand. The
// weight alone keeps foreign surfaces apart: tests of normals and planes changed no figure.
void Gather(inout Sum sum, Lobe lobe, vec4 place, vec4 color) {
    bool hit = place.w > 0.0;
    vec3 to = hit ? normalize(place.xyz - lobe.point) : place.xyz;
    float f = lobe.power * exp2((lobe.power - 1.0) * LOG2_E * LogCos(to, lobe.mirror));
    float weight = place.w != 0.0 ? max(2.0 * f / (f + abs(place.w)), LEAST_WEIGHT) : 0.0;
    float hits = hit && dot(to, lobe.normal) > 0.0 ? weight : 0.0;
    sum.weight += weight;
    sum.color += hits * color;
    sum.hits += hits;
}

// Reflection colour, and its fade in a.
vec4 Reflection(Sum sum) {
    return sum.hits > 0.0 ? vec4(sum.color.rgb / sum.weight, sum.color.a / sum.hits) : vec4(0.0);
}
