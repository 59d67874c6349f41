// The captures of a scene and its sky, as passes read them. Directions are in world axes; places are relative to the
// camera's eye, in metres, so that large scenes lose no precision.

#ifndef CAPTURES_CAPTURES_GLSL
#define CAPTURES_CAPTURES_GLSL

#include "captures/cube.glsl"
#include "unified/view.glsl"

// Filled in by src/passes/lost.rs.
layout(std140, binding = 16) uniform CaptureBlock {
    mat4 view_to_world;          // the camera's; a rotation
    vec4 places[CAPTURE_SLOTS];  // from the eye to where each capture was made; w unused
    vec4 least;                  // from the eye to two corners of the scene's bounds, outside of which nothing stands; w unused
    vec4 greatest;
    int count;
    float view_unit;             // metres to one unit of ViewPoint: near (1 + k) of the camera, or 1 without perspective
    float face_unit;             // metres to one unit of ViewPoint for the cameras of faces
} captures;

layout(binding = 17) uniform sampler2DArray environment; // the faces of a cube map in world axes

// ToWorld turns a vector from view space to world axes, and ToView turns it back. Both functions add in the order of
// the CPU twin, and give the same bits in fragment and compute programs.
vec3 ToWorld(vec3 view) {
    mat3 m = mat3(captures.view_to_world);
    precise vec3 world = m[0] * view.x + m[1] * view.y + m[2] * view.z;
    return world;
}

vec3 ToView(vec3 world) {
    mat3 m = transpose(mat3(captures.view_to_world));
    precise vec3 view = m[0] * world.x + m[1] * world.y + m[2] * world.z;
    return view;
}

// The colour of the sky along a direction in world axes. The sky is smooth across the edges of its faces, and is
// sampled as six images, since a device without hardware for cube maps pays several times as much for seamless edges.
vec3 SampleSkyWorld(vec3 direction) {
    return Sound(textureLod(environment, CubeFaceUv(direction), 0.0).rgb);
}

#endif
