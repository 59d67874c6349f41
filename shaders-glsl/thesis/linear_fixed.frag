#version 460
// `linear`: the first listing of 4.2.2, constant stride.

#define FIXED
#include "thesis/linear.glsl"
