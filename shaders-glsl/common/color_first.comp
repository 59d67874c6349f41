#version 460
#pragma program(ColorFirst)
// Level 1 of the colour's chain where the sky is seen apart: a linear blit of level 0 in which sky is black. A texel then holds
// the colour of what is no sky, by the share of it in a, and whoever sees the rest elsewhere adds the sky of that direction.

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, rgba16f) uniform readonly image2D finest; // a is 0 where sky is, else 1
layout(binding = 1, rgba16f) uniform writeonly image2D coarser;

vec4 Lit(ivec2 pixel) {
    vec4 color = imageLoad(finest, pixel);
    return color.a == 0.0 ? vec4(0.0) : color;
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(coarser), last = imageSize(finest) - 1;
    if (any(greaterThanEqual(texel, size)))
        return;
    vec2 place = max((vec2(texel) + 0.5) * (vec2(last + 1) / vec2(size)) - 0.5, 0.0);
    ivec2 low = ivec2(place), high = min(low + 1, last);
    vec2 part = place - vec2(low);
    vec4 upper = mix(Lit(low), Lit(ivec2(high.x, low.y)), part.x);
    vec4 lower = mix(Lit(ivec2(low.x, high.y)), Lit(high), part.x);
    imageStore(coarser, texel, mix(upper, lower, part.y));
}
