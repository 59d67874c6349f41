#version 460
#pragma program(Downsample)
#pragma program(DownsampleNumbered, NUMBERED)
// A smaller G-buffer: of each block the texel at its top left stands for depth, normal and material,
// because a mean of two surfaces lies on neither; the colour is the block's mean. NUMBERED also writes which triangle that texel
// shows.

layout(push_constant) uniform DownsampleBlock {
    int divisor; // full pixels a side of a block
} block;

layout(binding = 0) uniform sampler2D depth_buffer;
layout(binding = 1) uniform sampler2D normal_buffer;
layout(binding = 2) uniform sampler2D material_buffer;
layout(binding = 3) uniform sampler2D color_buffer;

#ifdef NUMBERED
layout(binding = 4, r32ui) uniform readonly uimage2D triangle_buffer;
layout(location = 4) out uint out_triangle;
#endif

layout(location = 0) out float out_depth;
layout(location = 1) out vec4 out_normal;
layout(location = 2) out vec2 out_material;
layout(location = 3) out vec4 out_color;

void main() {
    ivec2 first = ivec2(gl_FragCoord.xy) * block.divisor;
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
