// Puts a ray on the list of lost rays.

#ifndef CAPTURES_PUSH_GLSL
#define CAPTURES_PUSH_GLSL

#include "captures/next_place.glsl"
#include "captures/lost.glsl"

// `start` is in view space and metres, and `direction` is in view space and of any length. The other arguments are
// fields of LostRay.
void PushLostRay(uvec2 pixel, vec3 start, vec3 direction, float before, float spread, uint triangle) {
    uint index = ReserveListIndex(uint(LOST_GROUP));
    if (index >= uint(lost.rays.length()))
        return;
    vec3 along = ToWorld(direction);
    precise float squared = along.x * along.x + along.y * along.y + along.z * along.z;
    precise vec3 unit = along * (1.0 / sqrt(squared));
    lost.rays[index] = LostRay(ToWorld(start), before, unit, spread, uvec4(pixel, triangle, 0u));
}

#endif
