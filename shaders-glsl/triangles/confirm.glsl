// A hit on the screen proposes the triangle that its pixel shows, and one exact intersection says whether the ray meets it.
// What does not confirm goes on the list, as rays do that the screen lost.

#ifndef TRIANGLES_CONFIRM_GLSL
#define TRIANGLES_CONFIRM_GLSL

#include "captures/push.glsl"
#include "triangles/among.glsl"
#include "triangles/pixel.glsl"

// Whether a ray that hits a pixel meets its triangle, and what it then sees.
bool Confirm(Ray ray, ivec2 pixel, float spread, out Among seen) {
    bool leaves;
    TreeRay tree_ray = TreeRayOf(ray, leaves);
    uint slot;
    bool is_known = FindSlot(TriangleAt(pixel), slot);
    Met met = NOTHING;
    Meet(tree_ray, int(slot), met);
    bool asks = ASKS && (met.id & ASKS_MATERIAL) != 0u;
    bool is_met = is_known && met.id != NO_TRIANGLE && (!asks || StopsRay(met));
    met.id = is_met ? met.id : NO_TRIANGLE;
    seen = SeeMet(tree_ray, met, leaves, FootprintWidth(spread, met.t));
    return is_met || !leaves;
}

#endif
