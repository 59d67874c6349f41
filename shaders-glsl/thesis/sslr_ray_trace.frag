#version 460
#pragma program(SslrRayTrace)
#pragma in_either_stage
// `sslr`, stage 1: uniform ray march, with the step chosen by roughness and no refinement (thesis 4.3.1). Writes the
// colour at the intersection with the ray's length in a, and the mask. With HITS, it also writes the intersection
// itself, which the method does not read.

#include "common/either_stage.glsl"
#include "thesis/parameters.glsl"
#include "thesis/pixel.glsl"
#include "thesis/linear_ray_march.glsl"

layout(binding = 4) uniform sampler2D colorBuffer; // lit colour

layout(constant_id = 0) const bool HITS = false; // whether out_hit is wanted

OUTPUT(0, rgba32f, vec4, rayTraceColor);
OUTPUT(1, r8, float, rayTraceMask);
OUTPUT(2, rgba32f, vec4, out_hit); // texture coordinates, standard depth, PATH_*

SHADE_ALL(rayTraceColor, STORE(rayTraceMask) STORE_IF(HITS, out_hit)) {
    rayTraceColor = vec4(0.0);
    rayTraceMask = 0.0;
    if (HITS)
        out_hit = vec4(INVALID_RAY, PATH_NONE);
    Pixel pixel = ReadPixel(PIXEL_CENTRE);
    if (!pixel.reflects)
        return;

    // "The higher the roughness the larger the step size" (both ends, and the host's LINEAR_MARCH_COUNT: author's program).
    float stride = mix(thesis.uniform_stride_min, thesis.uniform_stride_max, pixel.roughness);
    vec3 dir = normalize(pixel.V_ss);
    vec3 hit = UniformRayMarch(pixel.P_ss + dir * stride, dir, stride);
    if (HITS)
        out_hit = vec4(hit, PATH_LINEAR_MISS);
    if (hit == INVALID_RAY)
        return;

    hit -= dir * (stride * thesis.uniform_march_back);
    float rayLength = min(distance(pixel.P_ss.xy, hit.xy), 1.0);
    rayTraceColor = vec4(textureLod(colorBuffer, hit.xy, 0.0).rgb, rayLength);
    rayTraceMask = 1.0;
    if (HITS)
        out_hit = vec4(hit, PATH_LINEAR);
}
