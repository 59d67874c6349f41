#version 460
// The resolve of wide lobes, over the tiles of their list.

#include "unified/parameters.glsl"
#include "unified/gloss_resolve.glsl"
