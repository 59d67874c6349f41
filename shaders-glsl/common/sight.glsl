// The kind of the camera's projection, where it decides how points are seen.

#ifndef COMMON_SIGHT_GLSL
#define COMMON_SIGHT_GLSL

#ifdef FACES
const bool ORTHOGRAPHIC = false; // faces of captures are perspectives
#else
layout(constant_id = 15) const bool ORTHOGRAPHIC = false; // rays of sight are parallel, and depth is linear in z
#endif

// The direction in view space, of any length, in which a point of it is seen.
vec3 ViewDirection(vec3 point) {
    return ORTHOGRAPHIC ? vec3(0.0, 0.0, 1.0) : point;
}

// Metres that shares of a view-space z are shares of (scene::Camera::reach_m): the height of the image where rays of sight
// are parallel, since a pixel is as wide at every z.
float Reach(float z, mat4 clip_to_view) {
    return ORTHOGRAPHIC ? 2.0 * clip_to_view[1][1] : z;
}

#endif
