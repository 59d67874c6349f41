// ScreenColor returns the lit colour of a pixel of the screen, linear; alpha is 0 where sky is, else 1. It is loaded
// from a storage image, which costs a device without texture units less than a fetch
// (findings/lavapipe-finds-the-level-of-every-fetch.sh). Programs among triangles fetch it instead, since they may also
// sample the image with its chain, and no image is both loaded and sampled.

#ifndef UNIFIED_LIT_COLOR_GLSL
#define UNIFIED_LIT_COLOR_GLSL

#if defined(AMONG_TRIANGLES) || defined(CONFIRMED)

layout(binding = 4) uniform sampler2D color_buffer;

vec4 ScreenColor(ivec2 pixel) {
    return texelFetch(color_buffer, pixel, 0);
}

#else

layout(binding = 4, rgba16f) uniform readonly image2D color_texels;

vec4 ScreenColor(ivec2 pixel) {
    return imageLoad(color_texels, pixel);
}

#endif

#endif
