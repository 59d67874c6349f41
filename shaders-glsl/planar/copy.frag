#version 460
#pragma program(PlanarCopy)
// What the mirrored scene left inside the stencil pattern (thesis 3.1.2, first method, step 4): outside it
// nothing was drawn.

layout(binding = 0) uniform sampler2D mirrored_depth; // reversed
layout(binding = 1) uniform sampler2D mirrored_color;

layout(location = 0) out vec4 out_reflection;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (texelFetch(mirrored_depth, pixel, 0).r <= 0.0)
        discard;
    out_reflection = vec4(texelFetch(mirrored_color, pixel, 0).rgb, 1.0);
}
