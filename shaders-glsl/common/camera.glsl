// The camera as every pass sees it; spaces and axes as in docs/definitions.md, "Spaces".

layout(std140, binding = 0) uniform CameraBlock {
    mat4 view_to_clip;          // standard depth: near 0, far 1
    mat4 clip_to_view;
    mat4 view_to_clip_reversed; // reversed depth: near 1, far 0
    mat4 clip_to_view_reversed;
    mat4 world_to_view;
    mat4 view_to_world;
    vec2 resolution;            // pixels
    float near_plane;           // metres
    float far_plane;
} camera;
