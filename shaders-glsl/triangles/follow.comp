#version 460
#pragma program(TriangleMirrors: Tree, MIRRORS)
#pragma program(TriangleNarrow: Tree, NARROW)
#pragma program(TriangleWide: Tree)
#pragma program(TriangleMirrors: Query, MIRRORS, RAY_QUERY)
#pragma program(TriangleNarrow: Query, NARROW, RAY_QUERY)
#pragma program(TriangleWide: Query, RAY_QUERY)
// Follows the rays of the list through the scene's triangles, a thread a ray, each from its own pixel's point, and
// stores what they see (captures/finish.glsl).

#ifdef RAY_QUERY
#extension GL_EXT_ray_query : require
#endif

#define LIST_ACCESS readonly
#include "captures/lost.glsl"

layout(local_size_x = LOST_GROUP) in;

#include "captures/finish.glsl"
#include "triangles/among.glsl"

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= lost_counts.count)
        return;
    LostRay ray = lost.rays[index];
    bool is_outward;
    TreeRay tree_ray = SpawnRay(ray.start, ray.direction, ray.pixel.z, is_outward);
    TriangleRayResult result = TraceTriangles(tree_ray, is_outward, ray.spread);
    StoreRayResult(ray, RayResult(result.color, true, result.place, result.code, result.triangle));
}
