#version 460
// The cone march through the mip chains, with the hit-points for whoever measures them.

#define HITS
#include "poster/cone_march.glsl"
