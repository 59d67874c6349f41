#version 460
#pragma program(Linear)
#pragma in_either_stage
// The method `linear` follows every ray by one of the marches of thesis 4.2.2, and shows the colour where it ends,
// whatever the roughness.

#include "common/either_stage.glsl"
#include "thesis/parameters.glsl"
#include "thesis/pixel.glsl"
#include "thesis/linear_ray_march.glsl"
#include "thesis/border_fade.glsl"

layout(binding = 4) uniform sampler2D colorBuffer; // lit colour, bilinear

layout(constant_id = 0) const bool FIXED = false; // the first listing, of a constant stride; else the second
layout(constant_id = 1) const bool HITS = false;  // whether out_hit is wanted

OUTPUT(0, rgba16f, vec4, out_reflection); // colour, and fade in alpha
OUTPUT(1, rgba32f, vec4, out_hit);        // texture coordinates, standard depth, PATH_*

SHADE_ALL(out_reflection, STORE_IF(HITS, out_hit)) {
    out_reflection = vec4(0.0);
    if (HITS)
        out_hit = vec4(INVALID_RAY, PATH_NONE);
    Pixel pixel = ReadPixel(PIXEL_CENTRE);
    if (!pixel.reflects)
        return;

    // Departure: the first sample is a step away; at the pixel itself the ray is as deep as the buffer.
    vec3 dir = normalize(pixel.V_ss);
    float stride = thesis.linear_march_stride;
    vec3 hit;
    if (FIXED)
        hit = UniformRayMarch(pixel.P_ss + dir * stride, dir, stride);
    else
        hit = LinearRayMarch(pixel.P_ss + dir * stride, dir, stride);
    if (HITS)
        out_hit = vec4(hit, hit == INVALID_RAY ? PATH_LINEAR_MISS : PATH_LINEAR);
    if (hit == INVALID_RAY)
        return;
    float fade = thesis.fade != 0 ? BorderFade(hit.xy, thesis.fade_start, thesis.fade_end) : 1.0;
    out_reflection = vec4(textureLod(colorBuffer, hit.xy, 0.0).rgb, fade);
}
