// What the ray of a pixel sees among the triangles, without a walk over the screen.

#ifndef TRIANGLES_FROM_PIXEL_GLSL
#define TRIANGLES_FROM_PIXEL_GLSL

#include "unified/ray.glsl"
#include "triangles/among.glsl"
#include "triangles/pixel.glsl"

Among SeeFrom(Ray ray, float spread) {
    vec3 start = ToWorld(ViewPoint(ray.start, ray.depth) * captures.view_unit);
    vec3 along = ToWorld(ray.direction);
    return See(start, along * inversesqrt(dot(along, along)), TriangleAt(ray.pixel), spread);
}

#endif
