// The list of pixels whose neighbours' rays say little of their own reflection: what the passes that gather write, and what
// triangles/own.comp reads, by DOUBT_ACCESS. Filled again for each pass that gathers; the buffers are those of captures/lost.glsl, whose rays have
// been followed by then.

#ifndef TRIANGLES_DOUBT_GLSL
#define TRIANGLES_DOUBT_GLSL

#include "common/constants.glsl"

layout(constant_id = 12) const int OWN_RAYS = 0; // rays of its own that such a pixel gets; 0: there is no list

#ifdef DOUBT_ACCESS

layout(std430, binding = 18) DOUBT_ACCESS buffer DoubtCounts {
    uint groups[3]; // the arguments of an indirect dispatch: a workgroup for PixelsToAGroup()
    uint count;
} doubt_counts;

layout(std430, binding = 19) DOUBT_ACCESS buffer Doubts {
    uvec4 pixels[]; // Doubt, packed
} doubts;

#endif

// A pixel, and what its neighbours' rays say of its reflection.
struct Doubt {
    ivec2 pixel;
    vec3 color; // of the reflection
    float rays; // so many rays of its own would say as much
};

uint PixelsToAGroup() {
    return uint(OWN_GROUP / max(OWN_RAYS, 1));
}

uvec4 PackDoubt(Doubt doubt) {
    return uvec4(uint(doubt.pixel.x) | uint(doubt.pixel.y) << 16, floatBitsToUint(doubt.rays),
                 packHalf2x16(doubt.color.rg), packHalf2x16(vec2(doubt.color.b, 0.0)));
}

Doubt UnpackDoubt(uvec4 words) {
    vec3 color = vec3(unpackHalf2x16(words.z), unpackHalf2x16(words.w).x);
    return Doubt(ivec2(words.x & 0xffffu, words.x >> 16), color, uintBitsToFloat(words.y));
}

#endif
