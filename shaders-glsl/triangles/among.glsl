// Traces and shades the rays of pixels among the scene's triangles: rays of the list of lost rays, and rays that are
// traced among the triangles at once.

#ifndef TRIANGLES_AMONG_GLSL
#define TRIANGLES_AMONG_GLSL

#include "triangles/begin.glsl"

// What a ray saw, and where it ended.
struct TriangleRayResult {
    vec3 color;
    vec3 place;    // relative to the eye, world axes; for the sky a point far along the ray
    int code;      // PATH_TRIANGLE or PATH_SKY
    uint triangle; // number of the triangle; NO_TRIANGLE for the sky
};

// The result of a ray for its hit, or for none; `width` is the width of its footprint there. `is_outward` comes from
// SpawnRay.
TriangleRayResult ShadeHit(TreeRay ray, TriangleHit hit, bool is_outward, float width) {
    bool is_hit = hit.id != NO_TRIANGLE;
    vec3 color = HitColor(ray, hit, width);
    precise vec3 place = ray.origin + (is_hit ? hit.t : SKY_DISTANCE) * ray.direction - triangles.eye;
    uint number = is_hit ? hit.id & ~ASKS_MATERIAL : NO_TRIANGLE;
    return TriangleRayResult(is_outward ? color : vec3(0.0), place, is_hit ? PATH_TRIANGLE : PATH_SKY, number);
}

// The width of a ray's footprint, in metres, some metres after the ray's beginning; it widens by `spread` with each
// metre. As in the references, all rays of a pixel leave from one point. If rays of sight are parallel, the width of
// the pixel is added.
float FootprintWidth(float spread, float metres) {
    return ORTHOGRAPHIC ? 2.0 * unified.pixel_to_view.y + spread * metres : spread * metres;
}

#ifndef CONFIRMED

// Traces a ray that begins on a pixel's triangle; `is_outward` comes from SpawnRay.
TriangleRayResult TraceTriangles(TreeRay ray, bool is_outward, float spread) {
    TriangleHit hit = ClosestHit(ray);
    return ShadeHit(ray, hit, is_outward, FootprintWidth(spread, hit.t));
}

#endif

#endif
