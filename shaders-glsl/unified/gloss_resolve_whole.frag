#version 460
// The resolve of wide lobes, where all that reflects has one.

#define WHOLE
#include "unified/parameters.glsl"
#include "unified/gloss_resolve.glsl"
