// What the ray of a pixel sees among the triangles, without a walk over the screen.

#ifndef TRIANGLES_FROM_PIXEL_GLSL
#define TRIANGLES_FROM_PIXEL_GLSL

#include "triangles/among.glsl"
#include "triangles/pixel.glsl"

Among SeeFrom(Ray ray, float spread) {
    bool leaves;
    TreeRay tree_ray = TreeRayOf(ray, leaves);
    return See(tree_ray, leaves, spread);
}

#endif
