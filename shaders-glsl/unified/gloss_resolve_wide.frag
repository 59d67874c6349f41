#version 460
// The resolve of wide lobes, over the tiles of their list.

#define LIST WIDE_LIST
#include "unified/parameters.glsl"
#include "unified/gloss_resolve.glsl"
