// What a ray can have seen of the screen where it hits, and whether it hits nothing but sky. Needs the image `pyramid`. CPU twin:
// reference::unified::surface.

#ifndef UNIFIED_SURFACE_GLSL
#define UNIFIED_SURFACE_GLSL

#include "unified/traverse.glsl"

// Whether a ray that hit nothing went beyond the far plane, where no other image is asked; where it did so then stands in `hit`.
// If the screen shows sky there, it is the colour of the ray.
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
    float above;    // what a place above the surface has more than, of Dot(normal, OffsetToPixel(...))
    float beside;   // squared: what a place beside the ray has more than, of the length of the direction cross OffsetToPixel(...)
    float own;      // depth of the pixel that was hit; that of EMPTY_BLOCK for sky
    float apart;    // by how much a depth differs from it that stands before or behind
    bool is_reflector; // that pixel shows the surface that reflects
};

// From the surface's point to the place that a pixel's position and depth show, divided by that place's z in a perspective: what
// is a pixel wide there then has one width at any depth, and nothing is divided.
vec3 OffsetToPixel(vec3 point, vec2 position, float depth) {
    if (ORTHOGRAPHIC) {
        precise vec3 away = ViewPoint(position, depth) - point;
        return away;
    }
    precise vec3 away = ViewRay(position) - (depth + unified.depth_offset) * point;
    return away;
}

// `own` is the depth of the pixel that was hit.
VisibilityTest MakeVisibilityTest(vec3 point, vec3 normal, vec3 direction, ivec2 pixel, float own) {
    precise float width = 2.0 * unified.pixel_to_view.y;
    precise float above = STANDS_ABOVE * width * sqrt(Dot(normal, normal));
    precise float beside = STANDS_BESIDE * width;
    precise float beside_squared = beside * beside * Dot(direction, direction);
    precise float apart = STANDS_BEFORE * width * (ORTHOGRAPHIC ? unified.depth_offset : own + unified.depth_offset);
    bool is_above = Dot(normal, OffsetToPixel(point, vec2(pixel) + 0.5, own)) > above;
    return VisibilityTest(point, normal, direction, above, beside_squared, own, apart, own >= 0.0 && !is_above);
}

// Whether a ray can have seen what a pixel of a depth shows in its middle. What stands before the hit and far beside the
// ray stands elsewhere in the reflection. What stands behind the hit is beside it there, too. If the pixel that was hit shows the
// surface that reflects, the ray has met what stands on that surface, and nothing behind it counts. The surface that reflects is
// never seen, nor what is below it. Sky lies behind all.
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
