#version 460
#pragma program(StochasticExact, EXACT)
#pragma program(StochasticThesis)
#pragma in_either_stage
// Traces one ray for each pixel that reflects, in a direction drawn from the lobe (Stachowiak 2015). With EXACT the ray
// walks over the pyramid of `unified`. Otherwise it goes as in `ssct`: over the Hi-Z buffer, or by a march if it runs
// towards the camera.

#include "common/either_stage.glsl"

#ifdef EXACT
layout(binding = 1, rg32f) uniform readonly image2D pyramid;         // front and back depths
layout(binding = 2, rgba16f) uniform readonly image2D normal_buffer; // view space
layout(binding = 3, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness
#else
#define UNIFIED_BINDING 5
#include "thesis/parameters.glsl"
#include "thesis/ray_trace.glsl"
#endif

layout(constant_id = 10) const bool HITS = false; // out_hit is wanted

#include "stochastic/stochastic.glsl"
#include "captures/sky_along.glsl"
#include "unified/lit_color.glsl"
#ifdef EXACT
#include "unified/trace/mirrored.glsl"
#endif

OUTPUT(0, rgba32f, vec4, out_place); // the hit (ViewPoint's scale), or the direction of a miss; in w the logarithm
                                     // of the density, negative for a miss; 0 for no ray
OUTPUT(1, rgba16f, vec4, out_color); // lit colour there, and fade in alpha; a miss is 0
OUTPUT(2, rgba32f, vec4, out_hit);   // of a mirror: texture coordinates, standard depth, PATH_*

// Where a ray ended.
struct RayEnd {
    int code;      // PATH_*
    bool hits;     // the ray hit what a pixel shows
    bool shows;    // the pixel shows what the ray hits, or the sky; false for a pixel that is seen from behind its normal
    vec2 position; // continuous pixel coordinates
    float depth;   // reversed
    vec3 color;    // of what it hits
};

#ifndef EXACT
// The lit colour of the screen at a position in pixels, interpolated between the four pixels around it, whatever
// surfaces they show. Pixels of sky get `sky_color`, the sky along the ray, which is looked up once, since a device
// that executes both sides of a branch pays for every look-up.
vec3 SampleScreenBilinear(vec2 position, vec3 sky_color) {
    vec2 from_middle = position - 0.5;
    vec2 first_pixel = floor(from_middle);
    vec2 part = from_middle - first_pixel;
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 next = ivec2(i & 1, i >> 1);
        vec4 seen = ScreenColor(clamp(ivec2(first_pixel) + next, ivec2(0), unified.size - 1));
        vec2 weight = mix(1.0 - part, part, vec2(next));
        bool shows_sky = ShowsSky(seen);
        sum += weight.x * weight.y * (shows_sky ? vec4(0.0) : vec4(seen.rgb, 1.0));
    }
    return Sound(sum.rgb) + (1.0 - sum.a) * sky_color;
}
#endif

// Traces a ray from a pixel along a unit direction in view space.
RayEnd TraceDirection(ivec2 pixel, float depth, vec3 direction, vec3 normal, bool is_mirror) {
#ifdef EXACT
    bool is_front = true;
    Ray ray = RayAlong(pixel, depth, direction);
    if (is_mirror)
        ray = MirrorRay(pixel, depth, normal, is_front);
    Hit hit = Traverse(ray);
    bool hits = hit.code == PATH_HI_Z;
    bool is_far = LeavesThroughFarPlane(ray, hit);
    ScreenHitColor screen_hit = SampleScreenHit(hit, ViewPoint(ray.start, depth), normal, ray.direction, SampleSkyView(direction));
    bool shows = is_front && (hits || (is_far && screen_hit.is_sky));
    return RayEnd(hit.code == PATH_MISS ? MissCode(ray) : hit.code, hits, shows, hit.position, hit.depth, screen_hit.color);
#else
    vec3 P_ss = vec3((vec2(pixel) + 0.5) / thesis.resolution, texelFetch(hiZBuffer, pixel, 0).r);
    vec3 V_ss = Project(Unproject(P_ss) + direction * thesis.reflection_offset) - P_ss;
    float path;
    vec3 hit = RayTrace(P_ss, V_ss, path);
    bool hits = hit != INVALID_RAY;
    vec2 position = hit.xy * thesis.resolution;
    return RayEnd(int(path), hits, hits, position, 1.0 - hit.z, SampleScreenBilinear(position, SampleSkyView(direction)));
#endif
}

SHADE_ALL(out_place, STORE(out_color) STORE_IF(HITS, out_hit)) {
    ivec2 pixel = ivec2(PIXEL_CENTRE);
    out_place = vec4(0.0);
    out_color = vec4(0.0);
    if (HITS)
        out_hit = vec4(-1.0, -1.0, -1.0, float(PATH_NONE));
#ifdef EXACT
    vec2 material = imageLoad(material_buffer, pixel).xy;
    vec3 normal = imageLoad(normal_buffer, pixel).xyz;
    float depth = imageLoad(pyramid, PixelTexel(pixel)).r;
#else
    vec2 material = texelFetch(materialBuffer, pixel, 0).xy;
    vec3 normal = texelFetch(normalBuffer, pixel, 0).xyz;
    float depth = 1.0 - texelFetch(hiZBuffer, pixel, 0).r;
#endif
    bool is_mirror = material.y <= 0.0;
    if (!Reflects(material) || !(depth > 0.0) || normal == vec3(0.0))
        return;
    vec3 point = ViewPoint(vec2(pixel) + 0.5, depth);
    vec3 mirror = MirrorDirection(point, normal);
    // A mirror has one direction.
    vec2 u = is_mirror ? vec2(0.0) : RaySample2D(pixel, stochastic.turn);
    float power = LobePower(material.y);
    float log_rest = log2(1.0 - u.x * stochastic.part);
    float density = is_mirror ? LOG_DENSITY_BIAS : LogDensity(power, log_rest);
    float angle = TAU * u.y;
    vec3 direction = is_mirror ? mirror : LobeDirection(mirror, power, log_rest / LOG2_E, vec2(cos(angle), sin(angle)));
    out_place = vec4(direction, -density);
    // A direction below the surface shows nothing, but its density counts (docs/definitions.md, "Surfaces"). The end of
    // a mirror's ray is written nevertheless.
    bool above = dot(direction, normal) > 0.0;
    if (!above && !(HITS && is_mirror))
        return;
    RayEnd end = TraceDirection(pixel, depth, direction, normal, is_mirror);
    if (end.shows && above) {
        vec2 uv = end.position * unified.pixel_to_clip;
        out_place = vec4(ViewPoint(end.position, end.depth), density);
        out_color = vec4(end.color, Fade(uv));
    }
    if (HITS && is_mirror) {
        precise vec2 uv = end.position * unified.pixel_to_clip;
        precise float hit_depth = 1.0 - end.depth;
        out_hit = vec4(end.hits ? vec3(uv, hit_depth) : vec3(-1.0), float(end.code));
    }
}
