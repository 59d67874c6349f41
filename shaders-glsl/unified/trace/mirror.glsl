// Shades a mirror pixel: traces one ray, takes one sample of the lit colour at its hit, and composites. A fragment
// program (mirror.frag) and a compute program (mirror.comp) include this file. Before it they declare WHOLE, which says
// whether they run over the whole image.
//
// Over tiles, a pixel that is no mirror is left as it is: the images already hold what it shows. With WHOLE the images
// hold nothing, all that reflects is a mirror, and the other pixels show their lit colour.

#ifndef UNIFIED_MIRROR_GLSL
#define UNIFIED_MIRROR_GLSL

#include "unified/parameters.glsl"

layout(constant_id = 3) const bool HITS = false;  // where the ray ended is wanted
layout(constant_id = 6) const bool COMPOSITE = true; // false: only the reflection is shown

#ifndef AMONG_TRIANGLES
layout(binding = 1, rg32f) uniform readonly image2D pyramid;         // front and back depths
#endif
layout(binding = 2, rgba16f) uniform readonly image2D normal_buffer; // view space
layout(binding = 3, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness

#include "unified/depth.glsl"
#include "unified/lit_color.glsl"
#ifdef AMONG_TRIANGLES
#include "unified/trace/ray.glsl"
#include "triangles/from_pixel.glsl"
#else
#include "unified/trace/traverse.glsl"
#include "captures/seen.glsl"
#ifndef CONFIRMED
#include "unified/trace/mirrored.glsl"
#endif
#endif

struct PixelOutput {
    vec4 color;      // lit colour + reflectivity * fade * reflection; or the reflection
    vec4 reflection; // colour, and fade in alpha; a miss is 0
    vec4 hit;        // with HITS: texture coordinates, standard depth, PATH_*
};

// The lit colour of the pixel itself, to which the reflection is added. It is loaded after the ray was followed, since
// a walk has no register to spare.
vec4 LitColorAt(ivec2 pixel) {
    return COMPOSITE ? ScreenColor(pixel) : vec4(0.0);
}

// Shades a pixel; false for a pixel that is left as it is.
bool ShadePixel(ivec2 pixel, out PixelOutput result) {
    vec2 material = imageLoad(material_buffer, pixel).xy;
    float depth = DepthAt(pixel);
    vec3 normal = imageLoad(normal_buffer, pixel).xyz;
    bool is_traced = Reflects(material) && depth > 0.0 && normal != vec3(0.0);
    result.reflection = vec4(0.0);
    result.hit = vec4(-1.0, -1.0, -1.0, float(PATH_NONE));
    if (!WHOLE && (!is_traced || TileListOf(material) != MIRROR_LIST))
        return false;
    if (!is_traced) {
        result.color = LitColorAt(pixel);
        return true;
    }
    bool is_front;
    Ray ray = MirrorRay(pixel, depth, normal, is_front);
    float spread = PixelSpread();
#ifdef AMONG_TRIANGLES
    if (is_front) {
        TriangleRayResult triangle_result = TraceTrianglesFromPixel(ray, spread);
        result.reflection = vec4(triangle_result.color, 1.0);
        result.hit = vec4(triangle_result.place, float(triangle_result.code));
    }
    result.color = LitColorAt(pixel);
    vec3 color = result.color.rgb + material.x * result.reflection.rgb;
    result.color = COMPOSITE ? vec4(min(color, GREATEST_HALF), result.color.a) : result.reflection;
#else
    Hit hit = Traverse(ray);
    bool is_hit = hit.code == PATH_HI_Z && is_front;
    bool ends_in_sky = is_front && EndsInSky(ray, hit);
#ifdef CONFIRMED
    TriangleRayResult triangle_result = TriangleRayResult(vec3(0.0), vec3(0.0), PATH_NONE, NO_TRIANGLE);
    ConfirmedHit confirmed;
    bool shows = is_hit && ConfirmHit(ray, hit.pixel, confirmed);
    if (shows) {
        triangle_result = ShadeConfirmedHit(confirmed, spread);
        result.reflection = vec4(triangle_result.color, 1.0);
    } else if (is_front) {
        PushPixelRay(uvec2(pixel), ray, spread);
    }
#else
    // A lost ray is put on the list before the screen's colours are loaded, while registers hold nothing else.
    if (is_front && !is_hit && !ends_in_sky) {
        // A mirror's ray has the footprint of its pixel, which widens from the eye on.
        float widened_m = ORTHOGRAPHIC ? FAR_EYE : length(ViewPoint(ray.start, depth)) * captures.view_unit;
        PushIfLost(uvec2(pixel), ray, hit, widened_m, spread);
    }
    bool leaves_far = LeavesThroughFarPlane(ray, hit);
    vec3 sky_color = SampleSkyView(ray.direction);
    ScreenHitColor screen_hit = SampleScreenHit(hit, ViewPoint(ray.start, depth), normal, ray.direction, sky_color);
    bool shows = is_hit || ends_in_sky || (is_front && leaves_far && screen_hit.is_sky);
    if (shows) {
        float fade = Fade(hit.position * unified.pixel_to_clip);
        result.reflection = ends_in_sky ? vec4(sky_color, 1.0) : vec4(screen_hit.color, fade);
    }
#endif
    result.color = LitColorAt(pixel);
    if (shows) {
        vec3 color = result.color.rgb + material.x * result.reflection.a * result.reflection.rgb;
        result.color = COMPOSITE ? vec4(min(color, GREATEST_HALF), result.color.a) : result.reflection;
    }
    if (HITS) {
        precise vec2 uv = hit.position * unified.pixel_to_clip;
        precise float hit_depth = 1.0 - hit.depth;
        vec3 place = hit.code == PATH_HI_Z ? vec3(uv, hit_depth) : vec3(-1.0);
        int code = ends_in_sky ? PATH_SKY : hit.code == PATH_MISS ? MissCode(ray) : hit.code;
        result.hit = vec4(place, float(code));
#ifdef CONFIRMED
        // A confirmed hit is more exact than the hit on the screen.
        if (shows)
            result.hit = vec4(triangle_result.place, float(triangle_result.code));
#endif
    }
#endif
    return true;
}

#endif
