// The G-buffer's normals, in view space: a storage image of the G-buffer's own format, which costs a walk less
// than a texture, or, for studies, a texture of any format.

#ifdef ANY_NORMALS
layout(binding = 2) uniform sampler2D normal_buffer;

vec3 Normal(ivec2 pixel) {
    return texelFetch(normal_buffer, pixel, 0).xyz;
}
#else
layout(binding = 2, rgba16f) uniform readonly image2D normal_buffer;

vec3 Normal(ivec2 pixel) {
    return imageLoad(normal_buffer, pixel).xyz;
}
#endif
