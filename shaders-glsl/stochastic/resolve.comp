#version 460
#pragma program(StochasticResolve)
// Each pixel gathers the rays around it as samples of its own lobe. The weight of a ray is the pixel's lobe in the
// direction of what the ray hit, over the density with which the ray was drawn at its own pixel. The weighted sum is
// divided by the sum of the weights (the ratio estimator of Stachowiak 2015, and of Heitz et al. 2018). Rays of one
// turn are added to those of the turns before.

layout(local_size_x = 8, local_size_y = 8) in;

#include "stochastic/stochastic.glsl"

layout(binding = 1) uniform sampler2D depth_buffer;    // reversed
layout(binding = 2) uniform sampler2D normal_buffer;   // view space
layout(binding = 3) uniform sampler2D material_buffer; // reflectivity, roughness
layout(binding = 4) uniform sampler2D place_buffer;    // written by StochasticExact or StochasticThesis
layout(binding = 5) uniform sampler2D seen_buffer;
layout(binding = 6, rgba32f) uniform image2D sum_image;                  // of all turns so far: colours, and fades
layout(binding = 7, rgba32f) uniform image2D weight_image;               // weights of rays, of hits, and hits times distance
layout(binding = 8, rgba16f) uniform writeonly image2D reflection_image; // colour, and fade in alpha
layout(binding = 9, rg32ui) uniform writeonly uimage2D ends_image;       // distance to the reflected point (unified/ends.glsl)

layout(constant_id = 0) const bool OVER = false; // another reflection shows where this one misses

// The greatest weight of a ray, which is lobe over density, as a logarithm to base 2.
#define GREATEST_WEIGHT 4.0

// The pixel from which `pixel` gathers its n-th ray: on a spiral of golden angles, rotated by `rotation` radians.
ivec2 NeighbourPixel(ivec2 pixel, int n, float rotation) {
    float share = float(n) / float(max(stochastic.gathered - 1, 1));
    float angle = rotation + GOLDEN_ANGLE * float(n);
    vec2 offset = stochastic.radius * sqrt(share) * vec2(cos(angle), sin(angle));
    return clamp(pixel + ivec2(round(offset)), ivec2(0), unified.size - 1);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, unified.size)))
        return;
    vec4 sum = vec4(0.0);
    vec3 weights = vec3(0.0);
    if (stochastic.first == 0) {
        sum = imageLoad(sum_image, pixel);
        weights = imageLoad(weight_image, pixel).xyz;
    }
    vec4 own_ray = texelFetch(place_buffer, pixel, 0);
    if (own_ray.w != 0.0) {
        float depth = texelFetch(depth_buffer, pixel, 0).r;
        vec3 normal = texelFetch(normal_buffer, pixel, 0).xyz;
        float roughness = texelFetch(material_buffer, pixel, 0).y;
        vec3 point = ViewPoint(vec2(pixel) + 0.5, depth);
        vec3 mirror = MirrorDirection(point, normal);
        float power = LobePower(roughness);
        // A mirror has its own ray alone.
        int gathered = roughness <= 0.0 ? 1 : stochastic.gathered;
        float rotation = TAU * GradientNoise(vec2(pixel) + 5.588238 * float(stochastic.turn & 63));
        for (int n = 0; n < gathered; ++n) {
            ivec2 neighbour = n == 0 ? pixel : NeighbourPixel(pixel, n, rotation);
            vec4 place = texelFetch(place_buffer, neighbour, 0);
            vec4 seen_color = texelFetch(seen_buffer, neighbour, 0);
            bool is_hit = place.w > 0.0;
            vec3 away = is_hit ? place.xyz - point : place.xyz;
            float squared = dot(away, away);
            vec3 direction = away * inversesqrt(max(squared, 1e-30));
            vec3 chord = direction - mirror;
            // 1 - cos of the angle to the mirror direction, without its cancellation.
            float from_mirror = 0.5 * dot(chord, chord);
            float log_rest = from_mirror < 1.0 ? power * LOG2_E * LogCos(from_mirror) : -1e4;
            float log_weight = LogDensity(power, log_rest) - abs(place.w);
            float weight = n == 0 ? 1.0 : place.w != 0.0 ? exp2(min(log_weight, GREATEST_WEIGHT)) : 0.0;
            // A direction below the surface shows nothing, but its weight counts.
            bool is_seen = is_hit && dot(direction, normal) > 0.0;
            sum += is_seen ? weight * seen_color : vec4(0.0);
            weights += weight * (is_seen ? vec3(1.0, 1.0, sqrt(squared)) : vec3(1.0, 0.0, 0.0));
        }
    }
    if (stochastic.last == 0) {
        imageStore(sum_image, pixel, sum);
        imageStore(weight_image, pixel, vec4(weights, 0.0));
        return;
    }
    // A miss counts as black; over another reflection it lowers the fade instead.
    vec4 reflection = vec4(0.0);
    if (weights.y > 0.0)
        reflection = vec4(sum.rgb / weights.x, sum.a / weights.y);
    if (OVER && weights.y > 0.0) {
        // The fade is rounded as it is stored, so that colour times fade is the same as without another reflection.
        float fade = unpackHalf2x16(packHalf2x16(vec2(sum.a / weights.x, 0.0))).x;
        reflection = fade > 0.0 ? vec4(reflection.rgb * (reflection.a / fade), fade) : vec4(0.0);
    }
    imageStore(reflection_image, pixel, vec4(Sound(reflection.rgb), min(Sound(reflection.a), 1.0)));
    float mean_distance = weights.y > 0.0 ? weights.z / weights.y : 0.0;
    imageStore(ends_image, pixel, uvec4(floatBitsToUint(mean_distance), NO_TRIANGLE, 0u, 0u));
}
