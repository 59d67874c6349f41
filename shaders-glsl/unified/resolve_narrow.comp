#version 460
#pragma program(ResolveNarrow)
// The reflections of pixels with narrow lobes, a thread a pixel, over tiles or over the whole image.

#include "unified/groups.glsl"
#include "unified/resolve_narrow.glsl"
#include "unified/store.glsl"

#define REACH 1
#include "unified/shared_rays.glsl"

NeighbourRay LoadGatheredRay(ivec2 pixel) {
    return LoadNeighbourRay(pixel);
}

// The ray of a pixel of the block. A pixel beyond the border of the image has none.
NeighbourRay LoadPixelRay(ivec2 pixel) {
    if (IsInside(pixel, 0))
        return SharedRay(pixel);
    return UnpackNeighbourRay(NO_RECORD);
}

// The ray of a pixel of the block, or of one outside of it.
NeighbourRay LoadBlockRay(ivec2 pixel, bool in_block) {
    if (in_block)
        return LoadPixelRay(pixel);
    return SharedRay(pixel);
}

// Each ray is made by itself, so that the loop holds no other ray.
void GatherNeighbours(inout RayStatistics statistics, NeighbourRay own, ivec2 pixel) {
    ivec2 outward = DirectionOutOfBlock(pixel);
    ivec2 x = ivec2(outward.x, 0), y = ivec2(0, outward.y);
    for (int n = 1; n < 9; ++n) {
        // Bits of the rays that other pixels of the block hand on, along x and along y.
        bool across_x = (0x8a >> n & 1) != 0, across_y = (0x2c >> n & 1) != 0, in_block = n < 4;
        ivec2 first = pixel + (n == 4 || n == 5 || n == 8 ? x : ivec2(0)) + (n >= 6 ? y : ivec2(0));
        NeighbourRay ray = LoadBlockRay(first, in_block);
        if (across_x)
            ray = RayFromNeighbour(ray, LoadBlockRay(first - x, in_block), outward.x);
        if (across_y) {
            NeighbourRay other = LoadBlockRay(first - y, in_block);
            if (across_x)
                other = RayFromNeighbour(other, LoadBlockRay(first - outward, in_block), outward.x);
            ray = RayFromNeighbour(ray, other, outward.y);
        }
        GatherRay(statistics, own, ray);
    }
}

void main() {
    ivec2 pixel;
    if (!ThreadTexel(NARROW_LIST, 0, pixel))
        return;
    LoadSharedRays(pixel);
    PixelOutput result;
    if (!IsInside(pixel, 0) || !ShadePixel(pixel, result))
        return;
    StorePixel(pixel, result.color, result.reflection);
}
