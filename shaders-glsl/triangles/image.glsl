// Samples the images of a scene's materials. One buffer holds the texels of all images and levels, since a device need
// not let the threads of a workgroup sample different images.

#ifndef TRIANGLES_IMAGE_GLSL
#define TRIANGLES_IMAGE_GLSL

#include "triangles/scene.glsl"

// Converts sRGB to linear, within 0.002 of the exact curve (a cubic fit with f(0) = 0 and f(1) = 1).
vec3 LinearFromSrgb(vec3 c) {
    return c * (c * (c * 0.305306011 + 0.682171111) + 0.012522878);
}

// A texel of a level whose texels begin at the word `base`.
vec4 LoadImageTexel(int base, ivec2 size, ivec2 texel) {
    return unpackUnorm4x8(ImageWord(base + texel.y * size.x + texel.x));
}

// Samples a map at texture coordinates, which wrap, over a footprint whose side measures `repeats` repeats of the map.
// The sample is bilinear, in the level whose texels are nearest to the footprint in size. `map` has the index of the
// map's first word and its size, as in Material; the first words say where each level begins. `described` has the
// number of levels in the bits MAP_LEVELS, and says whether the map is sRGB (MAP_SRGB).
vec4 SampleImage(uvec2 map, uint described, vec2 uv, float repeats) {
    uvec2 full_size = uvec2(map.y & 0xffffu, map.y >> 16);
    float levels = float(described & MAP_LEVELS);
    float footprint_texels = max(repeats * sqrt(float(full_size.x * full_size.y)), 1.0);
    int level = int(min(log2(footprint_texels) + 0.5, levels - 1.0));
    int base = int(ImageWord(int(map.x) + level));
    ivec2 size = max(ivec2(full_size >> uint(level)), ivec2(1));
    vec2 position = (uv - floor(uv)) * vec2(size) - 0.5;
    vec2 corner = floor(position), part = position - corner;
    // The coordinates lie within one repeat, so that one step by the size brings each neighbour back into the image.
    ivec2 low = ivec2(corner), high = low + 1;
    low += ivec2(lessThan(low, ivec2(0))) * size;
    high -= ivec2(greaterThanEqual(high, size)) * size;
    low = clamp(low, ivec2(0), size - 1);
    high = clamp(high, ivec2(0), size - 1);
    vec4 a = LoadImageTexel(base, size, low), b = LoadImageTexel(base, size, ivec2(high.x, low.y));
    vec4 c = LoadImageTexel(base, size, ivec2(low.x, high.y)), d = LoadImageTexel(base, size, high);
    if ((described & MAP_SRGB) != 0u) {
        a.rgb = LinearFromSrgb(a.rgb);
        b.rgb = LinearFromSrgb(b.rgb);
        c.rgb = LinearFromSrgb(c.rgb);
        d.rgb = LinearFromSrgb(d.rgb);
    }
    return mix(mix(a, b, part.x), mix(c, d, part.x), part.y);
}

#endif
