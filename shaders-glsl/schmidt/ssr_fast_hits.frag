#version 460
// `ssr-fast` with its hits beside.

#define OPTIMIZED
#define HITS
#include "schmidt/screen_space_reflections.glsl"
