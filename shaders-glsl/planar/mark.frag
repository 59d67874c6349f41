#version 460
#pragma program(PlanarMark)
// Marks the pixels of a mirror in the stencil (thesis 3.1.2, first method, step 3). The reflective geometry comes from
// the G-buffer, which already leaves out hidden parts.

#include "planar/plane.glsl"

void main() {
    if (!OnPlane(ivec2(gl_FragCoord.xy)))
        discard;
}
