#version 460
// The resolve of a frame with narrow lobes and mirrors only.

#define NARROW_LOBES
#include "unified/parameters.glsl"
#include "unified/gloss_resolve.glsl"
