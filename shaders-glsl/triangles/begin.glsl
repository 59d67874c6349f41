// Begins a reflected ray on the triangle that its pixel shows, off the triangle's plane by no more than rounding makes
// necessary. So the ray neither meets that plane again nor begins behind a thing that stands close before the plane.

#ifndef TRIANGLES_BEGIN_GLSL
#define TRIANGLES_BEGIN_GLSL

#include "triangles/color.glsl"

// Finds the slot of a triangle's corners. False, with slot 0, if the number is not that of a triangle with an area.
bool FindTriangleSlot(uint triangle, out uint slot) {
    bool is_known = triangle < uint(triangles.count);
    slot = Attribute(is_known ? triangle : 0u, 2).w;
    is_known = is_known && slot != NO_TRIANGLE;
    slot = is_known ? slot : 0u;
    return is_known;
}

// The point a + u (b - a) + v (c - a) of the triangle of a slot that a ray of sight in the direction `towards` meets.
// This ray begins at the eye, or if rays of sight are parallel, at `from` relative to the eye. Rounding moves the point
// along each axis by no more than `error`. The last addition moves it by half a unit in the last place of the point.
// The differences, products and the other addition move it by 5 half units of each edge's part (Higham, "Accuracy and
// Stability of Numerical Algorithms", 2002, section 3.1).
vec3 PointOfTriangle(uint slot, vec3 from, vec3 towards, out vec3 flat_normal, out vec3 error) {
    int corner = triangles.corners + 3 * int(slot);
    vec3 a = uintBitsToFloat(Geometry(corner).xyz);
    precise vec3 along_b = uintBitsToFloat(Geometry(corner + 1).xyz) - a;
    precise vec3 along_c = uintBitsToFloat(Geometry(corner + 2).xyz) - a;
    precise vec3 eye = ORTHOGRAPHIC ? triangles.eye + from : triangles.eye;
    precise vec3 from_eye = a - eye;
    vec3 normal = cross(along_b, along_c);
    float u = dot(towards, cross(along_c, from_eye)), v = dot(towards, cross(from_eye, along_b));
    float inverse = 1.0 / dot(towards, normal);
    // For a triangle that is seen edge-on, or that has no area, u and v may be of any size. The clamp keeps the point
    // near the triangle.
    vec2 weight = clamp(vec2(u, v) * inverse, 0.0, 1.0);
    precise vec3 offset = weight.x * along_b + weight.y * along_c;
    precise vec3 point = a + offset;
    flat_normal = normal * inversesqrt(max(dot(normal, normal), 1e-38));
    error = ROUNDING * (abs(point) + 5.0 * (abs(weight.x * along_b) + abs(weight.y * along_c)));
    return point;
}

// Makes the ray from a pixel's point, which lies at `start` relative to the eye, along a unit direction; both have
// world axes. `triangle` is the one that the pixel shows; with NO_TRIANGLE the ray begins at the point itself.
// `is_outward` becomes false for a ray that leads below the triangle that it begins on, where there is nothing to see
// (docs/definitions.md, "Surfaces").
TreeRay SpawnRay(vec3 start, vec3 direction, uint triangle, out bool is_outward) {
    vec3 flat_normal, error;
    uint slot;
    bool is_known = FindTriangleSlot(triangle, slot);
    // A parallel ray of sight may begin anywhere along its line, and does so best near the triangle.
    vec3 sight = ORTHOGRAPHIC ? captures.view_to_world[2].xyz : start;
    vec3 point = PointOfTriangle(slot, start, sight, flat_normal, error);
    float normal_sign = dot(flat_normal, direction) >= 0.0 ? 1.0 : -1.0;
    is_outward = !is_known || normal_sign * dot(flat_normal, sight) < 0.0;
    // The error counts twice: for the point, and for the corners of neighbouring triangles in the same plane.
    precise vec3 origin = point + normal_sign * (2.0 * dot(error, abs(flat_normal))) * flat_normal;
    uint own_number = Geometry(triangles.corners + 3 * int(slot)).w;
    // A rasteriser interpolates depth between corners that may lie at the near plane, where depth is 1. So depth errs
    // by a few half units in the last place of 1. Depth is unit / z, so that an error of depth, times z z / unit, is
    // one in metres. If depth is linear in z, the factor is the distance between the planes.
    float depth_error = ORTHOGRAPHIC ? 4.0 * ROUNDING / unified.depth_offset
                                     : 4.0 * ROUNDING * dot(start, start) / captures.view_unit;
    // A rasteriser also rounds the corners' places on the screen, and a pixel that stands for a block has the depth of
    // the block's first pixel. Both place the point beside the surface.
    depth_error += triangles.beside * (ORTHOGRAPHIC ? captures.view_unit : length(start));
    return MakeTreeRay(is_known ? origin : start + triangles.eye, direction, is_known ? own_number : NO_TRIANGLE,
                       is_known ? 0.0 : depth_error);
}

#endif
