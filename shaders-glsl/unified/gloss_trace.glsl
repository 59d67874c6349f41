// One ray of the pattern for each pixel with a narrow lobe (NARROW), or for each cell of 2 x 2 pixels with a wide one,
// and what it saw, for neighbours to gather. Fragment programs (gloss_trace.frag) and compute programs
// (gloss_trace.comp) include it. CPU twin: reference::unified::gloss_trace.

#ifndef UNIFIED_GLOSS_TRACE_GLSL
#define UNIFIED_GLOSS_TRACE_GLSL

#ifndef AMONG_TRIANGLES
layout(binding = 1, rg32f) uniform readonly image2D pyramid;         // front and back depths
#endif
layout(binding = 2, rgba16f) uniform readonly image2D normal_buffer; // view space
layout(binding = 3, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness
#ifndef AMONG_TRIANGLES
layout(binding = 4) uniform sampler2D color_buffer; // lit colour, linear, with its coarser levels
#endif

#include "unified/depth.glsl"
#include "unified/gloss.glsl"
#ifdef AMONG_TRIANGLES
#include "triangles/from_pixel.glsl"
#else
#include "unified/traverse.glsl"
#include "captures/seen.glsl"
#endif

// Where a ray ended: its place (ViewPoint's scale), far along the ray for the sky; for a miss, the ray's direction. `beside` says
// that it ended on the screen, so near to where it began that neighbours see the same elsewhere (NEAR_HIT).
struct End {
    vec3 place;
    bool beside;
    uint met; // the number of a triangle, or NO_TRIANGLE
    bool touches; // beside, and on another surface than the one that reflects
};

// What a ray sees whose footprint measures `spread` for each metre: its colour, and how much of it counts.
#if defined(AMONG_TRIANGLES)

bool Look(ivec2 at, Ray ray, vec3 normal, float spread, float density, float share, out vec4 color, out End end) {
    Among seen = SeeFrom(ray, spread);
    color = vec4(seen.color, 1.0);
    end = End(ToView(seen.place) / captures.view_unit, false, seen.met, false);
    return true;
}

#elif defined(CONFIRMED)

bool Look(ivec2 at, Ray ray, vec3 normal, float spread, float density, float share, out vec4 color, out End end) {
    Hit hit = Traverse(ray);
    Confirmed confirmed;
    color = vec4(0.0);
    end = End(ray.direction, false, NO_TRIANGLE, false);
    if (!(hit.code == PATH_HI_Z && Confirm(ray, hit.pixel, confirmed))) {
        PushFromPixel(uvec2(at), ray, spread);
        return false;
    }
    Among seen = SeeConfirmed(confirmed, spread);
    color = vec4(seen.color, 1.0);
    end = End(ToView(seen.place) / captures.view_unit, false, seen.met, false);
    return true;
}

#else

// The lit colour of the screen over a footprint: between the four texels around the hit, in the level of the chain whose texels are
// nearest to the footprint in size. Those count that the ray can have seen in their middles, and that hold no sky or nothing else. From
// SEEN_LEVELS on, texels have mixed surfaces already, and all count. Where none does, the colour is that of the pixel that was
// hit. `point` and `normal` are those of the surface that reflects. The share of a texel that is sky (1 - a) was seen in another
// direction than `along`, which is the sky along the ray.
//
// There is no lookup through a filter: a device that takes both ways of a branch would pay for it at every hit, and the mean
// of several rays hides the step between two levels.
vec3 ColorSeen(Hit hit, vec3 point, vec3 normal, vec3 direction, float footprint_level, vec3 along, out bool is_its) {
    bool mixes = footprint_level >= SEEN_LEVELS;
    int level = int(min(footprint_level + 0.5, float(textureQueryLevels(color_buffer) - 1)));
    float own_depth = BLOCK_AT(PixelTexel(hit.pixel)).x;
    Seeing from = SeeingFrom(point, normal, direction, hit.pixel, own_depth, exp2(float(level)));
    is_its = from.is_its;
    // Some drivers take textureSize of one thread's level for all threads around it.
    ivec2 texels = max(unified.size >> level, ivec2(1));
    vec2 to_texels = vec2(texels) / vec2(unified.size);
    precise vec2 from_middle = hit.position * to_texels - 0.5;
    vec2 low = floor(from_middle), part = from_middle - low;
    precise vec4 sum = vec4(0.0);
    precise float counted = 0.0, sky = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 next = ivec2(i & 1, i >> 1);
        ivec2 texel = clamp(ivec2(low) + next, ivec2(0), texels - 1);
        ivec2 middle = min(ivec2((vec2(texel) + 0.5) / to_texels), unified.size - 1);
        vec4 seen = texelFetch(color_buffer, texel, level);
        vec2 weight = mix(1.0 - part, part, vec2(next));
        bool is_whole = unified.sky == 0 || seen.a == 0.0 || seen.a > 0.999;
        bool counts = mixes || IsSeen(from, vec2(middle) + 0.5, BLOCK_AT(PixelTexel(middle)).x) && is_whole;
        AddTexel(sum, counted, seen, counts, weight.x * weight.y);
        sky += counts && seen.a > 0.0 ? weight.x * weight.y * (1.0 - seen.a) : 0.0;
    }
    vec4 own = texelFetch(color_buffer, hit.pixel, 0);
    float whole = 1.0 / max(counted, 1e-6);
    vec3 between = Sound(sum.rgb * whole) + max(1.0 - sum.a * whole, 0.0) * along;
    if (unified.sky != 0)
        between = Sound(between + sky * whole * (along - Sky(ToWorld(ViewRay(hit.position)))));
    return ShowsSky(own) && !mixes ? along : counted > 0.0 ? between : Sound(own.rgb);
}

bool Look(ivec2 at, Ray ray, vec3 normal, float spread, float density, float share, out vec4 color, out End end) {
    Hit hit = Traverse(ray);
    vec3 along = SkyAlong(ray.direction);
    vec3 point = ViewPoint(ray.start, ray.depth);
    color = vec4(0.0);
    end = End(ray.direction, false, NO_TRIANGLE, false);
    if (EndsInSky(ray, hit)) {
        color = vec4(along, 1.0);
        end.place = point + FAR_SKY * ray.direction;
        return true;
    }
    PushIfLost(uvec2(at), ray, hit, 0.0, spread);
    bool on_sky = GoesFar(ray, hit) && BLOCK_AT(PixelTexel(hit.pixel)).x < 0.0;
    if (hit.code != PATH_HI_Z && !on_sky)
        return false;
    vec3 there = ViewPoint(hit.position, hit.depth);
    vec2 away = abs(hit.position - ray.start);
    if (on_sky)
        end.place = point + FAR_SKY * ray.direction;
    else
        end = End(there, max(away.x, away.y) < NEAR_HIT, NO_TRIANGLE, false);
    float level = FootprintLevel(point, there, density, share);
    bool is_its;
    color = vec4(ColorSeen(hit, point, normal, ray.direction, level, along, is_its), Fade(hit.position * unified.pixel_to_clip));
    end.touches = end.beside && !is_its;
    return true;
}

#endif

// The ray of pattern point u in the lobe of a pixel at a point (ViewPoint's scale), one of those that neighbours
// gather, with which it has a part of its lobe in common. The lobe is covered by so many footprints; the smaller that
// part is, the fewer, down to one in the middle that stands for the whole lobe.
// `at` is the pixel or cell whose record the ray is for.
Seen LookInLobe(ivec2 at, ivec2 pixel, float depth, Lobe lobe, vec2 u, float footprints, float common_part, out End end) {
    float share = 1.0 / (1.0 + (footprints - 1.0) * common_part);
    u.x *= common_part;
    float angle = 6.2831853 * u.y;
    float log_rest = log2(1.0 - u.x);
    float density = LogDensity(lobe.power, log_rest);
    vec3 direction = LobeDirection(lobe.mirror, lobe.power, log_rest / LOG2_E, vec2(cos(angle), sin(angle)));
    Seen seen = Seen(false, density, vec4(0.0));
    end = End(direction, false, NO_TRIANGLE, false);
    // Below the surface there is nothing to see, and it counts (docs/definitions.md, "Surfaces").
    if (!(dot(direction, lobe.normal) > 0.0))
        return seen;
    // The width of the ray's footprint at a metre, as FootprintLevel takes it.
    float spread = sqrt(2.0 * share * exp2(LOG_DENSITY_BIAS - density));
    Ray ray = RayAlong(pixel, depth, direction);
    seen.is_hit = Look(at, ray, lobe.normal, spread, density, share, seen.color, end);
    return seen;
}

// What a history is told of where a ray ended (unified/ends.glsl).
uvec2 Told(vec3 point, Seen seen, End end) {
    return seen.is_hit ? uvec2(floatBitsToUint(distance(point, end.place)), end.met) : uvec2(0u);
}

#ifdef NARROW

#if defined(AMONG_TRIANGLES) || defined(CONFIRMED)
#include "triangles/own_rays.glsl"
// Where pixels in doubt get rays of their own, the nine rays are spread over the whole lobe. On triangles no chain of colours
// blurs what a ray sees into the rest of the lobe.
const bool SPREADS = OWN_RAYS > 0;
#else
const bool SPREADS = false;
#endif
const float PATTERN_PART = SPREADS ? 1.0 : NARROW_PART;
const float PATTERN_FOOTPRINTS = SPREADS ? 9.0 : NARROW_FOOTPRINTS;

uvec4 RecordOf(ivec2 pixel, out uvec2 told) {
    told = uvec2(0u);
    vec2 material = imageLoad(material_buffer, pixel).rg;
    float depth = DepthAt(pixel);
    vec3 normal = imageLoad(normal_buffer, pixel).xyz;
    bool narrow = Reflects(material) && ListOf(material) == NARROW_LIST;
    if (!narrow || !(depth > 0.0) || !(dot(normal, normal) > 0.0))
        return NO_RECORD;
    vec3 point = ViewPoint(vec2(pixel) + 0.5, depth);
    Lobe lobe = LobeOf(point, normal, material.g);
    vec2 u = LatticePoint(pixel, 3, 2, vec2(0.5));
    // Packed before the ray is followed, since a walk has no register to spare.
    uint mirror = PackMirror(lobe.mirror);
    float root = sqrt(lobe.power);
    End end;
    Seen seen = LookInLobe(pixel, pixel, depth, lobe, vec2(u.x * PATTERN_PART, u.y), PATTERN_FOOTPRINTS, 1.0, end);
    told = Told(point, seen, end);
    return PackRecord(mirror, seen.is_hit ? root : -root, seen.color);
}

#else

#if defined(AMONG_TRIANGLES) || defined(CONFIRMED)
const bool MARKS_NEAR = false;
#else
#include "triangles/own_rays.glsl"
// A place that was put far away no longer says that the ray ended near, which decides whether pixels get rays of their own.
const bool MARKS_NEAR = OWN_RAYS > 0;
#endif

// How a unit vector turns from texel to texel: the differences along both axes within a block of 2 x 2, right less left
// and lower less upper. The file that includes this one defines it. Every thread of a block must call it.
void Turn(vec3 unit, out vec3 across, out vec3 along);

// Where the ray of a point ended (ViewPoint's scale), put far away if it is near, or the direction of a miss.
vec3 Place(vec3 point, End end) {
    return end.beside ? point + FAR_AWAY * (end.place - point) : end.place;
}

struct CellRay {
    vec4 place; // and the ray's density; all is 0 for no ray
    vec4 color;
    uvec2 told;
};

// The ray of a cell. A cell beyond the border has none, but its thread must call this as well: Turn takes part of it.
CellRay RayOf(ivec2 cell) {
    CellRay traced = CellRay(vec4(0.0), vec4(0.0), uvec2(0u));
    WideCell wide = FindWide(cell);
    ivec2 pixel = wide.pixel;
    // The pixel of a cell at the edge that has no wide lobe may lie beyond the image.
    vec3 normal = all(lessThan(pixel, unified.size)) ? imageLoad(normal_buffer, pixel).xyz : vec3(0.0);
    vec3 turn_x, turn_y;
    Turn(normal * inversesqrt(max(dot(normal, normal), 1e-30)), turn_x, turn_y);
    if (wide.roughness > 0.0 && all(lessThan(2 * cell, unified.size))) {
        // Cells of one direction in squares side by side have other parities, and other places in its stratum.
        ivec2 odd = cell & 1;
        vec2 stratum = 0.125 + 0.25 * vec2(2 * odd.x + odd.y, 2 * (odd.x ^ odd.y) + odd.x);
        vec2 u = LatticePoint(cell, 5, 7, stratum);
        float depth = DepthAt(pixel);
        vec3 point = ViewPoint(vec2(pixel) + 0.5, depth);
        Lobe lobe = LobeOf(point, normal, wide.roughness);
        float common_part = 0.5 * (Overlap(turn_x, lobe.power) + Overlap(turn_y, lobe.power));
        End end;
        Seen seen = LookInLobe(cell, pixel, depth, lobe, u, WIDE_FOOTPRINTS, common_part, end);
        traced = CellRay(vec4(Place(point, end), seen.is_hit ? seen.density : -seen.density), seen.color, Told(point, seen, end));
        traced.color.a += MARKS_NEAR && end.touches ? ENDED_NEAR : 0.0;
    }
    return traced;
}

#endif

#endif
