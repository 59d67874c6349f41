// Stores what a ray of the list saw: finishes a mirror's pixel, or writes what a glossy ray saw into the images from
// which the pixels around gather. Programs with MIRRORS, with NARROW, and with neither of them (for wide lobes) include
// this file.

#ifndef CAPTURES_FINISH_GLSL
#define CAPTURES_FINISH_GLSL

#ifdef MIRRORS
layout(constant_id = 8) const bool COMPOSITE = false;  // the finished image is wanted
layout(constant_id = 6) const bool REFLECTION = false; // the reflection is wanted as an image of its own
layout(constant_id = 7) const bool HITS = false;       // the hits are wanted as an image of their own

layout(binding = 3, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness; of the screen
layout(binding = 5) uniform sampler2D color_buffer;                  // lit colour of the screen
layout(binding = 6, rgba16f) uniform writeonly image2D composite_image;  // without COMPOSITE, any image
layout(binding = 7, rgba16f) uniform writeonly image2D reflection_image; // without REFLECTION, any image
layout(binding = 8, rgba32f) uniform writeonly image2D hits_image;       // without HITS, any image of this format
#else
#include "unified/ends.glsl"
#ifdef NARROW
layout(binding = 6, rgba32ui) uniform uimage2D seen_image; // written by TraceNarrow
#else
layout(binding = 6, rgba32f) uniform image2D place_image; // written by TraceWide
layout(binding = 7, rgba16f) uniform writeonly image2D seen_image;
#endif
#endif

// What a lost ray saw.
struct RayResult {
    vec3 color;
    bool shows;    // false if the ray's end is unknown and another reflection shows instead
    vec3 place;    // where the ray ended, relative to the eye, world axes
    int code;      // PATH_*
    uint triangle; // the number of a triangle, or NO_TRIANGLE
};

#ifndef MIRRORS
// Packs how far a ray went from its pixel, in units of ViewPoint, and the triangle that it met (unified/ends.glsl).
uvec2 PackRayEnd(LostRay ray, vec3 place, uint triangle) {
    return uvec2(floatBitsToUint((ray.before + distance(ray.start, place)) / captures.view_unit), triangle);
}
#endif

// Stores the result of a lost ray in the images of its pixel or cell.
void StoreRayResult(LostRay ray, RayResult result) {
    ivec2 pixel = ivec2(ray.pixel.xy);
    // A point far along the ray stands for the sky.
    precise vec3 sky_place = ray.start + SKY_DISTANCE * ray.direction;
    vec3 place = result.code == PATH_SKY ? sky_place : result.place;
#ifdef MIRRORS
    bool is_known = result.code == PATH_SKY || result.code >= PATH_TRIANGLE;
    if (result.shows) {
        if (COMPOSITE) {
            float reflectivity = imageLoad(material_buffer, pixel).x;
            vec3 finished = texelFetch(color_buffer, pixel, 0).rgb + reflectivity * result.color;
            imageStore(composite_image, pixel, vec4(min(finished, GREATEST_HALF), 1.0));
        }
        if (REFLECTION)
            imageStore(reflection_image, pixel, vec4(result.color, 1.0));
    }
    if (HITS)
        imageStore(hits_image, pixel, vec4(is_known ? place : vec3(-1.0), float(result.code)));
#elif defined(NARROW)
    if (result.shows) {
        uvec4 words = imageLoad(seen_image, pixel);
        words.y &= 0x7fffffffu; // clears the sign, which says that the ray missed
        words.z = packHalf2x16(result.color.rg);
        words.w = packHalf2x16(vec2(result.color.b, 1.0));
        imageStore(seen_image, pixel, words);
        StoreRayEnd(pixel, PackRayEnd(ray, place, result.triangle));
    }
#else
    if (result.shows) {
        float density = abs(imageLoad(place_image, pixel).w);
        imageStore(place_image, pixel, vec4(ToView(place) / captures.view_unit, density));
        imageStore(seen_image, pixel, vec4(result.color, 1.0));
        StoreRayEnd(2 * pixel, PackRayEnd(ray, place, result.triangle));
    }
#endif
}

#endif
