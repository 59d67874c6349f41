// The four texels of a level that a linear blit makes into one texel of the next level, and their weights.

#ifndef COMMON_LINEAR_BLIT_GLSL
#define COMMON_LINEAR_BLIT_GLSL

struct BilinearTexels {
    ivec2 low, high; // the first and the last of the four
    vec2 part;       // position between low and high, 0 to 1
};

// Finds the four texels for a texel of the next level. `size` is that level's size, `below` the size of the level that
// is blitted.
BilinearTexels FindBilinearTexels(ivec2 texel, ivec2 size, ivec2 below) {
    vec2 place = max((vec2(texel) + 0.5) * (vec2(below) / vec2(size)) - 0.5, 0.0);
    ivec2 low = ivec2(place);
    return BilinearTexels(low, min(low + 1, below - 1), place - vec2(low));
}

// The weighted mean of four values: a at low, b to the right of low, c below low, and d at high.
vec4 MixBilinear(BilinearTexels corners, vec4 a, vec4 b, vec4 c, vec4 d) {
    return mix(mix(a, b, corners.part.x), mix(c, d, corners.part.x), corners.part.y);
}

#endif
