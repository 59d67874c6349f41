#version 460
// Each pixel's reflection from its own and its neighbours' rays, and the composite.

#include "unified/parameters.glsl"
#include "unified/ray.glsl"
#include "unified/gloss.glsl"

layout(binding = 1) uniform sampler2D depth_buffer;    // reversed
layout(binding = 2) uniform sampler2D normal_buffer;   // view space
layout(binding = 3) uniform sampler2D material_buffer; // reflectivity, roughness
layout(binding = 4) uniform sampler2D color_buffer;    // lit colour, linear
layout(binding = 5) uniform sampler2D fine_place;      // gloss_fine.frag
layout(binding = 6) uniform sampler2D fine_color;
layout(binding = 7) uniform sampler2D coarse_place;    // gloss_coarse.comp
layout(binding = 8) uniform sampler2D coarse_color;

layout(location = 0) out vec4 out_reflection;
layout(location = 1) out vec4 out_color;

// What a ray weighs at least, so that a pixel without a fitting neighbour takes what there is.
#define LEAST_WEIGHT 1e-4

struct Lobe {
    vec3 point;  // of the pixel, in ViewPoint's scale
    vec3 normal;
    vec3 mirror;
    float power; // alpha + 1
};

struct Sum {
    vec4 color;    // and fade
    float weight;  // of all rays
    float hits;    // of those that hit
};

// Adds a ray. Its weight is lobe / density, bounded: 2 f / (f + q) is f / q where they agree, and never
// above 2, however little a neighbour expected what matters here. The densities of different roughness
// compare as they stand.
void Gather(inout Sum sum, Lobe lobe, vec4 place, vec4 color, float share) {
    if (place.w == 0.0)
        return;
    bool hit = place.w > 0.0;
    vec3 to = hit ? normalize(place.xyz - lobe.point) : place.xyz;
    float f = lobe.power * exp2((lobe.power - 1.0) * LOG2_E * LogCos(to, lobe.mirror));
    float weight = share * max(2.0 * f / (f + abs(place.w)), LEAST_WEIGHT);
    sum.weight += weight;
    if (hit && dot(to, lobe.normal) > 0.0) {
        sum.color += weight * color;
        sum.hits += weight;
    }
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    out_reflection = vec4(0.0);
    out_color = vec4(texelFetch(color_buffer, pixel, 0).rgb, 1.0);
    vec2 material = texelFetch(material_buffer, pixel, 0).rg;
    if (!(material.r > REFLECTS_ABOVE))
        return;
    float depth = texelFetch(depth_buffer, pixel, 0).r;
    vec3 normal = texelFetch(normal_buffer, pixel, 0).xyz;
    if (!(depth > 0.0) || normal == vec3(0.0))
        return;
    Lobe lobe;
    lobe.point = ViewPoint(gl_FragCoord.xy, depth);
    lobe.normal = normal;
    lobe.mirror = MirrorDirection(lobe.point, normal);
    lobe.power = LobePower(material.g);

    Sum sum = Sum(vec4(0.0), 0.0, 0.0);
    if (material.g <= 0.0) {
        vec4 place = texelFetch(fine_place, pixel, 0);
        if (place.w > 0.0)
            sum = Sum(texelFetch(fine_color, pixel, 0), 1.0, 1.0);
    } else if (material.g <= COARSE_ABOVE) {
        // A tent over 3 x 3: every direction of the 2 x 2 pattern has the same weight.
        for (int y = -1; y <= 1; ++y) {
            for (int x = -1; x <= 1; ++x) {
                ivec2 at = clamp(pixel + ivec2(x, y), ivec2(0), unified.size - 1);
                float share = (x == 0 ? 1.0 : 0.5) * (y == 0 ? 1.0 : 0.5);
                Gather(sum, lobe, texelFetch(fine_place, at, 0), texelFetch(fine_color, at, 0), share);
            }
        }
    } else {
        // A box over four cells, widened by the pixel's place between cells: again every direction of
        // the 4 x 4 pattern has the same weight, wherever the pixel stands.
        ivec2 cell = pixel >> 1, cells = textureSize(coarse_place, 0);
        vec2 offset = 0.5 * vec2(pixel & 1) - 0.25;
        for (int y = -2; y <= 2; ++y) {
            for (int x = -2; x <= 2; ++x) {
                vec2 ends = clamp(2.5 - abs(vec2(x, y) - offset), 0.0, 1.0);
                ivec2 at = clamp(cell + ivec2(x, y), ivec2(0), cells - 1);
                Gather(sum, lobe, texelFetch(coarse_place, at, 0), texelFetch(coarse_color, at, 0), ends.x * ends.y);
            }
        }
    }
    if (sum.hits > 0.0) {
        out_reflection = vec4(sum.color.rgb / sum.weight, sum.color.a / sum.hits);
        out_color.rgb += material.r * out_reflection.a * out_reflection.rgb;
    }
}
