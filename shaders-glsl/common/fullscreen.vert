#version 460
#pragma program(Fullscreen)
// A triangle that covers the whole target, drawn with three vertices and no buffer. The viewport is twice as wide and
// twice as high as the target, which is its upper left quarter. The triangle is the viewport's upper left half.

void main() {
    vec2 corner = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
    gl_Position = vec4(corner - 1.0, 0.0, 1.0);
}
