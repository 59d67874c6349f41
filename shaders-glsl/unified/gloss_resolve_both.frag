#version 460
// The resolve of a frame with lobes of any width.

#define NARROW_LOBES
#define WIDE_LOBES
#include "unified/parameters.glsl"
#include "unified/gloss_resolve.glsl"
