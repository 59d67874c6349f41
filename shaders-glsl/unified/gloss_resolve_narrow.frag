#version 460
// The resolve of narrow lobes, over the tiles of their list.

#include "unified/parameters.glsl"
#include "unified/gloss_resolve_narrow.glsl"
