#version 460
// `linear`: the second listing of 4.2.2, growing stride and binary search.

#include "thesis/linear.glsl"
