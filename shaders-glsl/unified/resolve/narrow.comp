#version 460
#pragma program(ResolveNarrow)
// The reflections of pixels with narrow lobes, a thread a pixel, over tiles or over the whole image.

#include "unified/groups.glsl"
#include "unified/resolve/narrow.glsl"
#include "unified/store.glsl"

#define REACH 1
#include "unified/resolve/shared_rays.glsl"

NeighbourRay LoadGatheredRay(ivec2 pixel) {
    return LoadNeighbourRay(pixel);
}

// The ray of a pixel of the block. A pixel beyond the border of the image has none.
NeighbourRay LoadPixelRay(ivec2 pixel) {
    if (IsInside(pixel, 0))
        return SharedRay(pixel);
    return UnpackNeighbourRay(NO_RECORD);
}

// The ray of a pixel that lies in the block or, without `in_block`, outside of it.
NeighbourRay LoadBlockRay(ivec2 pixel, bool in_block) {
    if (in_block)
        return LoadPixelRay(pixel);
    return SharedRay(pixel);
}

// Gathers the rays of the eight neighbours. Neighbours 1 to 3 are in the block, 4 and 5 beside it along x, 6 and 7
// beside it along y, and 8 is at its corner. Each ray is made when it is needed, so that the loop holds no other ray.
void GatherNeighbours(inout RayStatistics statistics, NeighbourRay own_ray, ivec2 pixel) {
    ivec2 outward = DirectionOutOfBlock(pixel);
    ivec2 step_x = ivec2(outward.x, 0), step_y = ivec2(0, outward.y);
    for (int n = 1; n < 9; ++n) {
        // Bit n of a mask says that the block's other pixel hands on ray n: along x 1, 3 and 7, along y 2, 3 and 5.
        bool is_handed_x = (0x8a >> n & 1) != 0, is_handed_y = (0x2c >> n & 1) != 0, in_block = n < 4;
        ivec2 first = pixel + (n == 4 || n == 5 || n == 8 ? step_x : ivec2(0)) + (n >= 6 ? step_y : ivec2(0));
        NeighbourRay ray = LoadBlockRay(first, in_block);
        if (is_handed_x)
            ray = RayFromNeighbour(ray, LoadBlockRay(first - step_x, in_block), outward.x);
        if (is_handed_y) {
            NeighbourRay ray_beyond_y = LoadBlockRay(first - step_y, in_block);
            if (is_handed_x)
                ray_beyond_y = RayFromNeighbour(ray_beyond_y, LoadBlockRay(first - outward, in_block), outward.x);
            ray = RayFromNeighbour(ray, ray_beyond_y, outward.y);
        }
        GatherRay(statistics, own_ray, ray);
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
