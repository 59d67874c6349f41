// The exchange of rays between the pixels of a block of 2 x 2 in fragment programs (gathered.glsl).

#ifndef UNIFIED_EXCHANGED_RAYS_GLSL
#define UNIFIED_EXCHANGED_RAYS_GLSL

#include "unified/gathered.glsl"

// The ray of the block's other pixel along an axis. `outward` is the asking pixel's direction out of the block along
// this axis.
NeighbourRay RayFromNeighbourX(NeighbourRay r, int outward) {
    return NeighbourRay(r.key - float(outward) * dFdxFine(r.key), r.color - float(outward) * dFdxFine(r.color));
}

NeighbourRay RayFromNeighbourY(NeighbourRay r, int outward) {
    return NeighbourRay(r.key - float(outward) * dFdyFine(r.key), r.color - float(outward) * dFdyFine(r.color));
}

#endif
