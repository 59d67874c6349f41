#version 460
#pragma program(LinearDepth)
#pragma program(LinearDepthVolume, VOLUME)
#pragma in_either_stage
// Writes the linear depth of the G-buffer: view-space z in metres, and for sky the z of the far plane. With VOLUME the
// target is the first slice of a volume.

#if defined(COMPUTE) && defined(VOLUME)
#define OUTPUT_IMAGE image3D
#define OUTPUT_TEXEL ivec3(ivec2(gl_GlobalInvocationID.xy), 0)
#endif

#include "common/either_stage.glsl"
#include "common/camera.glsl"

layout(binding = 1) uniform sampler2D depth_buffer; // reversed depth

OUTPUT(0, r32f, float, out_depth);

SHADE(out_depth) {
    ivec2 pixel = ivec2(PIXEL_CENTRE);
    vec2 clip = PIXEL_CENTRE / camera.resolution * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    vec4 position = camera.clip_to_view_reversed * vec4(clip, texelFetch(depth_buffer, pixel, 0).r, 1.0);
    out_depth = min(position.z / position.w, camera.far_plane);
}
