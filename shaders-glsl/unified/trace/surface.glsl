// Tests which pixels of the screen a ray can have seen around its hit, and whether the ray leaves towards the sky.
// Needs the image `pyramid`. CPU twin: reference::unified::surface.

#ifndef UNIFIED_SURFACE_GLSL
#define UNIFIED_SURFACE_GLSL

#include "unified/trace/traverse.glsl"

// Whether a ray that hit nothing left through the far plane, if no other image is asked (without FOLLOWED). If so,
// `hit` gets the pixel and the position where it left. If the screen shows sky there, the ray sees this sky.
bool LeavesThroughFarPlane(Ray ray, inout Hit hit) {
    precise vec2 exit_position = ray.start + ray.end * ray.rate.xy;
    exit_position = clamp(exit_position, vec2(0.0), vec2(unified.size));
    ivec2 corner = ivec2(greaterThan(ray.inverse, vec2(0.0))) * unified.size;
    precise vec2 sides = (vec2(corner) - ray.start) * ray.inverse;
    bool leaves_far = !FOLLOWED && hit.code == PATH_MISS && ray.rate.z < 0.0 && ray.end < min(sides.x, sides.y);
    hit.pixel = leaves_far ? min(ivec2(exit_position), unified.size - 1) : hit.pixel;
    hit.position = leaves_far ? exit_position : hit.position;
    return leaves_far;
}

// The surface that reflects, its ray, and the pixel that the ray hit.
struct VisibilityTest {
    vec3 point;         // of the surface, in ViewPoint's scale
    vec3 normal;        // of any length
    vec3 direction;     // of the ray, of any length
    float least_height; // a place lies above the surface if Dot(normal, OffsetToPixel(...)) is greater
    float squared_gap;  // a place lies beside the ray if cross(direction, OffsetToPixel(...)) squared is greater
    float hit_depth;    // of the pixel that was hit; the front of EMPTY_BLOCK for sky
    float depth_gap;    // a pixel stands before or behind the hit if its depth differs from `hit_depth` by more
    bool is_reflector;  // the pixel that was hit shows the surface that reflects
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

// Makes the test for a surface's point and normal, a ray's direction, and the pixel that the ray hit, with its depth.
VisibilityTest MakeVisibilityTest(vec3 point, vec3 normal, vec3 direction, ivec2 pixel, float hit_depth) {
    precise float width = 2.0 * unified.pixel_to_view.y;
    precise float gap = STANDS_BESIDE * width;
    precise float squared_gap = gap * gap * Dot(direction, direction);
    precise float depth_gap = STANDS_BEFORE * width
                            * (ORTHOGRAPHIC ? unified.depth_offset : hit_depth + unified.depth_offset);
    bool is_reflector = ShowsReflector(point, normal, pixel, hit_depth);
    return VisibilityTest(point, normal, direction, ReflectorHeight(normal), squared_gap, hit_depth, depth_gap,
                          is_reflector);
}

// Whether a ray can have seen what a pixel of a depth shows at its centre `middle`. A surface that stands before the
// hit and far beside the ray is elsewhere in the reflection. A surface behind the hit is beside the hit in the
// reflection, too. If the pixel that was hit shows the surface that reflects, the ray has met a thing that stands on
// that surface, and nothing behind the hit counts. The ray never sees the surface that reflects, nor anything below it.
// Sky lies behind everything.
bool IsVisibleAlongRay(VisibilityTest test, vec2 middle, float depth) {
    vec3 away = OffsetToPixel(test.point, middle, depth);
    precise vec3 scaled_offset = away.yzx * test.direction.zxy - away.zxy * test.direction.yzx;
    precise float nearest_depth = test.hit_depth + test.depth_gap, farthest_depth = test.hit_depth - test.depth_gap;
    bool is_above = Dot(test.normal, away) > test.least_height;
    bool is_beside = Dot(scaled_offset, scaled_offset) > test.squared_gap;
    bool is_seen = test.hit_depth >= 0.0 && is_above && !(depth > nearest_depth && is_beside);
    return (depth < 0.0 || is_seen) && !(test.is_reflector && depth < farthest_depth);
}

#endif
