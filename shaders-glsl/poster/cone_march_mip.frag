#version 460
// The cone march through the mip chains.

#include "poster/cone_march.glsl"
