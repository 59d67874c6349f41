#version 460
#pragma program(Import)
// Takes over the G-buffer of another renderer: whatever its conventions, what is written is what every method reads
// (passes::GBuffer).

#include "common/constants.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// Filled in by src/passes/import.rs.
layout(std140, binding = 0) uniform ImportBlock {
    mat4 normal_to_view;    // turns a decoded normal into our view space; a rotation, with or without a reflection
    vec4 view_ray;          // xy: half the view's width and height at z = 1, over pixels; zw: the shift, in half pixels
    vec2 depth_to_reversed; // reversed depth is x * depth + y
    vec2 reversed_to_z;     // view z is y / (reversed depth + x)
    vec2 constants;         // reflectivity and roughness where no image has them
    ivec2 channels;         // the channels that have them; -1 for the constants
    ivec2 size;             // pixels
    int normal_kind;        // NORMAL_*
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

// Reversed depth: 0 where nothing stands. What is no number is taken for nothing.
float Depth(ivec2 pixel) {
    precise float depth = import_block.depth_to_reversed.x * texelFetch(depth_source, pixel, 0).r
                        + import_block.depth_to_reversed.y;
    return depth > 0.0 ? min(depth, 1.0) : 0.0;
}

vec3 ViewPoint(ivec2 pixel, float depth) {
    vec2 centre = vec2(2 * pixel.x + 1 - import_block.size.x, import_block.size.y - 2 * pixel.y - 1);
    vec2 ray = (centre - import_block.view_ray.zw) * import_block.view_ray.xy;
    return vec3(ray, 1.0) * (import_block.reversed_to_z.y / (depth + import_block.reversed_to_z.x));
}

// The step along an axis to the neighbour that is more likely on the same surface: of the two, the one nearer in depth.
vec3 StepAlong(ivec2 axis, ivec2 pixel, float depth, vec3 point) {
    ivec2 last = import_block.size - 1;
    ivec2 after = min(pixel + axis, last), before = max(pixel - axis, ivec2(0));
    float depth_after = Depth(after), depth_before = Depth(before);
    float gap_after = after == pixel || depth_after == 0.0 ? NEVER : abs(depth_after - depth);
    float gap_before = before == pixel || depth_before == 0.0 ? NEVER : abs(depth_before - depth);
    return gap_after <= gap_before ? ViewPoint(after, depth_after) - point : point - ViewPoint(before, depth_before);
}

// The normal of the surface through a pixel and its neighbours, for images without normals.
vec3 NormalOfDepth(ivec2 pixel, float depth) {
    vec3 point = ViewPoint(pixel, depth);
    vec3 across = cross(StepAlong(ivec2(1, 0), pixel, depth, point), StepAlong(ivec2(0, 1), pixel, depth, point));
    float squared = dot(across, across);
    vec3 normal = squared > 0.0 ? across * inversesqrt(squared) : -normalize(point);
    return dot(normal, point) > 0.0 ? -normal : normal;
}

vec3 Octahedral(vec2 e) {
    vec3 v = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    vec2 folded = (1.0 - abs(v.yx)) * vec2(v.x >= 0.0 ? 1.0 : -1.0, v.y >= 0.0 ? 1.0 : -1.0);
    return normalize(v.z >= 0.0 ? v : vec3(folded, v.z));
}

vec3 Normal(ivec2 pixel, float depth) {
    vec3 stored = texelFetch(normal_source, pixel, 0).xyz;
    if (import_block.normal_kind == NORMAL_OF_DEPTH)
        return NormalOfDepth(pixel, depth);
    vec3 normal = stored;
    if (import_block.normal_kind == NORMAL_UNORM) {
        normal = stored * 2.0 - 1.0;
        float squared = dot(normal, normal);
        normal = squared > NO_NORMAL ? normal * inversesqrt(squared) : vec3(0.0);
    } else if (import_block.normal_kind == NORMAL_OCTAHEDRAL) {
        normal = Octahedral(stored.xy);
    } else if (import_block.normal_kind == NORMAL_OCTAHEDRAL_UNORM) {
        normal = Octahedral(stored.xy * 2.0 - 1.0);
    }
    return mat3(import_block.normal_to_view) * normal;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, import_block.size)))
        return;
    float depth = Depth(pixel);
    ivec2 channels = import_block.channels;
    float reflectivity = channels.x < 0 ? import_block.constants.x : texelFetch(reflectivity_source, pixel, 0)[channels.x];
    float roughness = channels.y < 0 ? import_block.constants.y : texelFetch(roughness_source, pixel, 0)[channels.y];
    vec3 color = texelFetch(color_source, pixel, 0).rgb;
    bool is_sky = depth == 0.0;
    imageStore(depth_image, pixel, vec4(depth));
    imageStore(normal_image, pixel, vec4(is_sky ? vec3(0.0) : Normal(pixel, depth), 0.0));
    imageStore(material_image, pixel, vec4(is_sky ? vec2(0.0) : vec2(reflectivity, roughness), 0.0, 0.0));
    imageStore(color_image, pixel, vec4(is_sky && import_block.leaves_sky_out != 0 ? vec3(0.0) : color, is_sky ? 0.0 : 1.0));
}
