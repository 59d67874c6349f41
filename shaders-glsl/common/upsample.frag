#version 460
#pragma program(Upsample)
#pragma in_either_stage
// Scales a smaller reflection up to full size, by interpolation between the four blocks around a pixel. Bilinear
// weights are multiplied by weights for how near a block lies to the pixel's plane and how alike the two normals are
// (joint bilateral upsampling; Kopf et al. 2007).

#include "common/either_stage.glsl"
#include "common/camera.glsl"
#include "common/constants.glsl"
#include "common/sight.glsl"

layout(push_constant) uniform UpsampleBlock {
    int divisor; // full pixels a side of a block
} block;

layout(binding = 1) uniform sampler2D depth_buffer;
layout(binding = 2) uniform sampler2D normal_buffer;
layout(binding = 3) uniform sampler2D material_buffer;
layout(binding = 4) uniform sampler2D small_reflection;

OUTPUT(0, rgba16f, vec4, out_reflection);

// Power of the cosine between two normals in the weight of a block; cos 20 deg to this power is 0.14.
#define NORMAL_POWER 32.0

// The view-space point that a pixel shows, in metres.
vec3 Position(ivec2 pixel) {
    vec2 ndc = (vec2(pixel) + 0.5) / camera.resolution * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    vec4 h = camera.clip_to_view_reversed * vec4(ndc, texelFetch(depth_buffer, pixel, 0).r, 1.0);
    return h.xyz / h.w;
}

bool Reflects(ivec2 pixel) {
    return texelFetch(material_buffer, pixel, 0).r > REFLECTS_ABOVE && texelFetch(depth_buffer, pixel, 0).r > 0.0;
}

SHADE(out_reflection) {
    ivec2 pixel = ivec2(PIXEL_CENTRE);
    out_reflection = vec4(0.0);
    if (!Reflects(pixel))
        return;
    vec3 position = Position(pixel);
    float reach = Reach(position.z, camera.clip_to_view_reversed);
    vec3 normal = texelFetch(normal_buffer, pixel, 0).xyz;
    ivec2 base = pixel / block.divisor;
    vec2 part = vec2(pixel - base * block.divisor) / float(block.divisor);
    ivec2 last = textureSize(small_reflection, 0) - 1;

    vec4 sum = vec4(0.0);
    float weights = 0.0;
    vec4 best_reflection = vec4(0.0); // of the most similar block; it is taken if no block is similar enough
    float best_weight = -1.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 step = ivec2(i & 1, i >> 1);
        ivec2 block_texel = min(base + step, last);
        ivec2 full_pixel = block_texel * block.divisor;
        float share = (step.x == 1 ? part.x : 1.0 - part.x) * (step.y == 1 ? part.y : 1.0 - part.y);
        if (share <= 0.0 || !Reflects(full_pixel))
            continue;
        // A block that lies off the pixel's plane by VISIBLE_WITHIN of the reach has lost most of its weight.
        float off_plane = dot(normal, Position(full_pixel) - position) / (VISIBLE_WITHIN * reach);
        float facing = max(dot(normal, texelFetch(normal_buffer, full_pixel, 0).xyz), 0.0);
        float weight = exp(-off_plane * off_plane) * pow(facing, NORMAL_POWER);
        vec4 reflection = texelFetch(small_reflection, block_texel, 0);
        sum += share * weight * reflection;
        weights += share * weight;
        if (weight > best_weight) {
            best_weight = weight;
            best_reflection = reflection;
        }
    }
    out_reflection = weights > 1e-3 ? sum / weights : best_reflection;
}
