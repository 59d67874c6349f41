#version 460
// `linear`: the second listing of 4.2.2, growing stride and binary search, with the
// intersections for whoever measures them.

#define HITS
#include "thesis/linear.glsl"
