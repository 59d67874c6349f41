// The ray-tracing pass (thesis 4.2.7, 4.2.10, Alg. 6). Needs parameters.glsl.

#include "thesis/pixel.glsl"
#include "thesis/linear_ray_march.glsl"
#include "thesis/hi_z_ray_trace.glsl"

// Whether rays towards the camera are marched: of `ssct` they are, of `hzct` not.
layout(constant_id = 0) const bool FALLBACK = true;

struct Trace {
    vec3 hit;          // texture coordinates and standard depth; INVALID_RAY for a miss
    float path;        // PATH_*
    vec3 reflection;   // direction in view space
    float roughness;
};

// Alg. 6. Erratum: it tests R_direction after Eq. 4.4 has made its z 1; V_ss.z is what is meant.
vec3 RayTrace(vec3 P_ss, vec3 V_ss, out float path) {
    if (V_ss.z <= thesis.view_direction_epsilon) {
        if (!FALLBACK) {
            path = PATH_UNTRACED;
            return INVALID_RAY;
        }
        // Unit length, so that the stride is one of screen space (author's program).
        vec3 hit = LinearRayMarch(P_ss, normalize(V_ss), thesis.linear_march_stride);
        path = hit == INVALID_RAY ? PATH_LINEAR_MISS : PATH_LINEAR;
        return hit;
    }
    bool exhausted;
    vec3 hit = HiZRayTrace(P_ss, V_ss, exhausted);
    path = hit == INVALID_RAY ? PATH_MISS : exhausted ? PATH_EXHAUSTED : PATH_HI_Z;
    return hit;
}

Trace TracePixel(vec2 fragCoord) {
    Trace trace = Trace(INVALID_RAY, PATH_NONE, vec3(0.0), 0.0);
    Pixel pixel = ReadPixel(fragCoord);
    if (!pixel.reflects)
        return trace;
    trace.hit = RayTrace(pixel.P_ss, pixel.V_ss, trace.path);
    trace.reflection = pixel.reflection;
    trace.roughness = pixel.roughness;
    return trace;
}
