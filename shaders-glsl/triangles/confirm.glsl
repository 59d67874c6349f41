// A hit on the screen proposes the triangle that its pixel shows, and one exact intersection says whether the ray meets it.
// What does not confirm goes on the list, as rays do that the screen lost.

#ifndef TRIANGLES_CONFIRM_GLSL
#define TRIANGLES_CONFIRM_GLSL

#include "captures/push.glsl"
#include "triangles/among.glsl"
#include "triangles/pixel.glsl"

// Whether a ray that hits a pixel meets its triangle, and what it then sees.
bool Confirm(Ray ray, ivec2 pixel, float spread, out Among seen) {
    vec3 start = ToWorld(ViewPoint(ray.start, ray.depth) * captures.view_unit);
    vec3 along = ToWorld(ray.direction);
    bool leaves;
    TreeRay tree_ray = BeginRay(start, along * inversesqrt(dot(along, along)), TriangleAt(ray.pixel), leaves);
    uint proposed = TriangleAt(pixel);
    bool is_known = proposed < uint(triangles.count);
    uint slot = Attribute(is_known ? proposed : 0u, 2).w;
    is_known = is_known && slot != NO_TRIANGLE;
    Met met = NOTHING;
    Meet(tree_ray, int(is_known ? slot : 0u), met);
    bool asks = ASKS && (met.id & ASKS_MATERIAL) != 0u;
    bool is_met = is_known && met.id != NO_TRIANGLE && (!asks || StopsRay(met));
    met.id = is_met ? met.id : NO_TRIANGLE;
    seen = SeeMet(tree_ray, met, leaves, spread * met.t);
    return is_met || !leaves;
}

#endif
