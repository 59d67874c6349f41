// A hit on the screen proposes the triangle that its pixel shows, and one exact intersection says whether the ray meets it.
// What does not confirm goes on the list, as rays do that the screen lost.

#ifndef TRIANGLES_CONFIRM_GLSL
#define TRIANGLES_CONFIRM_GLSL

#include "captures/push.glsl"
#include "triangles/among.glsl"
#include "triangles/pixel.glsl"

// A ray that hits a pixel, and what it meets of the pixel's triangle.
struct Confirmed {
    TreeRay ray;
    Met met;
    bool leaves; // see BeginRay
};

// Whether a ray that hits a pixel meets its triangle.
bool Confirm(Ray ray, ivec2 pixel, out Confirmed confirmed) {
    confirmed.ray = TreeRayOf(ray, confirmed.leaves);
    uint slot;
    bool is_known = FindSlot(TriangleAt(pixel), slot);
    Met met = NOTHING;
    Meet(confirmed.ray, int(slot), met);
    bool asks = ASKS && (met.id & ASKS_MATERIAL) != 0u;
    bool is_met = is_known && met.id != NO_TRIANGLE && (!asks || StopsRay(met));
    met.id = is_met ? met.id : NO_TRIANGLE;
    confirmed.met = met;
    return is_met || !confirmed.leaves;
}

// What a ray sees that was confirmed. A shader asks for it where nothing else of the ray is needed any more: colours take most
// of the registers.
Among SeeConfirmed(Confirmed confirmed, float spread) {
    return SeeMet(confirmed.ray, confirmed.met, confirmed.leaves, FootprintWidth(spread, confirmed.met.t));
}

#endif
