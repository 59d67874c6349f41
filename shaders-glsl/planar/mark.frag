#version 460
#pragma program(PlanarMark)
// The stencil pattern of a mirror (thesis 3.1.2, first method, step 3). The reflective geometry is taken from the
// G-buffer, which already leaves out hidden parts.

#include "planar/plane.glsl"

void main() {
    if (!OnPlane(ivec2(gl_FragCoord.xy)))
        discard;
}
