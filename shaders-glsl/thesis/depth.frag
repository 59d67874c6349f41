#version 460
#pragma program(Depth)
// Level 0 of the Hi-Z buffer: the post-projected depth (thesis 4.2.1), here standard depth from
// the G-buffer's reversed depth (docs/definitions.md, "Spaces"), as minimum, and as maximum if that is kept.

layout(binding = 0) uniform sampler2D depth_buffer;

layout(location = 0) out vec2 min_max;

void main() {
    min_max = vec2(1.0 - texelFetch(depth_buffer, ivec2(gl_FragCoord.xy), 0).r);
}
