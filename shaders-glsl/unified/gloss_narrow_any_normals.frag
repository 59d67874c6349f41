#version 460
// As gloss_narrow.frag, with normals of any format: for studies, not for speed.

#define ANY_NORMALS
#include "unified/parameters.glsl"
#include "unified/gloss_narrow.glsl"
