#version 460
// `ssr`: the march of listing 4.

#include "schmidt/screen_space_reflections.glsl"
