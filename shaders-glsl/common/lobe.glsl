// The glossy lobe of docs/definitions.md, "Surfaces": cos^alpha around the mirror direction.

#ifndef COMMON_LOBE_GLSL
#define COMMON_LOBE_GLSL

#include "common/constants.glsl"

#define LOG2_E 1.442695

// The lobe power alpha + 1 of docs/definitions.md, "Surfaces": ln xi / ln cos(roughness / 2). The cosine's logarithm
// comes from its series in h = (roughness / 2)^2, without cancellation. At roughness 1, the greatest, the series errs
// by 1e-4.
float LobePower(float roughness) {
    float h = 0.25 * roughness * roughness;
    return -log(XI) / max(h * (0.5 + h * (1.0 / 12.0 + h / 45.0)), 1e-12);
}

// The natural logarithm of the cosine of an angle, by its series in x, which is 1 minus this cosine.
float LogCos(float x) {
    return -x * (1.0 + x * (0.5 + x * (1.0 / 3.0 + x * 0.25)));
}

// Two unit vectors perpendicular to a unit vector and to each other, without a division by zero (Duff et al. 2017).
mat2x3 Tangents(vec3 axis) {
    float s = axis.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (s + axis.z);
    float b = axis.x * axis.y * a;
    return mat2x3(vec3(1.0 + s * axis.x * axis.x * a, s * b, -s * axis.x), vec3(b, s + axis.y * axis.y * a, -axis.y));
}

// The unit direction in a lobe around the unit vector `axis` for a point u of the unit square, by the inverse of the
// lobe's distribution (Eq. 4.5 with arccos): cos^(alpha + 1) = 1 - u.x. `power` is alpha + 1, `log_rest` is ln(1 -
// u.x), and `turn` has the cosine and sine of 2 pi u.y.
vec3 LobeDirection(vec3 axis, float power, float log_rest, vec2 turn) {
    float x = 2.0 * log_rest / power;
    // sin^2 = -expm1(x), by its series: x is near 0.
    float sin_theta = sqrt(max(-x * (1.0 + x * (0.5 + x * (1.0 / 6.0 + x / 24.0))), 0.0));
    float cos_theta = sqrt(max(1.0 - sin_theta * sin_theta, 0.0));
    mat2x3 tangents = Tangents(axis);
    return axis * cos_theta + sin_theta * (tangents[0] * turn.x + tangents[1] * turn.y);
}

// Mirrors the direction in which a view-space point is seen at a normal of any length. The result has unit length.
vec3 MirrorDirection(vec3 point, vec3 normal) {
    vec3 seen = point * inversesqrt(dot(point, point));
    return seen - (2.0 * dot(seen, normal) / dot(normal, normal)) * normal;
}

// The logarithm to base 2 of the probability density (alpha + 1) cos^alpha with which a direction is drawn, plus a
// bias. The factor 1 / (2 pi) of all densities is left out. `power` is alpha + 1, and `log_rest` is the logarithm to
// base 2 of the direction's cos^(alpha + 1).
float LogDensity(float power, float log_rest) {
    return LOG_DENSITY_BIAS + log2(power) + (power - 1.0) / power * log_rest;
}

#endif
