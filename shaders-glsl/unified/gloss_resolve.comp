#version 460
// Each pixel's reflection, from the rays around it or from the cells around it, and the composite.

layout(local_size_x = 8, local_size_y = 8) in;

#include "unified/parameters.glsl"
#include "unified/ray.glsl"
#include "unified/gloss.glsl"

layout(binding = 1) uniform sampler2D depth_buffer;    // reversed
layout(binding = 2) uniform sampler2D normal_buffer;   // view space
layout(binding = 3) uniform sampler2D material_buffer; // reflectivity, roughness
layout(binding = 4) uniform sampler2D color_buffer;    // lit colour, linear
layout(binding = 5, rgba32f) uniform readonly image2D fine_place; // gloss_fine.frag
layout(binding = 6, rgba16f) uniform readonly image2D fine_color;
layout(binding = 7, rgba16f) uniform readonly image2D cell_reflection; // gloss_cells.comp
layout(binding = 8, rgba16f) uniform readonly image2D cell_surface;
layout(binding = 9, rgba16f) uniform writeonly image2D reflection_image;
layout(binding = 10, rgba16f) uniform writeonly image2D composite_image;

#include "unified/gloss_gather.glsl"

// Off its plane by this share of its depth, a cell has lost most of its weight: the world's tolerance
// in DEFINITIONS, "World agreement".
#define PLANE_TOLERANCE 0.02

// A narrow lobe, from the cross of five rays around the pixel.
vec4 Narrow(ivec2 pixel, Lobe lobe) {
    Sum sum = Sum(vec4(0.0), 0.0, 0.0);
    for (int i = 0; i < 5; ++i) {
        ivec2 step = ivec2(int(i == 1) - int(i == 2), int(i == 3) - int(i == 4));
        ivec2 at = clamp(pixel + step, ivec2(0), unified.size - 1);
        Gather(sum, lobe, imageLoad(fine_place, at), imageLoad(fine_color, at));
    }
    return Reflection(sum);
}

// A wide lobe: bilinear between cells, as far as they lie in the pixel's plane and face its way (joint
// bilateral upsampling; Kopf et al. 2007).
vec4 Wide(ivec2 pixel, vec3 point, vec3 normal) {
    ivec2 cell = pixel >> 1, last = (unified.size - 1) >> 1;
    vec2 f = 0.5 * vec2(pixel & 1);
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 step = ivec2(i & 1, i >> 1);
        ivec2 at = min(cell + step, last);
        vec4 surface = imageLoad(cell_surface, at);
        vec3 there = ViewPoint(vec2(2 * at) + 0.5, surface.w - unified.depth_offset);
        float off = dot(normal, there - point) / (PLANE_TOLERANCE * point.z);
        float facing = max(dot(normal, surface.xyz), 0.0);
        facing *= facing;
        facing *= facing;
        facing *= facing;
        facing *= facing;
        facing *= facing; // to the 32nd: cos 20 deg is 0.14
        float share = (step.x == 1 ? f.x : 1.0 - f.x) * (step.y == 1 ? f.y : 1.0 - f.y);
        float weight = surface.w > 0.0 ? share * max(facing / (1.0 + off * off * off * off), LEAST_WEIGHT) : 0.0;
        sum += weight * imageLoad(cell_reflection, at);
        weights += weight;
    }
    return weights > 0.0 ? sum / weights : vec4(0.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, unified.size)))
        return;
    vec4 reflection = vec4(0.0);
    vec3 color = texelFetch(color_buffer, pixel, 0).rgb;
    vec2 material = texelFetch(material_buffer, pixel, 0).rg;
    float depth = texelFetch(depth_buffer, pixel, 0).r;
    if (material.r > REFLECTS_ABOVE && depth > 0.0) {
        vec3 normal = texelFetch(normal_buffer, pixel, 0).xyz;
        if (material.g > COARSE_ABOVE) {
            reflection = Wide(pixel, ViewPoint(vec2(pixel) + 0.5, depth), normal);
        } else if (material.g > 0.0) {
            reflection = Narrow(pixel, LobeOf(pixel, depth, normal, material.g));
        } else {
            reflection = imageLoad(fine_color, pixel);
        }
        color += material.r * reflection.a * reflection.rgb;
    }
    imageStore(reflection_image, pixel, reflection);
    imageStore(composite_image, pixel, vec4(color, 1.0));
}
