#version 460
// `sslr`, stage 1 (4.3.1).

#include "thesis/sslr_ray_trace.glsl"
