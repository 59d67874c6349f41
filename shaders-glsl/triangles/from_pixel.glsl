// Traces the ray of a pixel among the triangles, without a walk over the screen.

#ifndef TRIANGLES_FROM_PIXEL_GLSL
#define TRIANGLES_FROM_PIXEL_GLSL

#include "triangles/among.glsl"
#include "triangles/pixel.glsl"

TriangleRayResult TraceTrianglesFromPixel(Ray ray, float spread) {
    bool is_outward;
    TreeRay tree_ray = TreeRayFromPixel(ray, is_outward);
    return TraceTriangles(tree_ray, is_outward, spread);
}

#endif
