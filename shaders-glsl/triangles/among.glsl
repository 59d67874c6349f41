// What the ray of a pixel sees among the scene's triangles: one function for the rays of the list, and for those that no
// pass puts on it.

#ifndef TRIANGLES_AMONG_GLSL
#define TRIANGLES_AMONG_GLSL

#include "triangles/begin.glsl"

// What a ray saw, and where it ended.
struct Among {
    vec3 color;
    vec3 place; // relative to the eye, world axes; for the sky a point far along the ray
    int code;   // PATH_TRIANGLE or PATH_SKY
    uint met;   // number of the triangle; NO_TRIANGLE for the sky
};

// What a ray sees that meets a triangle or nothing; `width` measures its footprint there.
Among SeeMet(TreeRay ray, Met met, bool leaves, float width) {
    bool is_met = met.id != NO_TRIANGLE;
    vec3 color = ColorMet(ray, met, width);
    precise vec3 place = ray.origin + (is_met ? met.t : SKY_DISTANCE) * ray.direction - triangles.eye;
    uint number = is_met ? met.id & ~ASKS_MATERIAL : NO_TRIANGLE;
    return Among(leaves ? color : vec3(0.0), place, is_met ? PATH_TRIANGLE : PATH_SKY, number);
}

// The width of a ray's footprint that measures `spread` for each metre from where the ray begins: as in the references, all
// rays of a pixel leave from its one point. Where rays of sight are parallel, a pixel's rays stay as wide as the pixel.
float FootprintWidth(float spread, float metres) {
    return ORTHOGRAPHIC ? 2.0 * unified.pixel_to_view.y + spread * metres : spread * metres;
}

#ifndef CONFIRMED

// What a ray sees that begins on a pixel's triangle; `leaves` is that of BeginRay.
Among See(TreeRay ray, bool leaves, float spread) {
    Met met = Closest(ray);
    return SeeMet(ray, met, leaves, FootprintWidth(spread, met.t));
}

#endif

#endif
