#version 460
// `ssr` with its hits beside.

#define HITS
#include "schmidt/screen_space_reflections.glsl"
