#version 460
// The resolve of a frame with wide lobes only.

#define WIDE_LOBES
#include "unified/parameters.glsl"
#include "unified/gloss_resolve.glsl"
