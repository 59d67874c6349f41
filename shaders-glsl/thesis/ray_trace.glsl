// The ray-tracing pass (thesis 4.2.7, 4.2.10, Alg. 6). Needs parameters.glsl.

#include "thesis/pixel.glsl"
#include "thesis/linear_ray_march.glsl"
#include "thesis/hi_z_ray_trace.glsl"

// Whether rays towards the camera are marched: `ssct` marches them, and `hzct` does not trace them.
layout(constant_id = 0) const bool FALLBACK = true;

struct Trace {
    vec3 hit;          // texture coordinates and standard depth; INVALID_RAY for a miss
    float path;        // PATH_*
    vec3 reflection;   // direction in view space
    float roughness;
};

// Print: §4.2.10, Alg. 6.
// 1: RayTrace(R)
vec3 RayTrace(vec3 P_ss, vec3 V_ss, out float path) {
    // 2: if R_direction_z <= epsilon then; Check if the ray points towards the camera
    // Erratum: Eq. 4.4 has made the z of R_direction 1; V_ss.z is what is meant.
    if (V_ss.z <= thesis.view_direction_epsilon) {
        // 3: LinearRayMarch(R); Use fallback method
        // Departure: `hzct` has none. The march's direction has unit length, so that the stride is one of screen space
        // (author's program).
        if (!FALLBACK) {
            path = PATH_UNTRACED;
            return INVALID_RAY;
        }
        vec3 hit = LinearRayMarch(P_ss, normalize(V_ss), thesis.linear_march_stride);
        path = hit == INVALID_RAY ? PATH_LINEAR_MISS : PATH_LINEAR;
        return hit;
    }
    // 4, 5: else HiZRayTrace(R); Use primary ray tracing method
    bool exhausted;
    vec3 hit = HiZRayTrace(P_ss, V_ss, exhausted);
    path = hit == INVALID_RAY ? PATH_MISS : exhausted ? PATH_EXHAUSTED : PATH_HI_Z;
    return hit;
}

// Traces the reflection ray of the pixel whose centre is at `fragCoord`. A pixel that does not reflect has no hit and
// the code PATH_NONE.
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
