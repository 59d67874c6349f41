#version 460
#pragma program(Nothing)
// Draws nothing and reads nothing: see gpu/frame/quirks/settle.rs.

void main() {}
