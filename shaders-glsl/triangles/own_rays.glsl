// The number of own rays that a pixel in doubt gets.

#ifndef TRIANGLES_OWN_RAYS_GLSL
#define TRIANGLES_OWN_RAYS_GLSL

layout(constant_id = 12) const int OWN_RAYS = 0; // 0: no pixel gets any

#endif
