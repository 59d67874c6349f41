// One ray of the pattern for each pixel with a narrow lobe (NARROW), or for each cell of 2 x 2 pixels with a wide one,
// and what it saw, for neighbours to gather. Fragment programs (gloss_trace.frag) and compute programs
// (gloss_trace.comp) include it. CPU twin: reference::unified::gloss_trace.

#ifndef UNIFIED_GLOSS_TRACE_GLSL
#define UNIFIED_GLOSS_TRACE_GLSL

layout(binding = 1, rg32f) uniform readonly image2D pyramid;         // front and back depths
layout(binding = 2, rgba16f) uniform readonly image2D normal_buffer; // view space
layout(binding = 3, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness
layout(binding = 4) uniform sampler2D color_buffer; // lit colour, linear, with its coarser levels

#include "unified/gloss.glsl"
#include "unified/traverse.glsl"
#include "captures/seen.glsl"

// The ray of pattern point u in the lobe of a pixel at a point (ViewPoint's scale), one of those that neighbours
// gather, with which it has a part of its lobe in common. The lobe is covered by so many footprints; the smaller that
// part is, the fewer, down to one in the middle that stands for the whole lobe.
// `at` is the pixel or cell whose record the ray is for.
Seen Look(ivec2 at, ivec2 pixel, float depth, vec3 point, Lobe lobe, vec2 u, float footprints, float common_part,
          out Hit hit) {
    hit = Hit(PATH_NONE, pixel, vec2(0.0), 0.0, 0, 0.0);
    float share = 1.0 / (1.0 + (footprints - 1.0) * common_part);
    u.x *= common_part;
    float angle = 6.2831853 * u.y;
    float log_rest = log2(1.0 - u.x);
    float density = LogDensity(lobe.power, log_rest);
    vec3 direction = LobeDirection(lobe.mirror, lobe.power, log_rest / LOG2_E, vec2(cos(angle), sin(angle)));
    Seen seen = Seen(direction, -density, vec4(0.0));
    // Below the surface there is nothing to see, and it counts (docs/definitions.md, "Surfaces").
    if (!(dot(direction, lobe.normal) > 0.0))
        return seen;
    Ray ray = RayAlong(pixel, depth, direction);
    hit = Traverse(ray);
    vec3 along = SkyAlong(direction);
    if (EndsInSky(ray, hit)) {
        hit.position = ray.start;
        hit.depth = 0.0;
        seen.density = density;
        seen.color = vec4(along, 1.0);
        return seen;
    }
    // The width of the ray's footprint at a metre, as FootprintLevel takes it.
    PushIfLost(uvec2(at), ray, hit, 0.0, sqrt(2.0 * share * exp2(LOG_DENSITY_BIAS - density)));
    if (hit.code != PATH_HI_Z)
        return seen;
    float level = FootprintLevel(point, ViewPoint(hit.position, hit.depth), density, share);
    seen.density = density;
    seen.color = vec4(ColorSeen(hit.position, level, along), Fade(hit.position * unified.pixel_to_clip));
    return seen;
}

#ifdef NARROW

uvec4 RecordOf(ivec2 pixel) {
    vec2 material = imageLoad(material_buffer, pixel).rg;
    float depth = imageLoad(pyramid, PixelTexel(pixel)).r;
    vec3 normal = imageLoad(normal_buffer, pixel).xyz;
    bool narrow = Reflects(material) && ListOf(material) == NARROW_LIST;
    if (!narrow || !(depth > 0.0) || !(dot(normal, normal) > 0.0))
        return NO_RECORD;
    vec3 point = ViewPoint(vec2(pixel) + 0.5, depth);
    Lobe lobe = LobeOf(point, normal, material.g);
    vec2 u = LatticePoint(pixel, 3, 2, vec2(0.5));
    Hit hit;
    Seen seen = Look(pixel, pixel, depth, point, lobe, vec2(u.x * NARROW_PART, u.y), NARROW_FOOTPRINTS, 1.0, hit);
    float root = sqrt(lobe.power);
    return Pack(Record(lobe.mirror, seen.density > 0.0 ? root : -root, seen.color));
}

#else

// How a unit vector turns from texel to texel: the differences along both axes within a block of 2 x 2, right less left
// and lower less upper. The file that includes this one defines it. Every thread of a block must call it.
void Turn(vec3 unit, out vec3 across, out vec3 along);

// The point that was hit (ViewPoint's scale), put far away if it is near, or the direction of a miss.
vec3 Place(ivec2 pixel, vec3 point, Seen seen, Hit hit) {
    // Where the sky was seen, a point far along the ray stands for it.
    if (seen.density > 0.0 && hit.code == PATH_MISS)
        return point + FAR_SKY * seen.direction;
    vec3 there = ViewPoint(hit.position, hit.depth);
    vec2 away = abs(hit.position - vec2(pixel) - 0.5);
    bool beside = max(away.x, away.y) < NEAR_HIT;
    return seen.density > 0.0 ? beside ? point + FAR_AWAY * (there - point) : there : seen.direction;
}

struct CellRay {
    vec4 place; // and the ray's density; all is 0 for no ray
    vec4 color;
};

// The ray of a cell. A cell beyond the border has none, but its thread must call this as well: Turn takes part of it.
CellRay RayOf(ivec2 cell) {
    CellRay traced = CellRay(vec4(0.0), vec4(0.0));
    float roughness;
    ivec2 pixel = WidePixel(cell, roughness);
    // The pixel of a cell at the edge that has no wide lobe may lie beyond the image.
    vec3 normal = all(lessThan(pixel, unified.size)) ? imageLoad(normal_buffer, pixel).xyz : vec3(0.0);
    vec3 turn_x, turn_y;
    Turn(normal * inversesqrt(max(dot(normal, normal), 1e-30)), turn_x, turn_y);
    // Two unit vectors are at most 2 apart, so that this holds always. Without it Mesa 25 sinks the load of the normal and
    // the derivatives into the branch below, where the cells of the block that have no ray load nothing.
    bool is_turned = dot(turn_x, turn_x) + dot(turn_y, turn_y) < 9.0;
    if (is_turned && roughness > 0.0 && all(lessThan(2 * cell, unified.size))) {
        // Cells of one direction in squares side by side have other parities, and other places in its stratum.
        ivec2 odd = cell & 1;
        vec2 stratum = 0.125 + 0.25 * vec2(2 * odd.x + odd.y, 2 * (odd.x ^ odd.y) + odd.x);
        vec2 u = LatticePoint(cell, 5, 7, stratum);
        float depth = imageLoad(pyramid, PixelTexel(pixel)).r;
        vec3 point = ViewPoint(vec2(pixel) + 0.5, depth);
        Lobe lobe = LobeOf(point, normal, roughness);
        float common_part = 0.5 * (Overlap(turn_x, lobe.power) + Overlap(turn_y, lobe.power));
        Hit hit;
        Seen seen = Look(cell, pixel, depth, point, lobe, u, WIDE_FOOTPRINTS, common_part, hit);
        traced = CellRay(vec4(Place(pixel, point, seen, hit), seen.density), seen.color);
    }
    return traced;
}

#endif

#endif
