// The cone-tracing pass (thesis 4.2.8: Eq. 4.5, 4.6, Alg. 5) and the border fade (4.2.9: Eq. 4.7).
// Needs parameters.glsl.

layout(binding = 4) uniform sampler2D colorBuffer;      // pre-convolved, trilinear
layout(binding = 5) uniform sampler2D visibilityBuffer; // pre-integrated, trilinear

#include "thesis/cone_angle.glsl"
#include "thesis/border_fade.glsl"

// Eq. 4.5 with the least changes that let it run. Errata: arccos, not cos; and alpha falls with roughness, so that the ends
// of its interpolation are swapped. "We can interpolate theta to zero if alpha is greater than 1000 for instance."
float InterpolatedConeAngle(float roughness) {
    float alpha = mix(thesis.cone_alpha_max, thesis.cone_alpha_min, roughness);
    return alpha > MIRROR_ALPHA ? 0.0 : acos(pow(XI, 1.0 / (alpha + 1.0)));
}

// Eq. 4.6
float IsoscelesTriangleBase(float h, float theta) {
    return 2.0 * h * tan(theta);
}

float IsoscelesTriangleInRadius(float h, float a) {
    return (a * (sqrt(a * a + 4.0 * h * h) - a)) / (4.0 * h);
}

vec4 ConeSampleWeightedColor(vec2 P_sample, float l_mip) {
    vec3 color = textureLod(colorBuffer, P_sample, l_mip).rgb;
    float visibility = textureLod(visibilityBuffer, P_sample, l_mip).r;
    return vec4(color * visibility, visibility);
}

// Alg. 5, from the ray's origin to its intersection in screen space. Errata, kept: 0/0 where the
// intersection is the origin, or where no sample is visible.
vec3 HiZConeTrace(vec2 R_origin, vec2 R_intersection, float theta) {
    vec2 R_direction = R_intersection - R_origin;
    float h = length(R_direction);              // Initialize h to length of reflection ray
    vec2 delta = normalize(R_direction);        // Get normalized ray direction
    vec4 C = vec4(0.0);                         // Reflection color; alpha for visibility
    if (thesis.cone_lengthened != 0)
        h += IsoscelesTriangleBase(h, theta);   // author's program

    for (int i = 0; i < thesis.cone_samples && C.a < 1.0; ++i) {
        float a = IsoscelesTriangleBase(h, theta);
        float r = IsoscelesTriangleInRadius(h, a);
        vec2 P_sample = R_origin + delta * (h - r);
        float l_mip = log2(r * max(thesis.resolution.x, thesis.resolution.y));
        C += ConeSampleWeightedColor(P_sample, max(l_mip, 0.0)); // Departure: log2(0) is clamped
        h -= r * 2.0;
    }
    return C.rgb / C.a;                         // Return normalized reflection color
}

// Reflection colour, and its fade in a; a miss is black.
vec4 Reflection(vec2 texCoord, vec3 hit, vec3 reflectionVS, float roughness) {
    if (hit == vec3(-1.0))
        return vec4(0.0);
    float theta = thesis.cone_interpolated != 0 ? InterpolatedConeAngle(roughness) : ConeAngle(roughness);
    vec3 color = HiZConeTrace(texCoord, hit.xy, theta);
    float fade = 1.0;
    if (thesis.fade != 0) {
        fade = BorderFade(hit.xy, thesis.fade_start, thesis.fade_end);
        if (thesis.fade_towards_camera > 0.0)
            fade *= clamp(reflectionVS.z * thesis.fade_towards_camera, 0.0, 1.0);
    }
    return vec4(color, fade);
}
