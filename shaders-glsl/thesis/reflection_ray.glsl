// The reflection ray in screen space (thesis Alg. 2, Eq. 2.3). Needs parameters.glsl.

vec3 Project(vec3 P_vs) {
    vec4 P_ps = thesis.projection * vec4(P_vs, 1.0);
    vec3 P_ss = P_ps.xyz / P_ps.w;
    P_ss.xy = P_ss.xy * vec2(0.5, -0.5) + vec2(0.5);
    return P_ss;
}

vec3 Unproject(vec3 P_ss) {
    P_ss.xy = (P_ss.xy - vec2(0.5)) * vec2(2.0, -2.0);
    vec4 P_ps = thesis.inverse_projection * vec4(P_ss, 1.0);
    return P_ps.xyz / P_ps.w;
}

// V_ss, and in R_vs the reflection direction in view space.
vec3 ReflectionRay(vec2 texCoord, float z, vec3 N_vs, out vec3 R_vs) {
    vec3 P_ss = vec3(texCoord, z);                                   // Pixel position in screen space
    vec3 P_vs = Unproject(P_ss);                                     // Unproject into view space
    vec3 D_vs = normalize(P_vs);                                     // View direction in view space
    R_vs = reflect(D_vs, N_vs);                                      // Reflection in view space
    vec3 O_ss = Project(P_vs + R_vs * thesis.reflection_offset);     // Reflection offset in screen space
    return O_ss - P_ss;                                              // Reflection vector in screen space
}
