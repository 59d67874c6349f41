#version 460
#pragma program(Convert)
// Converts the G-buffer to the form that a user's shader asks for (docs/custom-methods.md).

#include "common/camera.glsl"
#include "common/constants.glsl"
#include "common/octahedral.glsl"

layout(binding = 1) uniform sampler2D depth_buffer;   // reversed
layout(binding = 2) uniform sampler2D normal_buffer;  // view space

layout(std140, binding = 3) uniform ConvertBlock {
    mat4 clip_to_clip_before; // from this frame's clip space to that of the frame before, reversed depth
    mat4 axes;                // from this program's axes to those of the shader
    int what;                 // CONVERT_*
} convert;

layout(location = 0) out vec4 value;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(depth_buffer, pixel, 0).r;
    vec3 normal = texelFetch(normal_buffer, pixel, 0).xyz;
    vec2 uv = gl_FragCoord.xy / camera.resolution;
    vec4 ndc = vec4(uv * vec2(2.0, -2.0) + vec2(-1.0, 1.0), depth, 1.0);

    value = vec4(0.0);
    if (convert.what == CONVERT_LINEAR_DEPTH) {
        mat4 m = camera.clip_to_view_reversed;
        float z = (m[2][2] * depth + m[3][2]) / (m[2][3] * depth + m[3][3]);
        value.r = depth > 0.0 ? z : camera.far_plane;
    } else if (convert.what == CONVERT_REVERSED_DEPTH) {
        value.r = depth;
    } else if (convert.what == CONVERT_MOTION) {
        // The sky is as far away as the far plane.
        vec4 before = convert.clip_to_clip_before * ndc;
        vec2 uv_before = before.xy / before.w * vec2(0.5, -0.5) + 0.5;
        value.rg = before.w > 0.0 ? uv - uv_before : vec2(0.0);
    } else if (convert.what >= CONVERT_VIEW_PLACE) {
        vec4 place = camera.clip_to_view_reversed * ndc;
        place /= place.w;
        if (convert.what == CONVERT_WORLD_PLACE)
            place = camera.view_to_world * place;
        value = depth > 0.0 ? vec4(mat3(convert.axes) * place.xyz, 1.0) : vec4(0.0);
    } else {
        bool in_world = convert.what >= CONVERT_WORLD_NORMAL;
        vec3 n = dot(normal, normal) > 0.0 ? normalize(normal) : vec3(0.0);
        n = mat3(convert.axes) * (in_world ? mat3(camera.view_to_world) * n : n);
        int encoding = convert.what - (in_world ? CONVERT_WORLD_NORMAL : CONVERT_VIEW_NORMAL);
        if (encoding == 0)
            value.xyz = n;
        else if (encoding == 1)
            value.xyz = n * 0.5 + 0.5;
        else {
            vec2 flat_map = n == vec3(0.0) ? vec2(0.0) : EncodeOctahedral(n);
            value.xy = encoding == 2 ? flat_map : flat_map * 0.5 + 0.5;
        }
    }
}
