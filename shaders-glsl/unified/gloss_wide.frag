#version 460
// Rays of wide lobes: see gloss_wide.glsl.

#include "unified/parameters.glsl"
#include "unified/gloss_wide.glsl"
