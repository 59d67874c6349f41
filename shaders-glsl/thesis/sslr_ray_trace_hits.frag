#version 460
// `sslr`, stage 1 (4.3.1), with the intersections for whoever measures them.

#define HITS
#include "thesis/sslr_ray_trace.glsl"
