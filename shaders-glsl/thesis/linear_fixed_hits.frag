#version 460
// `linear`: the first listing of 4.2.2, constant stride, with the intersections for whoever measures them.

#define FIXED
#define HITS
#include "thesis/linear.glsl"
