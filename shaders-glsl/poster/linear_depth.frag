#version 460
#pragma program(LinearDepth)
// Linear depth of the G-buffer: view-space z in metres, that of the far plane for the sky.

#include "common/camera.glsl"

layout(binding = 1) uniform sampler2D depth_buffer; // reversed depth

layout(location = 0) out float out_depth;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 clip = gl_FragCoord.xy / camera.resolution * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    vec4 position = camera.clip_to_view_reversed * vec4(clip, texelFetch(depth_buffer, pixel, 0).r, 1.0);
    out_depth = min(position.z / position.w, camera.far_plane);
}
