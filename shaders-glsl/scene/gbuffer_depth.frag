#version 460
#pragma program(GBufferDepth)
// Draws nothing but the depth of the nearest surface, of meshes without an alpha mask, so that the G-buffer then shades
// visible surfaces alone.

#include "common/camera.glsl"
#include "common/constants.glsl"
#include "scene/draw.glsl"
#include "scene/side.glsl"

void main() {
    if (IsInvisibleBack(IsSeenFromBehind()))
        discard;
}
