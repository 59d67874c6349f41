// The exchange of rays between the pixels of a block of 2 x 2 in fragment programs (gathered.glsl).

#ifndef UNIFIED_EXCHANGED_RAYS_GLSL
#define UNIFIED_EXCHANGED_RAYS_GLSL

#include "unified/resolve/gathered.glsl"

// The ray of the block's other pixel along an axis. `outward` is the asking pixel's direction out of the block along
// this axis.
NeighbourRay RayFromNeighbourX(NeighbourRay ray, int outward) {
    return NeighbourRay(ray.key - float(outward) * dFdxFine(ray.key), ray.color - float(outward) * dFdxFine(ray.color));
}

NeighbourRay RayFromNeighbourY(NeighbourRay ray, int outward) {
    return NeighbourRay(ray.key - float(outward) * dFdyFine(ray.key), ray.color - float(outward) * dFdyFine(ray.color));
}

#endif
