// The cone-tracing pass (thesis 4.2.8: Eq. 4.5, 4.6, Alg. 5) and the border fade (4.2.9: Eq. 4.7).
// Needs parameters.glsl.

layout(binding = 4) uniform sampler2D colorBuffer;      // pre-convolved, trilinear
layout(binding = 5) uniform sampler2D visibilityBuffer; // pre-integrated, trilinear

#include "common/constants.glsl"
#include "thesis/cone_angle.glsl"
#include "thesis/border_fade.glsl"

// Print: §4.2.8, Eq. 4.5.
// 1: alpha = alpha_min + (alpha_max - alpha_min) * roughness
// Erratum: alpha falls with roughness, so that the ends of the interpolation are swapped. They are not printed.
float InterpolatedConeAngle(float roughness) {
    float alpha = mix(thesis.cone_alpha_max, thesis.cone_alpha_min, roughness);

    // 2, 3: theta = cos(xi^(1 / (alpha + 1))), xi = 0.244; "we can interpolate theta to zero if alpha is greater than 1000"
    // Erratum: arccos, not cos.
    return alpha > thesis.cone_mirror_alpha ? 0.0 : acos(pow(thesis.cone_xi, 1.0 / (alpha + 1.0)));
}

// Half the angle of the cone that holds the share 1 - xi of the lobe of a roughness. For xi = 0.244 it is the angle of
// the author's program.
float LobeConeAngle(float roughness) {
    float theta = ConeAngle(roughness);
    return thesis.cone_xi == XI ? theta : acos(pow(cos(theta), log(thesis.cone_xi) / log(XI)));
}

// Print: §4.2.8, Eq. 4.6.
// 1: a = 2 h * tan(theta)
float IsoscelesTriangleBase(float h, float theta) {
    return 2.0 * h * tan(theta);
}

// 2: r = a (sqrt(a^2 + 4 h^2) - a) / (4 h)
float IsoscelesTriangleInRadius(float h, float a) {
    return (a * (sqrt(a * a + 4.0 * h * h) - a)) / (4.0 * h);
}

// Colour times visibility, and visibility: what line 10 of Alg. 5 adds.
vec4 ConeSampleWeightedColor(vec2 P_sample, float l_mip) {
    vec3 color = textureLod(colorBuffer, P_sample, l_mip).rgb;
    float visibility = textureLod(visibilityBuffer, P_sample, l_mip).r;
    return vec4(color * visibility, visibility);
}

// Print: §4.2.8, Alg. 5.
// 1: HiZConeTrace(R, theta)
// Departure: R goes from the ray's origin to its intersection, both in screen space.
vec3 HiZConeTrace(vec2 R_origin, vec2 R_intersection, float theta) {
    vec2 R_direction = R_intersection - R_origin;

    // 2: h <- |R_direction|; Initialize h to length of reflection ray
    float h = length(R_direction);
    // 3: delta <- normalize(R_direction); Get normalized ray direction
    // Erratum, kept: 0/0 where the intersection is the origin.
    vec2 delta = normalize(R_direction);
    // 4: C <- (0, 0, 0, 0); Initialize reflection color and use alpha channel for visibility
    vec4 C = vec4(0.0);

    // Departure, off as published: the author's program lengthens the cone by its base.
    if (thesis.cone_lengthened != 0)
        h += IsoscelesTriangleBase(h, theta);

    // 5: while C_alpha < 1 do; Trace cone until the visibility reached 100%
    // Departure: "a good number of maximal iterations is 7", "a for-loop is used instead of a while-loop".
    for (int i = 0; i < thesis.cone_samples && C.a < 1.0; ++i) {
        // 6: a <- IsoscelesTriangleBase(h, theta); Calculate triangle base
        float a = IsoscelesTriangleBase(h, theta);
        // 7: r <- IsoscelesTriangleInRadius(h, a); Calculate in-radius
        float r = IsoscelesTriangleInRadius(h, a);
        // 8: P_sample <- R_origin + delta * (h - r); Calculate sample position
        vec2 P_sample = R_origin + delta * (h - r);
        // 9: l_MIP <- log2(r * max{Resolution_x, Resolution_y}); Convert in-radius into screen-space MIP level
        // Erratum, kept: r is measured in screen sides, of which the shorter has fewer pixels.
        float l_mip = log2(r * max(thesis.resolution.x, thesis.resolution.y));
        // 10: C <- C + ConeSampleWeightedColor(P_sample, l_MIP); Accumulate color with hierarchical buffers
        // Departure: log2(0) is clamped.
        C += ConeSampleWeightedColor(P_sample, max(l_mip, 0.0));
        // 11: h <- h - r * 2; Reduce height to move forwards
        h -= r * 2.0;
    }
    // 12: return C / C_alpha; Return normalized reflection color
    // Erratum, kept: 0/0 where no sample is visible.
    return C.rgb / C.a;
}

// Reflection colour, and its fade in alpha; a miss is black.
vec4 Reflection(vec2 texCoord, vec3 hit, vec3 reflectionVS, float roughness) {
    if (hit == vec3(-1.0))
        return vec4(0.0);
    float theta = thesis.cone_interpolated != 0 ? InterpolatedConeAngle(roughness) : LobeConeAngle(roughness);
    vec3 color = HiZConeTrace(texCoord, hit.xy, theta);
    float fade = 1.0;
    if (thesis.fade != 0) {
        fade = BorderFade(hit.xy, thesis.fade_start, thesis.fade_end);
        if (thesis.fade_towards_camera > 0.0)
            fade *= clamp(reflectionVS.z * thesis.fade_towards_camera, 0.0, 1.0);
    }
    return vec4(color, fade);
}
