// Reads the pixel with which every ray of the thesis begins: whether it reflects, and its reflection ray (Alg. 2).
// Needs parameters.glsl.

layout(binding = 1) uniform sampler2D hiZBuffer;       // standard depth, minimum and maximum
layout(binding = 2) uniform sampler2D normalBuffer;    // view space
layout(binding = 3) uniform sampler2D materialBuffer;  // reflectivity, roughness

#include "common/constants.glsl"
#include "thesis/reflection_ray.glsl"

struct Pixel {
    bool reflects;
    vec3 P_ss;         // texture coordinates and standard depth
    vec3 V_ss;         // reflection vector in screen space (Alg. 2)
    vec3 reflection;   // direction in view space
    float roughness;
};

// Reads the pixel whose centre is at `fragCoord`, in pixels.
Pixel ReadPixel(vec2 fragCoord) {
    ivec2 coord = ivec2(fragCoord);
    Pixel pixel = Pixel(false, vec3(0.0), vec3(0.0), vec3(0.0), 0.0);
    vec2 material = texelFetch(materialBuffer, coord, 0).rg;
    vec3 normal = texelFetch(normalBuffer, coord, 0).xyz;
    // Early out: sky and what reflects nothing (author's program: both thresholds).
    if (material.r <= REFLECTS_ABOVE || dot(normal, normal) <= NO_NORMAL)
        return pixel;
    pixel.reflects = true;
    pixel.roughness = material.g;
    pixel.P_ss = vec3(fragCoord / thesis.resolution, texelFetch(hiZBuffer, coord, 0).r);
    pixel.V_ss = ReflectionRay(pixel.P_ss.xy, pixel.P_ss.z, normalize(normal), pixel.reflection);
    return pixel;
}
