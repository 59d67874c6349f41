#version 460
#pragma program(Fullscreen)
// A triangle over half of a viewport, cut from corner to corner. The upper left quarter of the viewport is the target.
// The triangle is drawn with three vertices and no buffer.

void main() {
    vec2 corner = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
    gl_Position = vec4(corner - 1.0, 0.0, 1.0);
}
