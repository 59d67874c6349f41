#version 460
#pragma program(Bump)
#pragma in_either_stage
// Bump mapping after the tracing (thesis 4.4, after the game Thief). Each pixel shows the reflection of a pixel beside
// it, displaced by how far the shading normal deviates from the normal that rays were reflected at.

#include "common/either_stage.glsl"
#include "common/constants.glsl"

layout(push_constant) uniform BumpBlock {
    float strength; // screen heights for a deviation of 1
} bump;

layout(binding = 0) uniform sampler2D reflection_buffer;
layout(binding = 1) uniform sampler2D normal_buffer;       // shading normals, view space
layout(binding = 2) uniform sampler2D trace_normal_buffer; // normals that rays were reflected at
layout(binding = 3) uniform sampler2D material_buffer;     // reflectivity, roughness

OUTPUT(0, rgba16f, vec4, out_reflection);

// Least cosine between the traced normals of two pixels that are taken to lie on one surface.
#define ONE_SURFACE 0.9

SHADE(out_reflection) {
    ivec2 pixel = ivec2(PIXEL_CENTRE);
    out_reflection = vec4(0.0);
    if (texelFetch(material_buffer, pixel, 0).r <= REFLECTS_ABOVE)
        return;
    ivec2 size = textureSize(reflection_buffer, 0);
    vec3 trace_normal = texelFetch(trace_normal_buffer, pixel, 0).xyz;
    vec2 deviation = (texelFetch(normal_buffer, pixel, 0).xyz - trace_normal).xy;
    vec2 shift = deviation * vec2(1.0, -1.0) * bump.strength * float(size.y);
    ivec2 beside = clamp(ivec2(floor(PIXEL_CENTRE + shift)), ivec2(0), size - 1);
    // A pixel that lies on another surface, or does not reflect, has no reflection to lend.
    bool lends = texelFetch(material_buffer, beside, 0).r > REFLECTS_ABOVE
             && dot(texelFetch(trace_normal_buffer, beside, 0).xyz, trace_normal) > ONE_SURFACE;
    out_reflection = texelFetch(reflection_buffer, lends ? beside : pixel, 0);
}
