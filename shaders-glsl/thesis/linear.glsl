// `linear`: every ray by one of the marches of thesis 4.2.2, and the colour where it ends: a mirror
// lookup, whatever the roughness. FIXED chooses the first listing; HITS adds the intersections.

#include "thesis/parameters.glsl"
#include "thesis/pixel.glsl"
#include "thesis/linear_ray_march.glsl"
#include "thesis/border_fade.glsl"

layout(binding = 4) uniform sampler2D colorBuffer; // lit colour, bilinear

layout(location = 0) out vec4 out_reflection; // colour, and fade in a
#ifdef HITS
layout(location = 1) out vec4 out_hit; // texture coordinates, standard depth, PATH_*
#define HIT(value) out_hit = value
#else
#define HIT(value)
#endif

void main() {
    out_reflection = vec4(0.0);
    HIT(vec4(INVALID_RAY, PATH_NONE));
    Pixel pixel = ReadPixel(gl_FragCoord.xy);
    if (!pixel.reflects)
        return;

    // Departure: the first sample is a step away; at the pixel itself the ray is as deep as the buffer.
    vec3 dir = normalize(pixel.V_ss);
    float stride = thesis.linear_march_stride;
#ifdef FIXED
    vec3 hit = UniformRayMarch(pixel.P_ss + dir * stride, dir, stride, thesis.linear_march_count);
#else
    vec3 hit = LinearRayMarch(pixel.P_ss + dir * stride, dir, stride);
#endif
    HIT(vec4(hit, hit == INVALID_RAY ? PATH_LINEAR_MISS : PATH_LINEAR));
    if (hit == INVALID_RAY)
        return;
    float fade = thesis.fade != 0 ? BorderFade(hit.xy, thesis.fade_start, thesis.fade_end) : 1.0;
    out_reflection = vec4(textureLod(colorBuffer, hit.xy, 0.0).rgb, fade);
}
