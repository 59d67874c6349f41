#version 460
#pragma program(Fullscreen)
// Half of a viewport, cut from corner to corner, whose upper left quarter is the target; drawn with three
// vertices and no buffer.

void main() {
    vec2 corner = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
    gl_Position = vec4(corner - 1.0, 0.0, 1.0);
}
