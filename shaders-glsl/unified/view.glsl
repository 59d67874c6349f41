// From the image to view space, for both kinds of projection. CPU twin: reference::unified.

#ifndef UNIFIED_VIEW_GLSL
#define UNIFIED_VIEW_GLSL

#include "common/sight.glsl"
#include "unified/parameters.glsl"

// How far continuous pixel coordinates lie off the axis of the view, in metres: at z = 1 m, or at any z if rays of
// sight are parallel.
vec2 OffAxis(vec2 position) {
    precise vec2 centred = vec2(2.0 * position.x - float(unified.size.x), float(unified.size.y) - 2.0 * position.y)
                         - unified.shift;
    precise vec2 view = centred * unified.pixel_to_view;
    return view;
}

// The view-space direction in which continuous pixel coordinates are seen; z is 1.
vec3 ViewRay(vec2 position) {
    return ORTHOGRAPHIC ? vec3(0.0, 0.0, 1.0) : vec3(OffAxis(position), 1.0);
}

// Converts continuous pixel coordinates and reversed depth to a point in view space. With a perspective camera the
// point in metres is divided by near * (1 + k), where k is unified.depth_offset; this changes no direction. With an
// orthographic camera it is in metres.
vec3 ViewPoint(vec2 position, float depth) {
    if (ORTHOGRAPHIC) {
        precise float z = (unified.depth_origin - depth) / unified.depth_offset;
        return vec3(OffAxis(position), z);
    }
    precise vec3 point = ViewRay(position) / (depth + unified.depth_offset);
    return point;
}

// By how much the footprint of a mirror's ray, which is that of its pixel, widens with each metre. For an orthographic
// projection the eye is taken to be very far away.
float PixelSpread() {
    return ORTHOGRAPHIC ? 2.0 * unified.pixel_to_view.y / FAR_EYE : 2.0 * unified.pixel_to_view.y;
}

#endif
