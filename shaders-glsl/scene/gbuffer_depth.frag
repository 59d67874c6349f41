#version 460
#pragma program(GBufferDepth)
// Depth of the nearest surface alone, of meshes without an alpha mask. What the G-buffer then shades is what is seen.

#include "common/camera.glsl"
#include "common/constants.glsl"
#include "scene/draw.glsl"
#include "scene/side.glsl"

void main() {
    if (IsInvisibleBack(IsSeenFromBehind()))
        discard;
}
