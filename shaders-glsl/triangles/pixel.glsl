// The triangle that a pixel shows, and the ray of a pixel among the scene's triangles.

#ifndef TRIANGLES_PIXEL_GLSL
#define TRIANGLES_PIXEL_GLSL

#include "unified/trace/ray.glsl"
#include "triangles/begin.glsl"

// The images of the screen, for programs that trace rays from its pixels. Each permutation reads some of them.
#pragma group(ScreenResources, pyramid, depth_buffer, normal_buffer, material_buffer, color_texels, triangle_buffer)

layout(binding = 29, r32ui) uniform readonly uimage2D triangle_buffer; // the triangle of each pixel; one texel if none is known

uint TriangleAt(ivec2 pixel) {
    return imageLoad(triangle_buffer, min(pixel, imageSize(triangle_buffer) - 1)).x;
}

// The ray of a pixel among the triangles; `is_outward` comes from SpawnRay.
TreeRay TreeRayFromPixel(Ray ray, out bool is_outward) {
    vec3 start = ToWorld(ViewPoint(ray.start, ray.depth) * captures.view_unit);
    vec3 along = ToWorld(ray.direction);
    return SpawnRay(start, along * inversesqrt(dot(along, along)), TriangleAt(ray.pixel), is_outward);
}

#endif
