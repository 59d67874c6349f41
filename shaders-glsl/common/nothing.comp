#version 460
// Computes nothing and reads nothing: see gpu/frame/settle.rs.

layout(local_size_x = 1) in;

void main() {}
