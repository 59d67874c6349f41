#version 460
// Rays of narrow lobes: see gloss_narrow.glsl.

#include "unified/parameters.glsl"
#include "unified/gloss_narrow.glsl"
