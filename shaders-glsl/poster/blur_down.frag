#version 460
// Down: from the plain images into the next slice.

#define SOURCE sampler2D
#define READ(name, texCoord) textureLod(name, texCoord, 0.0)
#include "poster/blur.glsl"
