// The cone that a roughness stands for (thesis 4.2.8, Eq. 4.5).

#include "common/constants.glsl"

// Eq. 4.5. Errata: arccos, not cos; and the exponent must fall with roughness. The thesis prints
// no range of exponents: alpha is the lobe that a roughness stands for everywhere in this project
// (docs/definitions.md, "Surfaces"), which makes the angle the author's, half the roughness.
float ConeAngle(float roughness) {
    if (roughness <= 0.0)
        return 0.0; // "for a perfect specular reflection the power would need to be infinite"
    float alpha = log(XI) / log(cos(0.5 * roughness)) - 1.0;
    if (alpha > 1e5)
        return 0.5 * roughness; // the arccos of nearly 1 has no digits left; this is its limit
    return acos(pow(XI, 1.0 / (alpha + 1.0)));
}
