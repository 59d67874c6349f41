#version 460
// The resolve of wide lobes, where all that reflects has one.

#define LIST WIDE_LIST
#define WHOLE
#include "unified/parameters.glsl"
#include "unified/gloss_resolve.glsl"
