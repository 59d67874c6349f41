// Tests whether a pixel reflects and its point lies in the plane of a mirror. The test replaces a mesh of the mirror.

#include "common/camera.glsl"
#include "common/constants.glsl"

layout(push_constant) uniform PlaneBlock {
    vec4 plane; // view space: unit normal and offset, 0 = dot(plane.xyz, position) + plane.w
} mirror;

layout(binding = 1) uniform sampler2D depth_buffer;    // reversed
layout(binding = 2) uniform sampler2D material_buffer; // reflectivity, roughness

// A point is on another surface if it lies off the plane by more than ON_PLANE_M metres plus the share ON_PLANE_SHARE
// of its depth. Triangles of a plane lie in it to within TOLERANCE_M of scene/planes.rs, and a reversed 32-bit depth
// gives a point to about 1e-6 of its depth.
#define ON_PLANE_M 2e-3
#define ON_PLANE_SHARE 5e-5

// Whether a pixel reflects, and its point lies in the mirror's plane.
bool OnPlane(ivec2 pixel) {
    float depth = texelFetch(depth_buffer, pixel, 0).r;
    if (depth <= 0.0 || texelFetch(material_buffer, pixel, 0).r <= REFLECTS_ABOVE)
        return false;
    vec2 ndc = (vec2(pixel) + 0.5) / camera.resolution * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    vec4 h = camera.clip_to_view_reversed * vec4(ndc, depth, 1.0);
    vec3 position = h.xyz / h.w;
    return abs(dot(mirror.plane.xyz, position) + mirror.plane.w) <= ON_PLANE_M + ON_PLANE_SHARE * position.z;
}
