#version 460
// Draws nothing and reads nothing: see gpu/frame/settle.rs.

void main() {}
