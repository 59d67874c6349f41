// Gathered rays, and the reflection that a weighted mean of rays makes.

#ifndef UNIFIED_GATHERED_GLSL
#define UNIFIED_GATHERED_GLSL

#include "unified/resolve/blocks.glsl"
#include "unified/parameters.glsl"

layout(constant_id = 2) const bool OVER = false;  // another reflection shows where this one misses

layout(binding = 3, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness

// The pixels of a block of 2 x 2 exchange values. A device shades the block's pixels of a fragment program in step, so
// that v +- dFdx(v) is the value of v in the pixel beside. An exchange costs a subtraction and an addition, and a value
// that all four pixels would load is loaded once. The result is exact but for the last bits of the greater of the two
// values. The threads of a compute program share memory instead, and round the values in the same way.

// A ray as pixels and cells gather it. All is 0 for no ray.
struct NeighbourRay {
    vec4 key;   // what its weight depends on; w is 0 for no ray, and negative for a miss
    vec4 color; // of the hit, and its fade in alpha
};

// The sums from which the reflection of a pixel or a cell is made, as a weighted mean of rays.
struct RaySum {
    vec4 color;    // weighted colours of the rays that hit, and fades in alpha
    float weight;  // weights of all rays
    float hits;    // weights of the rays that hit
    float squares; // squared weights of all rays
};

const RaySum NO_RAYS = RaySum(vec4(0.0), 0.0, 0.0, 0.0);

void AddRay(inout RaySum sum, float weight, bool is_hit, vec4 color) {
    float hit_weight = is_hit ? weight : 0.0;
    sum.weight += weight;
    sum.color += hit_weight * color;
    sum.hits += hit_weight;
    sum.squares += weight * weight;
}

// The reflection of a sum of rays: colour, and fade in alpha. A miss counts as black. Over another reflection (OVER)
// the hits keep their colour instead, and the fade falls with the share of misses. Colour times fade is the same either
// way, with the fade rounded to 16 bits.
vec4 ReflectionFromSum(RaySum sum) {
    if (!(sum.hits > 0.0))
        return vec4(0.0);
    vec4 reflection = vec4(sum.color.rgb / sum.weight, sum.color.a / sum.hits);
    if (OVER) {
        float fade = unpackHalf2x16(packHalf2x16(vec2(sum.color.a / sum.weight, 0.0))).x;
        reflection = fade > 0.0 ? vec4(reflection.rgb * (reflection.a / fade), fade) : vec4(0.0);
    }
    return reflection;
}

#endif
