#version 460
// Across: from a slice of the volumes into plain images.

#define SOURCE sampler3D
#define READ(name, texCoord) textureLod(name, vec3(texCoord, blur.slice), 0.0)
#include "poster/blur.glsl"
