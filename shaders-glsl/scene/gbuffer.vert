#version 460
#pragma program(GBufferVertex)
// Transforms the scene's vertices for the G-buffer (docs/definitions.md, "Spaces" and "Surfaces").

#include "common/camera.glsl"
#include "scene/draw.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 3) in vec4 tangent;

// The passes for depth alone and for the G-buffer must compute the same position to the bit.
invariant gl_Position;

layout(location = 0) out vec3 out_normal;   // view space
layout(location = 1) out vec2 out_uv;
layout(location = 2) out vec4 out_tangent;  // view space; w is the bitangent's sign
layout(location = 3) flat out uint out_last_triangle; // the number of the mesh's last triangle among the scene's; it is drawn first

// Turns a direction by the mesh's quaternion; the quaternion (0, 0, 0, 1) changes no bit.
vec3 RotateToWorld(vec3 v) {
    return v + 2.0 * cross(draw.turn.xyz, cross(draw.turn.xyz, v) + draw.turn.w * v);
}

void main() {
    gl_Position = draw.world_to_clip * vec4(position, 1.0);
    out_normal = mat3(camera.world_to_view) * RotateToWorld(normal);
    out_uv = uv;
    // A mesh is drawn as one instance, whose index is the number of its last triangle.
    out_last_triangle = uint(gl_InstanceIndex);
    // A mirrored view reverses the handedness of a tangent space.
    mat3 turn = mat3(camera.world_to_view);
    out_tangent = vec4(turn * RotateToWorld(tangent.xyz), tangent.w * sign(determinant(turn)));
}
