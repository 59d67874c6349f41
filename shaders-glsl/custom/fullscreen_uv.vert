#version 460
#pragma program(FullscreenUv)
// The triangle of common/fullscreen.vert, with texture coordinates for a user's fragment shader: (0, 0) is the upper
// left corner of the target.

layout(location = 0) out vec2 uv;

void main() {
    vec2 corner = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
    uv = corner;
    gl_Position = vec4(corner - 1.0, 0.0, 1.0);
}
