// How many rays of its own a pixel gets whose neighbours' rays say little of its reflection.

#ifndef TRIANGLES_OWN_RAYS_GLSL
#define TRIANGLES_OWN_RAYS_GLSL

layout(constant_id = 12) const int OWN_RAYS = 0; // 0: no pixel gets any

#endif
