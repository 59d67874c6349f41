#version 460
// The cone march through the volumes, with the hit-points for whoever measures them.

#define VOLUME
#define HITS
#include "poster/cone_march.glsl"
