#version 460
#pragma program(KeepNormal)
// Copies the normals of a face into its layer of the image with the normals of all captures. A blit would also convert
// the format, but not every driver can blit into images of 8-bit signed numbers.

layout(local_size_x = 8, local_size_y = 8) in;

layout(push_constant) uniform KeepNormalBlock {
    uint layer; // 6 k + f for face f of capture k
} keep;

layout(binding = 0) uniform sampler2D normal_buffer; // view space of the face
layout(binding = 1, rgba8_snorm) uniform writeonly image2DArray normal_image;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(normal_image).xy)))
        return;
    imageStore(normal_image, ivec3(pixel, int(keep.layer)), texelFetch(normal_buffer, pixel, 0));
}
