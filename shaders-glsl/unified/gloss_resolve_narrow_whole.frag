#version 460
// The resolve of narrow lobes, where all that reflects has one.

#define LIST NARROW_LIST
#define WHOLE
#include "unified/parameters.glsl"
#include "unified/gloss_resolve.glsl"
