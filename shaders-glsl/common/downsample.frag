#version 460
#pragma program(Downsample)
#pragma program(DownsampleNumbered, NUMBERED)
#pragma in_either_stage
// Makes a smaller G-buffer. A block's depth, normal and material are those of its top left texel, because a mean of two
// surfaces lies on neither. Its colour is the mean over the block. NUMBERED also writes which triangle the top left
// texel shows.

#include "common/either_stage.glsl"

layout(push_constant) uniform DownsampleBlock {
    int divisor; // full pixels a side of a block
} block;

layout(binding = 0) uniform sampler2D depth_buffer;
layout(binding = 1) uniform sampler2D normal_buffer;
layout(binding = 2) uniform sampler2D material_buffer;
layout(binding = 3) uniform sampler2D color_buffer;

#ifdef NUMBERED
layout(binding = 4, r32ui) uniform readonly uimage2D triangle_buffer;
OUTPUT_UINT(4, r32ui, out_triangle);
#define STORE_TRIANGLE STORE(out_triangle)
#else
#define STORE_TRIANGLE
#endif

OUTPUT(0, r32f, float, out_depth);
OUTPUT(1, rgba16f, vec4, out_normal);
OUTPUT(2, rg16f, vec2, out_material);
OUTPUT(3, rgba16f, vec4, out_color);

SHADE_ALL(out_depth, STORE(out_normal) STORE(out_material) STORE(out_color) STORE_TRIANGLE) {
    ivec2 first = ivec2(PIXEL_CENTRE) * block.divisor;
    ivec2 end = min(first + block.divisor, textureSize(color_buffer, 0));
    vec3 sum = vec3(0.0);
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x)
            sum += texelFetch(color_buffer, ivec2(x, y), 0).rgb;
    ivec2 size = end - first;
    out_depth = texelFetch(depth_buffer, first, 0).r;
    out_normal = texelFetch(normal_buffer, first, 0);
    out_material = texelFetch(material_buffer, first, 0).rg;
    out_color = vec4(sum / float(size.x * size.y), 1.0);
#ifdef NUMBERED
    out_triangle = imageLoad(triangle_buffer, first).x;
#endif
}
