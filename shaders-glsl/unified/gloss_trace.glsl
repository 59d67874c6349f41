// One ray of the pattern from a pixel, and what it saw. Needs parameters.glsl.

layout(binding = 1, rg32f) uniform readonly image2D pyramid; // front and back depths
layout(binding = 2) uniform sampler2D normal_buffer;   // view space
layout(binding = 3) uniform sampler2D material_buffer; // reflectivity, roughness
layout(binding = 4) uniform sampler2D color_buffer;    // lit colour, linear, with its coarser levels

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

// The ray of pattern point u, which stands for a share of the lobe.
Seen Look(ivec2 pixel, float roughness, vec2 u, float share) {
    Seen seen = Seen(vec4(0.0), vec4(0.0));
    float depth = imageLoad(pyramid, pixel).r;
    vec3 normal = texelFetch(normal_buffer, pixel, 0).xyz;
    vec3 point = ViewPoint(vec2(pixel) + 0.5, depth);
    vec3 mirror = MirrorDirection(point, normal);
    float power = LobePower(roughness);
    float angle = 6.2831853 * u.y;
    vec3 direction = LobeDirection(mirror, power, log(1.0 - u.x), vec2(cos(angle), sin(angle)));
    // (alpha + 1) cos^alpha, without the 2 pi that all densities have.
    float density = power * exp2((power - 1.0) / power * log2(1.0 - u.x));
    seen.place = vec4(direction, -density);
    // Below the surface there is nothing to see, and it counts (DEFINITIONS, "Surfaces").
    bool faces;
    Ray ray = MirrorRay(pixel, depth, normal, faces);
    if (roughness > 0.0) {
        ray = RayAlong(pixel, depth, direction);
        faces = dot(direction, normal) > 0.0;
    }
    if (!faces)
        return seen;
    Hit hit = Traverse(ray);
    if (hit.code != HIT_SURFACE)
        return seen;
    vec3 there = ViewPoint(hit.position, hit.depth);
    // The footprint: the ray's share of the lobe as a solid angle, share 2 pi / density, taken for a
    // cone of angle theta, pi theta^2; its diameter at the hit in pixels is the level's texel.
    float diameter = sqrt(2.0 * share / density) * distance(there, point) / (there.z * unified.pixel_to_view.y);
    vec2 uv = hit.position * unified.pixel_to_clip;
    seen.place = vec4(there, density);
    seen.color = vec4(Sound(textureLod(color_buffer, uv, log2(max(diameter, 1.0))).rgb), Fade(uv));
    return seen;
}
