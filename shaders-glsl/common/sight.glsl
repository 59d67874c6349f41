// The kind of the camera's projection, and what depends on it: sight and reach.

#ifndef COMMON_SIGHT_GLSL
#define COMMON_SIGHT_GLSL

#ifdef FACES
const bool ORTHOGRAPHIC = false; // faces of captures are perspectives
#else
layout(constant_id = 15) const bool ORTHOGRAPHIC = false; // rays of sight are parallel, and depth is linear in z
#endif

// The direction in view space, of any length, in which a point is seen.
vec3 ViewDirection(vec3 point) {
    return ORTHOGRAPHIC ? vec3(0.0, 0.0, 1.0) : point;
}

// The length in metres of which tolerances of depth are shares (scene::Camera::reach_m): z itself, or the height of the
// image if rays of sight are parallel. A pixel is then as wide at every z.
float Reach(float z, mat4 clip_to_view) {
    return ORTHOGRAPHIC ? 2.0 * clip_to_view[1][1] : z;
}

#endif
