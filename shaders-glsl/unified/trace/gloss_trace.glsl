// Traces one ray of the pattern for each pixel with a narrow lobe (NARROW), or for each cell of 2 x 2 pixels with a
// wide lobe, and records it for neighbours to gather. Fragment programs (gloss_trace.frag) and compute programs
// (gloss_trace.comp) include this file. CPU twin: reference::unified::gloss_trace.

#ifndef UNIFIED_GLOSS_TRACE_GLSL
#define UNIFIED_GLOSS_TRACE_GLSL

#ifndef AMONG_TRIANGLES
layout(binding = 1, rg32f) uniform readonly image2D pyramid;         // front and back depths
#endif
layout(binding = 2, rgba16f) uniform readonly image2D normal_buffer; // view space
layout(binding = 3, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness
#if !defined(AMONG_TRIANGLES) && !defined(CONFIRMED)
layout(binding = 30) uniform sampler2D color_chain; // coarser levels of the lit colour; sky is black in them if it is kept apart
#endif

#include "unified/depth.glsl"
#include "unified/gloss.glsl"
#ifdef AMONG_TRIANGLES
#include "triangles/from_pixel.glsl"
#else
#include "unified/trace/traverse.glsl"
#include "captures/seen.glsl"
#ifndef CONFIRMED
#include "unified/trace/mirrored.glsl"
#endif
#endif

// Where a ray ended: the point (ViewPoint's scale), which lies far along the ray for the sky; for a miss, the ray's
// direction. `is_near` says that the ray ended on the screen, so near to its beginning that neighbours see other things
// in its direction (NEAR_HIT).
struct RayEnd {
    vec3 place;
    bool is_near;
    uint triangle; // the number of a triangle, or NO_TRIANGLE
    bool touches;  // near, and on another surface than the one that reflects
};

// TraceGlossyRay traces a ray whose footprint widens by `spread` with each metre. `density` (LogDensity) and `share`
// are those of FootprintLevel. `color` becomes what the ray sees, with the fade in alpha. False for a miss.
#if defined(AMONG_TRIANGLES)

bool TraceGlossyRay(ivec2 record_texel, Ray ray, vec3 normal, float spread, float density, float share, out vec4 color, out RayEnd end) {
    TriangleRayResult result = TraceTrianglesFromPixel(ray, spread);
    color = vec4(result.color, 1.0);
    end = RayEnd(ToView(result.place) / captures.view_unit, false, result.triangle, false);
    return true;
}

#elif defined(CONFIRMED)

bool TraceGlossyRay(ivec2 record_texel, Ray ray, vec3 normal, float spread, float density, float share, out vec4 color, out RayEnd end) {
    Hit hit = Traverse(ray);
    ConfirmedHit confirmed;
    color = vec4(0.0);
    end = RayEnd(ray.direction, false, NO_TRIANGLE, false);
    if (!(hit.code == PATH_HI_Z && ConfirmHit(ray, hit.pixel, confirmed))) {
        PushPixelRay(uvec2(record_texel), ray, spread);
        return false;
    }
    TriangleRayResult result = ShadeConfirmedHit(confirmed, spread);
    color = vec4(result.color, 1.0);
    end = RayEnd(ToView(result.place) / captures.view_unit, false, result.triangle, false);
    return true;
}

#else

// The lit colour of the screen at a position in pixels, over a footprint as wide as the texels of a level of the chain.
// These texels mix surfaces, and all four around the position count. The part of a texel that is sky (1 - a) has the
// colour `sky_color`, the sky along the ray. The level is a whole number, since the mean of several rays hides the step
// between two levels.
vec3 SampleColorChain(vec2 position, int level, vec3 sky_color) {
    vec4 seen = textureLod(color_chain, position * unified.pixel_to_clip, float(level - 1));
    float sky_share = unified.sky != 0 ? max(1.0 - seen.a, 0.0) : 0.0;
    return Sound(seen.rgb) + sky_share * sky_color;
}

bool TraceGlossyRay(ivec2 record_texel, Ray ray, vec3 normal, float spread, float density, float share, out vec4 color, out RayEnd end) {
    Hit hit = Traverse(ray);
    vec3 sky_color = SampleSkyView(ray.direction);
    vec3 point = ViewPoint(ray.start, ray.depth);
    color = vec4(0.0);
    end = RayEnd(ray.direction, false, NO_TRIANGLE, false);
    if (EndsInSky(ray, hit)) {
        color = vec4(sky_color, 1.0);
        end.place = point + FAR_SKY * ray.direction;
        return true;
    }
    PushIfLost(uvec2(record_texel), ray, hit, 0.0, spread);
    bool hits = hit.code == PATH_HI_Z, leaves_far = LeavesThroughFarPlane(ray, hit);
    if (!hits && !leaves_far)
        return false;
    HitPixel hit_pixel = LoadHitPixel(hit.pixel, point, normal, sky_color);
    if (!hits && !hit_pixel.is_sky)
        return false;
    vec3 there = ViewPoint(hit.position, hit.depth);
    vec2 away = abs(hit.position - ray.start);
    if (hits)
        end = RayEnd(there, max(away.x, away.y) < NEAR_HIT, NO_TRIANGLE, false);
    else
        end.place = point + FAR_SKY * ray.direction;
    int level = int(min(FootprintLevel(point, there, density, share) + 0.5, float(textureQueryLevels(color_chain))));
    vec3 lit = level > 0 ? SampleColorChain(hit.position, level, sky_color) : hit_pixel.color;
    color = vec4(lit, Fade(hit.position * unified.pixel_to_clip));
    end.touches = end.is_near && !hit_pixel.is_reflector;
    return true;
}

#endif

// Traces the ray of a point `u` of the pattern (in the unit square) in the lobe of a pixel, for neighbours to gather.
// `common_part` is the part of the lobe that the pixel has in common with these neighbours. The lobe is covered by
// `footprints` footprints; the smaller `common_part` is, the fewer they are, down to one in the middle that stands for
// the whole lobe. `record_texel` is the pixel or cell whose record the ray is for.
LobeSample TraceLobeSample(ivec2 record_texel, ivec2 pixel, float depth, Lobe lobe, vec2 u, float footprints, float common_part,
                           out RayEnd end) {
    float share = 1.0 / (1.0 + (footprints - 1.0) * common_part); // of the lobe, for which the ray stands
    u.x *= common_part;
    float angle = 6.2831853 * u.y;
    float log_rest = log2(1.0 - u.x); // 1 - u.x is the direction's cos^(alpha + 1)
    float log_density = LogDensity(lobe.power, log_rest);
    vec3 direction = LobeDirection(lobe.mirror, lobe.power, log_rest / LOG2_E, vec2(cos(angle), sin(angle)));
    LobeSample lobe_sample = LobeSample(false, log_density, vec4(0.0));
    end = RayEnd(direction, false, NO_TRIANGLE, false);
    // A direction below the surface shows nothing, but counts as a miss (docs/definitions.md, "Surfaces").
    if (!(dot(direction, lobe.normal) > 0.0))
        return lobe_sample;
    // The width of the ray's footprint at one metre, from the same solid angle as in FootprintLevel.
    float spread = sqrt(2.0 * share * exp2(LOG_DENSITY_BIAS - log_density));
    Ray ray = RayAlong(pixel, depth, direction);
    lobe_sample.is_hit = TraceGlossyRay(record_texel, ray, lobe.normal, spread, log_density, share, lobe_sample.color, end);
    return lobe_sample;
}

// Packs where a ray from `point` ended, for a history (unified/ends.glsl).
uvec2 PackRayEnd(vec3 point, LobeSample lobe_sample, RayEnd end) {
    return lobe_sample.is_hit ? uvec2(floatBitsToUint(distance(point, end.place)), end.triangle) : uvec2(0u);
}

#ifdef NARROW

#if defined(AMONG_TRIANGLES) || defined(CONFIRMED)
#include "triangles/own_rays.glsl"
// If pixels in doubt get own rays, the nine rays of the pattern are spread over the whole lobe. On triangles no colour
// chain blurs what a ray sees into the rest of the lobe.
const bool SPREADS = OWN_RAYS > 0;
#else
const bool SPREADS = false;
#endif
const float PATTERN_PART = SPREADS ? 1.0 : NARROW_PART;
const float PATTERN_FOOTPRINTS = SPREADS ? 9.0 : NARROW_FOOTPRINTS;

// Side and generator of the pattern of narrow lobes (LatticePoint). Each pixel gathers its nine rays.
#define NARROW_SIDE 3
#define NARROW_GENERATOR 2

// Traces the ray of a pixel with a narrow lobe, and returns its packed record; NO_RECORD for other pixels. `ray_end`
// becomes where the ray ended (PackRayEnd).
uvec4 TraceNarrowPixel(ivec2 pixel, out uvec2 ray_end) {
    ray_end = uvec2(0u);
    vec2 material = imageLoad(material_buffer, pixel).rg;
    float depth = DepthAt(pixel);
    vec3 normal = imageLoad(normal_buffer, pixel).xyz;
    bool is_narrow = Reflects(material) && TileListOf(material) == NARROW_LIST;
    if (!is_narrow || !(depth > 0.0) || !(dot(normal, normal) > 0.0))
        return NO_RECORD;
    vec3 point = ViewPoint(vec2(pixel) + 0.5, depth);
    Lobe lobe = MakeLobe(point, normal, material.g);
    vec2 pattern_point = LatticePoint(pixel, NARROW_SIDE, NARROW_GENERATOR, vec2(0.5));
    // The mirror direction is packed before the ray is traced, since a walk leaves no register free.
    uint mirror = PackMirror(lobe.mirror);
    float power_root = sqrt(lobe.power);
    RayEnd end;
    LobeSample lobe_sample = TraceLobeSample(pixel, pixel, depth, lobe,
                                             vec2(pattern_point.x * PATTERN_PART, pattern_point.y),
                                             PATTERN_FOOTPRINTS, 1.0, end);
    ray_end = PackRayEnd(point, lobe_sample, end);
    return PackRecord(mirror, lobe_sample.is_hit ? power_root : -power_root, lobe_sample.color);
}

#else

// The differences of a unit vector between the texels of a block of 2 x 2: right less left, and lower less upper. The
// file that includes this one defines the function. Every thread of a block must call it.
void BlockDifferences(vec3 unit, out vec3 across, out vec3 along);

// The place that is recorded for a ray from `point` (ViewPoint's scale); for a miss, the ray's direction. The place of
// a near hit is moved far away along the ray (NEAR_HIT says why).
vec3 RecordedPlace(vec3 point, RayEnd end) {
    return end.is_near ? point + FAR_AWAY * (end.place - point) : end.place;
}

struct CellRay {
    vec4 place;    // RecordedPlace, and in w the ray's density, negative for a miss; all is 0 for no ray
    vec4 color;    // colour that the ray saw, and fade in alpha
    uvec2 ray_end; // PackRayEnd
};

// Traces the ray of a cell. A cell beyond the border has none, but its thread must call this function as well, for
// BlockDifferences.
CellRay TraceWideCell(ivec2 cell) {
    CellRay cell_ray = CellRay(vec4(0.0), vec4(0.0), uvec2(0u));
    WideCell wide_cell = FindWideCell(cell);
    ivec2 pixel = wide_cell.pixel;
    // If a cell at the border has no wide lobe, its pixel may lie beyond the image.
    vec3 normal = all(lessThan(pixel, unified.size)) ? imageLoad(normal_buffer, pixel).xyz : vec3(0.0);
    vec3 turn_x, turn_y;
    BlockDifferences(normal * inversesqrt(max(dot(normal, normal), 1e-30)), turn_x, turn_y);
    if (wide_cell.roughness > 0.0 && all(lessThan(2 * cell, unified.size))) {
        // Cells of neighbouring squares that have the same direction of the pattern have different parities, and so
        // different places in the direction's stratum.
        ivec2 parity = cell & 1;
        vec2 stratum = 0.125 + 0.25 * vec2(2 * parity.x + parity.y, 2 * (parity.x ^ parity.y) + parity.x);
        vec2 pattern_point = LatticePoint(cell, 5, 7, stratum);
        float depth = DepthAt(pixel);
        vec3 point = ViewPoint(vec2(pixel) + 0.5, depth);
        Lobe lobe = MakeLobe(point, normal, wide_cell.roughness);
        float common_part = 0.5 * (LobeOverlap(turn_x, lobe.power) + LobeOverlap(turn_y, lobe.power));
        RayEnd end;
        LobeSample lobe_sample = TraceLobeSample(cell, pixel, depth, lobe, pattern_point, WIDE_FOOTPRINTS, common_part,
                                                 end);
        // A recorded place that was moved far away no longer says that the ray ended near. A mark says so instead.
        float marked_density = lobe_sample.density + (end.touches ? NEAR_MARK : 0.0);
        cell_ray = CellRay(vec4(RecordedPlace(point, end), lobe_sample.is_hit ? marked_density : -lobe_sample.density),
                         lobe_sample.color, PackRayEnd(point, lobe_sample, end));
    }
    return cell_ray;
}

#endif

#endif
