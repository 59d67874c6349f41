#version 460
// The reflection of cells with wide lobes, where all that reflects has one.

#define WHOLE
#include "unified/parameters.glsl"
#include "unified/gloss_cells.glsl"
