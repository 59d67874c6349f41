// Looks into the images of a scene's materials, with their levels, which stand in one buffer of texels, since a device need
// not let the threads of a workgroup look into different images.

#ifndef TRIANGLES_IMAGE_GLSL
#define TRIANGLES_IMAGE_GLSL

#include "triangles/scene.glsl"

// From sRGB, within 0.002 of the exact curve (a cubic fit with f(0) = 0 and f(1) = 1).
vec3 Linear(vec3 c) {
    return c * (c * (c * 0.305306011 + 0.682171111) + 0.012522878);
}

vec4 Texel(int base, ivec2 size, ivec2 at) {
    return unpackUnorm4x8(ImageWord(base + at.y * size.x + at.x));
}

// An image at texture coordinates, which wrap, over a footprint that measures `repeats` repeats of it along a side:
// bilinear in the level whose texels are nearest to that in size. `row` is where the table describes the image: width,
// height, levels, whether it is sRGB; then in four vectors where each level begins.
vec4 ImageAt(int row, vec2 uv, float repeats) {
    uvec4 head = Table(row);
    float texels = max(repeats * sqrt(float(head.x * head.y)), 1.0);
    int level = int(min(log2(texels) + 0.5, float(head.z) - 1.0));
    uvec4 bases = Table(row + 1 + (level >> 2));
    uint base = (level & 2) == 0 ? ((level & 1) == 0 ? bases.x : bases.y) : ((level & 1) == 0 ? bases.z : bases.w);
    ivec2 size = max(ivec2(head.xy >> uint(level)), ivec2(1));
    vec2 place = (uv - floor(uv)) * vec2(size) - 0.5;
    vec2 corner = floor(place), part = place - corner;
    // The part of a repeat is at most 1, so that one step brings each neighbour back into the image.
    ivec2 low = ivec2(corner), high = low + 1;
    low += ivec2(lessThan(low, ivec2(0))) * size;
    high -= ivec2(greaterThanEqual(high, size)) * size;
    low = clamp(low, ivec2(0), size - 1);
    high = clamp(high, ivec2(0), size - 1);
    vec4 a = Texel(int(base), size, low), b = Texel(int(base), size, ivec2(high.x, low.y));
    vec4 c = Texel(int(base), size, ivec2(low.x, high.y)), d = Texel(int(base), size, high);
    if (head.w != 0u) {
        a.rgb = Linear(a.rgb);
        b.rgb = Linear(b.rgb);
        c.rgb = Linear(c.rgb);
        d.rgb = Linear(d.rgb);
    }
    return mix(mix(a, b, part.x), mix(c, d, part.x), part.y);
}

#endif
