#version 460
#pragma program(Import)
// Converts the G-buffer of another renderer, whatever its conventions, to the G-buffer that every method reads
// (passes::GBuffer).

#include "common/camera.glsl"
#include "common/constants.glsl"
#include "common/octahedral.glsl"
#include "common/sound.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// NORMAL_*. This is a specialization constant, since lavapipe compiles a shader anew in every frame if its branches
// depend on numbers of a uniform block. For the same reason no branch below depends on such a number alone.
layout(constant_id = 0) const int NORMAL_KIND = NORMAL_FLOAT;

// Filled in by src/passes/import.rs.
layout(std140, binding = 10) uniform ImportBlock {
    mat4 normal_to_view;    // turns a decoded normal into our view space; a rotation, with or without a reflection
    vec2 depth_to_reversed; // reversed depth is x * depth + y
    vec2 constants;         // reflectivity and roughness where no image has them
    ivec2 channels;         // channels of the images that have reflectivity and roughness; -1 for the constants
    int leaves_sky_out;     // 1: where nothing stands the colour is black
} import_block;

layout(binding = 1) uniform sampler2D depth_source;
layout(binding = 2) uniform sampler2D normal_source;
layout(binding = 3) uniform sampler2D reflectivity_source;
layout(binding = 4) uniform sampler2D roughness_source;
layout(binding = 5) uniform sampler2D color_source;

layout(binding = 6, r32f) uniform writeonly image2D depth_image;
layout(binding = 7, rgba16f) uniform writeonly image2D normal_image;
layout(binding = 8, rg16f) uniform writeonly image2D material_image;
layout(binding = 9, rgba16f) uniform writeonly image2D color_image;

// Reversed depth: 0 where nothing stands. NaN counts as nothing.
float Depth(ivec2 pixel) {
    precise float depth = import_block.depth_to_reversed.x * texelFetch(depth_source, pixel, 0).r
                        + import_block.depth_to_reversed.y;
    return depth > 0.0 ? min(depth, 1.0) : 0.0;
}

#include "common/normal_of_depth.glsl"

// The normal of a pixel in our view space: decoded from the other renderer's image, or made from depth.
vec3 Normal(ivec2 pixel, float depth) {
    vec3 stored = texelFetch(normal_source, pixel, 0).xyz;
    if (NORMAL_KIND == NORMAL_OF_DEPTH)
        return NormalOfDepth(pixel, depth);
    vec3 normal = stored;
    if (NORMAL_KIND == NORMAL_UNORM) {
        normal = stored * 2.0 - 1.0;
        float squared = dot(normal, normal);
        normal = squared > NO_NORMAL ? normal * inversesqrt(squared) : vec3(0.0);
    } else if (NORMAL_KIND == NORMAL_OCTAHEDRAL) {
        normal = DecodeOctahedral(stored.xy);
    } else if (NORMAL_KIND == NORMAL_OCTAHEDRAL_UNORM) {
        normal = DecodeOctahedral(stored.xy * 2.0 - 1.0);
    }
    return mat3(import_block.normal_to_view) * normal;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(camera.resolution))))
        return;
    float depth = Depth(pixel);
    ivec2 channels = import_block.channels;
    vec2 stored = vec2(texelFetch(reflectivity_source, pixel, 0)[max(channels.x, 0)],
                       texelFetch(roughness_source, pixel, 0)[max(channels.y, 0)]);
    vec2 material = mix(stored, import_block.constants, lessThan(channels, ivec2(0)));
    // Images of 32-bit floats may hold numbers that do not fit into 16 bits, and any image of floats may hold NaN,
    // which a blurred chain would spread over the image.
    vec3 color = Finite(texelFetch(color_source, pixel, 0).rgb);
    bool is_sky = depth == 0.0;
    imageStore(depth_image, pixel, vec4(depth));
    imageStore(normal_image, pixel, vec4(is_sky ? vec3(0.0) : Normal(pixel, depth), 0.0));
    imageStore(material_image, pixel, vec4(is_sky ? vec2(0.0) : material, 0.0, 0.0));
    imageStore(color_image, pixel, vec4(is_sky && import_block.leaves_sky_out != 0 ? vec3(0.0) : color, is_sky ? 0.0 : 1.0));
}
