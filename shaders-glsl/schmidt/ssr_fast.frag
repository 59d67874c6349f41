#version 460
// `ssr-fast`: the march of listing 5.

#define OPTIMIZED
#include "schmidt/screen_space_reflections.glsl"
