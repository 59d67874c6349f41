// DepthAt returns the reversed depth of a pixel: the front in the pyramid's finest level, or the depth in the G-buffer
// if no ray walks over the screen. Programs without AMONG_TRIANGLES need the image `pyramid`.

#ifndef UNIFIED_DEPTH_GLSL
#define UNIFIED_DEPTH_GLSL

#ifdef AMONG_TRIANGLES

#include "unified/parameters.glsl"

layout(binding = 28) uniform sampler2D depth_buffer; // reversed; 0 is sky

float DepthAt(ivec2 pixel) {
    return texelFetch(depth_buffer, pixel, 0).r;
}

#elif defined(GATHERS)

#include "unified/pyramid.glsl"

layout(constant_id = 10) const bool SCREEN = true; // rays walk over the screen; without it there is no pyramid

layout(binding = 28) uniform sampler2D depth_buffer; // reversed; 0 is sky

float DepthAt(ivec2 pixel) {
    return SCREEN ? imageLoad(pyramid, PixelTexel(pixel)).r : texelFetch(depth_buffer, pixel, 0).r;
}

#else

#include "unified/pyramid.glsl"

float DepthAt(ivec2 pixel) {
    return imageLoad(pyramid, PixelTexel(pixel)).r;
}

#endif

#endif
