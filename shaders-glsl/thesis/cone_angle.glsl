// The cone that a roughness stands for (thesis 4.2.8, Eq. 4.5).

// Erratum: Eq. 4.5 is printed with a cosine for the arc cosine and an exponent that grows with roughness. This is the half
// angle of the author's program. Eq. 4.5 with its arc cosine gives it back for the exponent of the lobe that a roughness
// means everywhere in this project (docs/definitions.md, "Surfaces"), so that the share 1 - xi of that lobe lies within the
// cone. "For a perfect specular reflection the power would need to be infinite", and the angle is 0.
float ConeAngle(float roughness) {
    return 0.5 * max(roughness, 0.0);
}
