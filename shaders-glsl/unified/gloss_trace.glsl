// One ray of the pattern from a pixel, and what it saw. Needs parameters.glsl.

layout(binding = 1, rg32f) uniform readonly image2D pyramid; // front and back depths
layout(binding = 2) uniform sampler2D normal_buffer;   // view space
layout(binding = 3) uniform sampler2D material_buffer; // reflectivity, roughness
layout(binding = 4) uniform sampler2D color_buffer;    // lit colour, linear, with its coarser levels

#include "unified/tiles.glsl"
#include "unified/pyramid.glsl"
#include "unified/ray.glsl"
#include "unified/traverse.glsl"
#include "unified/fade.glsl"
#include "unified/sound.glsl"
#include "unified/gloss.glsl"

// A ray that ended: the point that it hit (ViewPoint's scale) and the density that it was sampled
// with; for a miss its direction, and the negative density; all 0 for no ray.
struct Seen {
    vec4 place;
    vec4 color; // of the hit, and its fade in a; a miss is 0
};

// A hit so near, in pixels or cells between neighbours: what a neighbour sees in this direction is more
// likely as near to itself than at this point. (A normal that a map has turned sends rays below the
// surface, which end in the next pixel.)
#define NEAR_HIT 4.0
#define FAR_AWAY 1e3

// The ray of pattern point u, one of some that neighbours at a distance in pixels gather, with which it has a
// part of its lobe in common. The smaller that is, the fewer rays it shares, down to one in the middle that
// stands for the whole lobe.
Seen Look(ivec2 pixel, float roughness, vec2 u, float rays, int reach, float common_part) {
    Seen seen = Seen(vec4(0.0), vec4(0.0));
    float depth = imageLoad(pyramid, pixel).r;
    vec3 normal = texelFetch(normal_buffer, pixel, 0).xyz;
    vec3 point = ViewPoint(vec2(pixel) + 0.5, depth);
    vec3 mirror = MirrorDirection(point, normal);
    float power = LobePower(roughness);
    float share = 1.0 / (1.0 + (rays - 1.0) * common_part);
    u.x *= common_part;
    float angle = 6.2831853 * u.y;
    vec3 direction = LobeDirection(mirror, power, log(1.0 - u.x), vec2(cos(angle), sin(angle)));
    // (alpha + 1) cos^alpha, without the 2 pi that all densities have.
    float density = power * exp2((power - 1.0) / power * log2(1.0 - u.x));
    seen.place = vec4(direction, -density);
    // Below the surface there is nothing to see, and it counts (DEFINITIONS, "Surfaces").
    if (!(dot(direction, normal) > 0.0))
        return seen;
    Hit hit = Traverse(RayAlong(pixel, depth, direction));
    if (hit.code != HIT_SURFACE)
        return seen;
    vec3 there = ViewPoint(hit.position, hit.depth);
    vec2 away = abs(hit.position - vec2(pixel) - 0.5);
    bool beside = max(away.x, away.y) < NEAR_HIT * float(reach);
    vec2 uv = hit.position * unified.pixel_to_clip;
    seen.place = vec4(beside ? point + FAR_AWAY * (there - point) : there, density);
    float level = FootprintLevel(point, there, density, share);
    seen.color = vec4(Sound(textureLod(color_buffer, uv, level).rgb), Fade(uv));
    return seen;
}
