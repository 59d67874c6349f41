#version 460
// The cone march through the volumes.

#define VOLUME
#include "poster/cone_march.glsl"
