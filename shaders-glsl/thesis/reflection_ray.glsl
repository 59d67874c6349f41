// The reflection ray in screen space (thesis Alg. 2, Eq. 2.3). Needs parameters.glsl.

// Print: §4.2.2, Alg. 2.
// 1: Project(P_VS, M_proj)
vec3 Project(vec3 P_vs) {
    // 2: P_PS <- M_proj * P_VS; Transform into projection space
    vec4 P_ps = thesis.projection * vec4(P_vs, 1.0);
    // 3: P_SS <- P_PS_xyz / P_PS_w; Unproject point with division by W
    vec3 P_ss = P_ps.xyz / P_ps.w;
    // 4: P_SS_xy <- P_SS_xy * (0.5, -0.5) + (0.5, 0.5); Transform X and Y from [-1, 1] to [0, 1] and invert Y
    P_ss.xy = P_ss.xy * vec2(0.5, -0.5) + vec2(0.5);
    // 5: return P_SS; Return final point in screen space
    return P_ss;
}

// 6: Unproject(P_SS, M_proj^-1)
vec3 Unproject(vec3 P_ss) {
    // 7: P_SS_xy <- (P_SS_xy - (0.5, 0.5)) * (2, -2); Transform X and Y from [0, 1] to [-1, 1] and invert Y
    P_ss.xy = (P_ss.xy - vec2(0.5)) * vec2(2.0, -2.0);
    // 8: P_PS <- M_proj^-1 * P_SS; Transform into projection space
    vec4 P_ps = thesis.inverse_projection * vec4(P_ss, 1.0);
    // 9: return P_PS_xyz / P_PS_w; Return unprojected point with division by W
    return P_ps.xyz / P_ps.w;
}

// 10: ReflectionRay(TexCoord, z, N_VS, M_proj)
// Departure: R_vs, the reflection direction in view space, is returned as well.
vec3 ReflectionRay(vec2 texCoord, float z, vec3 N_vs, out vec3 R_vs) {
    // 11: P_SS <- (TexCoord_xy, z); Get pixel position in screen space
    vec3 P_ss = vec3(texCoord, z);
    // 12: P_VS <- Unproject(P_SS, M_proj^-1); Unproject pixel position into view space
    vec3 P_vs = Unproject(P_ss);
    // 13: D_VS <- normalize(P_VS); Get view direction in view space
    vec3 D_vs = normalize(P_vs);
    // 14: R_VS <- reflect(D_VS, N_VS); Get reflection in view space
    R_vs = reflect(D_vs, N_vs);
    // 15: O_SS <- Project(P_VS + R_VS * epsilon, M_proj); Project reflection offset into screen space
    // Departure: epsilon is not printed; it is the near plane's distance (author's program).
    vec3 O_ss = Project(P_vs + R_vs * thesis.reflection_offset);
    // 16, 17: V_SS <- O_SS - P_SS; Return final reflection vector
    return O_ss - P_ss;
}
