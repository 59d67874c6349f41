#version 460
// The reflection of cells with wide lobes, over the tiles of their list.

#include "unified/parameters.glsl"
#include "unified/gloss_cells.glsl"
