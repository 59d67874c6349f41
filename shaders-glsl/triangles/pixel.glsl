// The triangle that a pixel shows.

#ifndef TRIANGLES_PIXEL_GLSL
#define TRIANGLES_PIXEL_GLSL

layout(binding = 29, r32ui) uniform readonly uimage2D triangle_buffer; // of each pixel; one texel where none is known

uint TriangleAt(ivec2 pixel) {
    return imageLoad(triangle_buffer, min(pixel, imageSize(triangle_buffer) - 1)).x;
}

#endif
