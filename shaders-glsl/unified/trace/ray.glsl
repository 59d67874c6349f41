// Rays in an image of the scene, and how the pixels of the screen begin them. CPU twin: reference::unified.

#ifndef UNIFIED_RAY_GLSL
#define UNIFIED_RAY_GLSL

#include "unified/view.glsl"

// A ray in the image: a straight line in (pixel x, pixel y, reversed depth), by a parameter s >= 0
// that counts pixels along the axis in which the ray moves faster.
//
// Divided by its view depth, the pixel's point has the clip image P = (ndc, depth, 1). A view-space
// direction d has D = (M_00 d_x, M_11 d_y, -k d_z, d_z), so that the exact derivative of the
// projected ray, (D.xyz P.w - P.xyz D.w) / P.w^2, is
//   (M_00 d_x - ndc.x d_z,  M_11 d_y - ndc.y d_z,  -(depth + k) d_z).
// The point at P + tD projects to P.xyz + s D' with s = t / (1 + t d_z). In these coordinates the six clip planes, |x|,
// |y| <= w and 0 <= z <= w, are the sides of a box, and the near plane is met before w = 0. So the homogeneous clip is
// a clip against the box, without its cancellation.
//
// If rays of sight are parallel, w is 1 everywhere, and depth changes with z alone: the derivative is
//   (M_00 d_x,  M_11 d_y,  -k d_z),  k = 1 / (far - near),
// and s is t itself.

struct Ray {
    vec2 start;     // continuous pixel coordinates: the centre of a pixel of the screen, any place of a face
    ivec2 pixel;    // the pixel that the ray begins in
    float depth;    // reversed depth there
    vec3 rate;      // change of x, y and depth with s; max(|x|, |y|) is 1
    vec2 inverse;   // 1 / rate.xy; where that is infinite, so large that no edge is ever reached
    float end;      // s at which the ray leaves the frustum
    vec3 direction; // in view space, of any length; for version 2 of the oracle
};

// Makes a ray from a place in a pixel along a view-space direction. `change` is this direction as a change of (ndc x,
// ndc y, depth); both may have any length. A ray that does not move in the image gets the `end` 0. It stays in its
// pixel, and the sign of its rate of depth says whether it goes to the near plane or the far plane.
Ray MakeRay(vec2 start, ivec2 pixel, float depth, vec3 direction, vec3 change) {
    Ray ray;
    ray.start = start;
    ray.pixel = pixel;
    ray.depth = depth;
    ray.direction = direction;
    precise vec2 moved = change.xy * vec2(unified.size) * vec2(0.5, -0.5);
    float fastest = max(abs(moved.x), abs(moved.y));
    if (!(fastest > 1e-30)) {
        ray.rate = vec3(0.0, 0.0, change.z);
        ray.inverse = vec2(NEVER);
        ray.end = 0.0;
        return ray;
    }
    precise float scale = 1.0 / fastest;
    precise vec2 rate = moved * scale;
    precise float depth_rate = change.z * scale;
    precise float depth_inverse = abs(depth_rate) > 1.0 / NEVER ? 1.0 / depth_rate : NEVER;
    precise vec2 inverse = vec2(abs(rate.x) > 1.0 / NEVER ? 1.0 / rate.x : NEVER,
                                abs(rate.y) > 1.0 / NEVER ? 1.0 / rate.y : NEVER);
    // The s of the screen's sides is computed by the same expression as that of every cell's sides (Advance). So a ray
    // ends, to the bit, where it leaves a cell by the screen's border.
    ivec2 side = ivec2(inverse.x > 0.0 ? unified.size.x : 0, inverse.y > 0.0 ? unified.size.y : 0);
    precise vec2 sides = (vec2(side) - start) * inverse;
    precise float plane = ((depth_inverse > 0.0 ? 1.0 : 0.0) - depth) * depth_inverse;
    ray.rate = vec3(rate, depth_rate);
    ray.inverse = inverse;
    ray.end = min(min(sides.x, sides.y), plane);
    return ray;
}

// Finds the view-space direction in which a pixel's centre is seen, with z = 1, and its ndc relative to the view's
// axis.
void PixelPoint(ivec2 pixel, out vec3 view, out vec2 ndc) {
    precise vec2 centre = vec2(2 * pixel.x + 1 - unified.size.x, unified.size.y - 2 * pixel.y - 1) - unified.shift;
    precise vec2 offset = centre * unified.pixel_to_view;
    precise vec2 ndc_offset = centre * unified.pixel_to_clip;
    view = ORTHOGRAPHIC ? vec3(0.0, 0.0, 1.0) : vec3(offset, 1.0);
    ndc = ndc_offset;
}

// The change of ndc along a view-space vector, from a point that is seen at `ndc`. In a perspective, this change and
// that of DepthChange are multiplied by the point's z, which keeps their ratio.
vec2 NdcChange(vec2 ndc, vec3 along) {
    if (ORTHOGRAPHIC) {
        precise vec2 parallel = unified.view_to_clip * along.xy;
        return parallel;
    }
    precise vec2 change = unified.view_to_clip * along.xy - ndc * along.z;
    return change;
}

// The change of reversed depth along a view-space vector with the component `z`, from a point of that depth. In a
// perspective, it is multiplied by the point's z, as in NdcChange.
float DepthChange(float depth, float z) {
    if (ORTHOGRAPHIC) {
        precise float linear = -(unified.depth_offset * z);
        return linear;
    }
    precise float change = -((depth + unified.depth_offset) * z);
    return change;
}

// The ray of a pixel along a view-space direction of any length.
Ray RayAlong(ivec2 pixel, float depth, vec3 direction) {
    vec3 view;
    vec2 ndc;
    PixelPoint(pixel, view, ndc);
    vec3 change = vec3(NdcChange(ndc, direction), DepthChange(depth, direction.z));
    return MakeRay(vec2(pixel) + 0.5, pixel, depth, direction, change);
}

// The ray of a pixel along its mirror direction v + factor n, with factor = -2 (v.n) / (n.n). Here v is the direction
// in which the pixel is seen, and n the normal, of any length. v itself projects to a point and drops out of the
// derivative. What remains has no difference of nearly equal numbers, however flat the ray meets the surface.
// `is_front` becomes false if the pixel is seen from behind its normal, so that the ray goes below the surface.
Ray MirrorRay(ivec2 pixel, float depth, vec3 normal, out bool is_front) {
    vec3 view;
    vec2 ndc;
    PixelPoint(pixel, view, ndc);
    precise float along_normal = view.x * normal.x + view.y * normal.y + normal.z;
    precise float squared = normal.x * normal.x + normal.y * normal.y + normal.z * normal.z;
    precise float factor = -2.0 * along_normal * (1.0 / squared);
    precise vec2 change = NdcChange(ndc, normal) * factor;
    precise float direction_z = 1.0 + factor * normal.z;
    precise vec3 direction = view + factor * normal;
    is_front = along_normal < 0.0;
    vec3 image_change = vec3(change, DepthChange(depth, direction_z));
    return MakeRay(vec2(pixel) + 0.5, pixel, depth, direction, image_change);
}

#endif
