// Hands on rays that the screen has lost, or that begin where no ray walks over the screen, to captures/follow.comp or
// triangles/follow.comp; and includes what a ray sees that hits on the screen. Needs the image `color_buffer`, and
// unified/traverse.glsl.

#ifndef CAPTURES_SEEN_GLSL
#define CAPTURES_SEEN_GLSL

#include "captures/color_seen.glsl"
#include "captures/push.glsl"

// Whether a ray that hit nothing ended in the sky.
bool EndsInSky(Ray ray, Hit hit) {
    return FOLLOWED && hit.code == PATH_MISS && WhyMissed(ray) == PATH_MISS_SKY;
}

layout(constant_id = 9) const bool TRIANGLES = false; // rays go on among triangles, from the pixel that they are of

layout(binding = 29, r32ui) uniform readonly uimage2D triangle_buffer; // of each pixel; one texel where none is known

// Hands on a ray from where it begins. `before` says how far its footprint has widened there, `spread` by how much it
// widens with each metre.
void PushFromPixel(uvec2 pixel, Ray ray, float before, float spread) {
    precise vec3 begin = ViewPoint(ray.start, ray.depth) * captures.view_unit;
    uint triangle = imageLoad(triangle_buffer, min(ray.pixel, imageSize(triangle_buffer) - 1)).x;
    Push(pixel, begin, ray.direction, before, spread, triangle);
}

// Hands on a ray of a pixel or cell if the screen lost it. `before` says how far the footprint has widened where the ray
// begins, `spread` by how much it widens with each metre.
void PushIfLost(uvec2 pixel, Ray ray, Hit hit, float before, float spread) {
    if (!FOLLOWED || hit.code == PATH_HI_Z)
        return;
    if (TRIANGLES) {
        PushFromPixel(pixel, ray, before, spread);
        return;
    }
    precise float depth = ray.depth + hit.s * ray.rate.z;
    precise vec2 at = ray.start + hit.s * ray.rate.xy;
    precise vec3 begin = ViewPoint(ray.start, ray.depth) * captures.view_unit;
    precise vec3 start = ViewPoint(at, max(depth, 0.0)) * captures.view_unit;
    Push(pixel, start, ray.direction, before + distance(begin, start), spread, NO_TRIANGLE);
}

#endif
