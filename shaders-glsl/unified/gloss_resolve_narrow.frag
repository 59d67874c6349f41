#version 460
// The resolve of narrow lobes, over the tiles of their list.

#define LIST NARROW_LIST
#include "unified/parameters.glsl"
#include "unified/gloss_resolve.glsl"
