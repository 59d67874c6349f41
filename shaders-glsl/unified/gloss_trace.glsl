// One ray of the pattern from a pixel, and what it saw. Needs parameters.glsl.

layout(binding = 1, rg32f) uniform readonly image2D pyramid; // front and back depths
layout(binding = 3, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness
layout(binding = 4) uniform sampler2D color_buffer;    // lit colour, linear, with its coarser levels

#include "unified/normal.glsl"
#include "unified/tiles.glsl"
#include "unified/pyramid.glsl"
#include "unified/ray.glsl"
#include "unified/traverse.glsl"
#include "unified/fade.glsl"
#include "unified/sound.glsl"
#include "unified/gloss.glsl"

// The ray of pattern point u in the lobe of a pixel at a point (ViewPoint's scale), one of those that neighbours
// gather, with which it has a part of its lobe in common. The lobe is covered by so many footprints; the smaller that
// part is, the fewer, down to one in the middle that stands for the whole lobe.
Seen Look(ivec2 pixel, float depth, vec3 point, Lobe lobe, vec2 u, float footprints, float common_part, out Hit hit) {
    hit = Hit(HIT_NONE, pixel, vec2(0.0), 0.0, 0);
    float share = 1.0 / (1.0 + (footprints - 1.0) * common_part);
    u.x *= common_part;
    float angle = 6.2831853 * u.y;
    float log_rest = log2(1.0 - u.x);
    float density = LogDensity(lobe.power, log_rest);
    vec3 direction = LobeDirection(lobe.mirror, lobe.power, log_rest / LOG2_E, vec2(cos(angle), sin(angle)));
    Seen seen = Seen(direction, -density, vec4(0.0));
    // Below the surface there is nothing to see, and it counts (DEFINITIONS, "Surfaces").
    if (!(dot(direction, lobe.normal) > 0.0))
        return seen;
    hit = Traverse(RayAlong(pixel, depth, direction));
    if (hit.code != HIT_SURFACE)
        return seen;
    vec2 uv = hit.position * unified.pixel_to_clip;
    float level = FootprintLevel(point, ViewPoint(hit.position, hit.depth), density, share);
    seen.density = density;
    seen.color = vec4(Sound(textureLod(color_buffer, uv, level).rgb), Fade(uv));
    return seen;
}
