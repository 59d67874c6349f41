// Tests which pixels of the screen a ray can have seen around its hit, and whether the ray leaves towards the sky.
// Needs the image `pyramid`. CPU twin: reference::unified::surface.

#ifndef UNIFIED_SURFACE_GLSL
#define UNIFIED_SURFACE_GLSL

#include "unified/traverse.glsl"

// Whether a ray that hit nothing left through the far plane, if no other image is asked (without FOLLOWED). If so,
// `hit` gets the pixel and the position where it left. If the screen shows sky there, the ray sees this sky.
bool LeavesThroughFarPlane(Ray ray, inout Hit hit) {
    precise vec2 place = ray.start + ray.end * ray.rate.xy;
    place = clamp(place, vec2(0.0), vec2(unified.size));
    ivec2 side = ivec2(greaterThan(ray.inverse, vec2(0.0))) * unified.size;
    precise vec2 sides = (vec2(side) - ray.start) * ray.inverse;
    bool is_far = !FOLLOWED && hit.code == PATH_MISS && ray.rate.z < 0.0 && ray.end < min(sides.x, sides.y);
    hit.pixel = is_far ? min(ivec2(place), unified.size - 1) : hit.pixel;
    hit.position = is_far ? place : hit.position;
    return is_far;
}

// The surface that reflects, its ray, and the pixel that the ray hit.
struct VisibilityTest {
    vec3 point;     // of the surface, in ViewPoint's scale
    vec3 normal;    // of any length
    vec3 direction; // of the ray, of any length
    float above;    // a place lies above the surface if Dot(normal, OffsetToPixel(...)) is greater than this
    float beside;   // squared: a place lies beside the ray if the length of cross(direction, OffsetToPixel(...)) is greater
    float own;      // depth of the pixel that was hit; the front of EMPTY_BLOCK for sky
    float apart;    // a pixel stands before or behind if its depth differs from `own` by more than this
    bool is_reflector; // the pixel that was hit shows the surface that reflects
};

// The vector from the surface's point to the point that a pixel shows at a position and a depth. In a perspective it is
// divided by the z of the latter, so that a pixel has one width at any depth, and the code needs no division.
vec3 OffsetToPixel(vec3 point, vec2 position, float depth) {
    if (ORTHOGRAPHIC) {
        precise vec3 away = ViewPoint(position, depth) - point;
        return away;
    }
    precise vec3 away = ViewRay(position) - (depth + unified.depth_offset) * point;
    return away;
}

// The height above the surface that reflects, scaled as OffsetToPixel scales it, up to which a pixel shows that surface.
float ReflectorHeight(vec3 normal) {
    precise float height = STANDS_ABOVE * (2.0 * unified.pixel_to_view.y) * sqrt(Dot(normal, normal));
    return height;
}

// Whether a pixel of a depth shows the surface that reflects, which is given by a point and a normal of any length.
bool ShowsReflector(vec3 point, vec3 normal, ivec2 pixel, float depth) {
    return depth >= 0.0 && !(Dot(normal, OffsetToPixel(point, vec2(pixel) + 0.5, depth)) > ReflectorHeight(normal));
}

// Makes the test for a surface's point and normal, a ray's direction, and the pixel that the ray hit, of depth `own`.
VisibilityTest MakeVisibilityTest(vec3 point, vec3 normal, vec3 direction, ivec2 pixel, float own) {
    precise float width = 2.0 * unified.pixel_to_view.y;
    precise float beside = STANDS_BESIDE * width;
    precise float beside_squared = beside * beside * Dot(direction, direction);
    precise float apart = STANDS_BEFORE * width * (ORTHOGRAPHIC ? unified.depth_offset : own + unified.depth_offset);
    bool is_reflector = ShowsReflector(point, normal, pixel, own);
    return VisibilityTest(point, normal, direction, ReflectorHeight(normal), beside_squared, own, apart, is_reflector);
}

// Whether a ray can have seen what a pixel of a depth shows at its centre `middle`. A surface that stands before the
// hit and far beside the ray is elsewhere in the reflection. A surface behind the hit is beside the hit in the
// reflection, too. If the pixel that was hit shows the surface that reflects, the ray has met a thing that stands on
// that surface, and nothing behind the hit counts. The ray never sees the surface that reflects, nor anything below it.
// Sky lies behind everything.
bool IsVisibleAlongRay(VisibilityTest test, vec2 middle, float depth) {
    vec3 away = OffsetToPixel(test.point, middle, depth);
    precise vec3 off = away.yzx * test.direction.zxy - away.zxy * test.direction.yzx;
    precise float nearest = test.own + test.apart, farthest = test.own - test.apart;
    bool is_above = Dot(test.normal, away) > test.above;
    bool is_beside = Dot(off, off) > test.beside;
    bool is_seen = test.own >= 0.0 && is_above && !(depth > nearest && is_beside);
    return (depth < 0.0 || is_seen) && !(test.is_reflector && depth < farthest);
}

#endif
