#version 460
#pragma program(Keep)
// Copies a mip level of an image to 32-bit floats, scaled to the size of the target, for `look.frag`, since methods
// overwrite their images in the next frame.

layout(binding = 0) uniform sampler2D source; // a view of one level

layout(push_constant) uniform KeepBlock {
    vec2 scale; // texels of the source to a pixel of the target
} keep;

layout(location = 0) out vec4 out_texel;

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy * keep.scale);
    out_texel = texelFetch(source, min(texel, textureSize(source, 0) - 1), 0);
}
