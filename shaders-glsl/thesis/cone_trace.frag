#version 460
#pragma program(ConeTrace)
#pragma in_either_stage
// `ssct` and `hzct`, split in two (4.2.3): the cone trace alone, from the ray trace's hits.

#include "common/either_stage.glsl"
#include "thesis/parameters.glsl"

layout(binding = 1) uniform sampler2D hitBuffer;       // texture coordinates, standard depth, PATH_*
layout(binding = 2) uniform sampler2D normalBuffer;    // view space
layout(binding = 3) uniform sampler2D materialBuffer;  // reflectivity, roughness
layout(binding = 6) uniform sampler2D hiZBuffer;       // standard depth

#include "thesis/reflection_ray.glsl"
#include "thesis/cone_trace.glsl"

OUTPUT(0, rgba16f, vec4, out_reflection); // colour, and fade in alpha

SHADE(out_reflection) {
    ivec2 pixel = ivec2(PIXEL_CENTRE);
    vec4 hit = texelFetch(hitBuffer, pixel, 0);
    vec2 texCoord = PIXEL_CENTRE / thesis.resolution;
    vec3 reflectionVS = vec3(0.0, 0.0, 1.0);
    if (thesis.fade_towards_camera > 0.0) {
        float depth = texelFetch(hiZBuffer, pixel, 0).r;
        vec3 normal = texelFetch(normalBuffer, pixel, 0).xyz;
        ReflectionRay(texCoord, depth, normalize(normal), reflectionVS);
    }
    out_reflection = Reflection(texCoord, hit.xyz, reflectionVS, texelFetch(materialBuffer, pixel, 0).g);
}
