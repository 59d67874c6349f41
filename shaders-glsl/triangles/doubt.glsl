// The list of pixels in doubt, whose neighbours' rays say too little of their reflection. The passes that gather write
// the list, each anew, and triangles/own.comp reads it. The list uses the buffers of the lost rays
// (captures/lost.glsl), which have been followed by then.

#ifndef TRIANGLES_DOUBT_GLSL
#define TRIANGLES_DOUBT_GLSL

#include "captures/counts.glsl"
#include "common/constants.glsl"
#include "triangles/own_rays.glsl"

layout(std430, binding = 19) LIST_ACCESS buffer Doubts {
    uvec4 pixels[]; // Doubt, packed
} doubts;

// A pixel, and what its neighbours' rays say of its reflection.
struct Doubt {
    ivec2 pixel;
    vec4 color; // of the reflection, and its fade in alpha
    float rays; // number of own rays that would say as much
};

// Number of pixels whose own rays one workgroup follows.
uint PixelsPerGroup() {
    return uint(OWN_GROUP / max(OWN_RAYS, 1));
}

uvec4 PackDoubt(Doubt doubt) {
    return uvec4(uint(doubt.pixel.x) | uint(doubt.pixel.y) << 16, floatBitsToUint(doubt.rays),
                 packHalf2x16(doubt.color.rg), packHalf2x16(doubt.color.ba));
}

Doubt UnpackDoubt(uvec4 words) {
    vec4 color = vec4(unpackHalf2x16(words.z), unpackHalf2x16(words.w));
    return Doubt(ivec2(words.x & 0xffffu, words.x >> 16), color, uintBitsToFloat(words.y));
}

#endif
