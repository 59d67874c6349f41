#version 460
// The resolve of narrow lobes, where all that reflects has one.

#define WHOLE
#include "unified/parameters.glsl"
#include "unified/gloss_resolve_narrow.glsl"
