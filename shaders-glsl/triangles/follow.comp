#version 460
#pragma program(TriangleMirrors, MIRRORS)
#pragma program(TriangleNarrow, NARROW)
#pragma program(TriangleWide)
// Follows the rays of the list through the scene's triangles, a thread a ray, each from its own pixel's point, and puts
// what they see where the ray is of.

#define LOST_ACCESS readonly
#include "captures/lost.glsl"

layout(local_size_x = LOST_GROUP) in;

#include "captures/finish.glsl"
#include "triangles/begin.glsl"

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= lost_counts.count)
        return;
    LostRay lost_ray = lost.rays[index];
    bool leaves;
    TreeRay ray = BeginRay(lost_ray.start, lost_ray.direction, lost_ray.pixel.z, leaves);
    Met met = Closest(ray);
    bool is_met = met.id != NO_TRIANGLE;
    vec3 color = ColorMet(ray, met, lost_ray.spread * (lost_ray.before + met.t));
    precise vec3 place = ray.origin + met.t * ray.direction - triangles.eye;
    Finish(lost_ray, Saw(leaves ? color : vec3(0.0), true, place, is_met ? PATH_TRIANGLE : PATH_SKY));
}
