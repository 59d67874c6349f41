#version 460
#pragma program(ResolveNarrow)
// The reflections of pixels with narrow lobes, drawn over tiles as points or over the whole image.

layout(constant_id = 4) const bool WHOLE = false; // over the whole image, not over tiles

#include "unified/resolve/narrow.glsl"
#include "unified/resolve/exchanged_rays.glsl"

layout(location = 0) out vec4 out_color;
layout(location = 1) out vec4 out_reflection; // the reflection, where it is wanted beside the composite

NeighbourRay LoadPixelRay(ivec2 pixel) {
    // A block at the edge of an image of odd size reaches beyond the image.
    bool inside = all(lessThan(pixel, unified.size));
    return UnpackNeighbourRay(inside ? imageLoad(seen_image, pixel) : NO_RECORD);
}

void GatherNeighbours(inout RayStatistics statistics, NeighbourRay own_ray, ivec2 pixel) {
    ivec2 outward = DirectionOutOfBlock(pixel);
    // All loads stand first, since lavapipe takes longer if they stand between what is gathered.
    NeighbourRay beside = LoadNeighbourRay(pixel + ivec2(outward.x, 0));
    NeighbourRay under = LoadNeighbourRay(pixel + ivec2(0, outward.y));
    NeighbourRay corner = LoadNeighbourRay(pixel + outward);
    NeighbourRay across = RayFromNeighbourX(own_ray, outward.x);
    GatherRay(statistics, own_ray, across);
    GatherRay(statistics, own_ray, RayFromNeighbourY(own_ray, outward.y));
    GatherRay(statistics, own_ray, RayFromNeighbourY(across, outward.y));
    GatherRay(statistics, own_ray, beside);
    GatherRay(statistics, own_ray, RayFromNeighbourY(beside, outward.y));
    GatherRay(statistics, own_ray, under);
    GatherRay(statistics, own_ray, RayFromNeighbourX(under, outward.x));
    GatherRay(statistics, own_ray, corner);
}

void main() {
    PixelOutput result;
    if (!ShadePixel(ivec2(gl_FragCoord.xy), result))
        discard;
    out_color = result.color;
    out_reflection = result.reflection;
}
