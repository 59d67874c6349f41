// Confirms hits on the screen. A hit proposes the triangle that its pixel shows, and one exact intersection says
// whether the ray meets it. A ray without a confirmed hit is put on the list, like rays that the screen lost.

#ifndef TRIANGLES_CONFIRM_GLSL
#define TRIANGLES_CONFIRM_GLSL

#include "captures/push.glsl"
#include "triangles/among.glsl"
#include "triangles/pixel.glsl"

// A ray that hits a pixel, and its hit on the pixel's triangle.
struct ConfirmedHit {
    TreeRay ray;
    TriangleHit hit;
    bool is_outward; // see SpawnRay
};

// Whether a ray that hits a pixel meets the pixel's triangle. Also true for a ray that leads below its own triangle.
bool ConfirmHit(Ray ray, ivec2 pixel, out ConfirmedHit confirmed) {
    confirmed.ray = TreeRayFromPixel(ray, confirmed.is_outward);
    uint slot;
    bool is_known = FindTriangleSlot(TriangleAt(pixel), slot);
    TriangleHit hit = NO_HIT;
    UpdateNearestHit(confirmed.ray, int(slot), hit);
    bool asks_material = ASKS && (hit.id & ASKS_MATERIAL) != 0u;
    bool is_hit = is_known && hit.id != NO_TRIANGLE && (!asks_material || StopsRay(hit));
    hit.id = is_hit ? hit.id : NO_TRIANGLE;
    confirmed.hit = hit;
    return is_hit || !confirmed.is_outward;
}

// The result of a ray whose hit was confirmed. A shader calls this function once it needs nothing else of the ray,
// since colours take most of the registers.
TriangleRayResult ShadeConfirmedHit(ConfirmedHit confirmed, float spread) {
    return ShadeHit(confirmed.ray, confirmed.hit, confirmed.is_outward, FootprintWidth(spread, confirmed.hit.t));
}

#endif
