// Puts rays on the list of lost rays, for captures/follow.comp or triangles/follow.comp: from where the screen lost
// them, or with CONFIRMED from where they begin. With LOSES_NOTHING, no ray is put on the list. Needs
// unified/trace/traverse.glsl.

#ifndef CAPTURES_SEEN_GLSL
#define CAPTURES_SEEN_GLSL

#include "captures/sky_along.glsl"
#ifndef LOSES_NOTHING
#include "captures/push.glsl"
#endif
#ifdef CONFIRMED
#include "triangles/confirm.glsl"
#endif

// Whether a ray hit nothing and left through the far plane, and so ended in the sky. Always false without FOLLOWED.
bool EndsInSky(Ray ray, Hit hit) {
    return FOLLOWED && hit.code == PATH_MISS && MissCode(ray) == PATH_MISS_SKY;
}

#ifdef CONFIRMED
// Puts a ray on the list from where it begins; `spread` says by how much its footprint widens with each metre.
void PushPixelRay(uvec2 pixel, Ray ray, float spread) {
    precise vec3 begin = ViewPoint(ray.start, ray.depth) * captures.view_unit;
    PushLostRay(pixel, begin, ray.direction, 0.0, spread, TriangleAt(ray.pixel));
}
#endif

// Puts the ray of a pixel or cell on the list, if the screen lost it, from the place where the screen lost it. `before`
// says over how many metres the footprint widened before the ray began, and `spread` by how much it widens with each
// metre.
void PushIfLost(uvec2 pixel, Ray ray, Hit hit, float before, float spread) {
#ifndef LOSES_NOTHING
    if (!FOLLOWED || hit.code == PATH_HI_Z)
        return;
    precise float depth = ray.depth + hit.s * ray.rate.z;
    precise vec2 position = ray.start + hit.s * ray.rate.xy;
    precise vec3 ray_begin = ViewPoint(ray.start, ray.depth) * captures.view_unit;
    precise vec3 lost_at = ViewPoint(position, max(depth, 0.0)) * captures.view_unit;
    PushLostRay(pixel, lost_at, ray.direction, before + distance(ray_begin, lost_at), spread, NO_TRIANGLE);
#endif
}

#endif
