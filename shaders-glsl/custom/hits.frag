#version 460
#pragma program(CustomHits)
// Converts the ends of a user's rays to the form of this project's methods: texture coordinates, standard depth and
// PATH_*.

#include "common/constants.glsl"

layout(binding = 0) uniform sampler2D hit_buffer;
layout(binding = 1) uniform sampler2D material_buffer;
layout(binding = 2) uniform sampler2D depth_buffer;     // standard

layout(std140, binding = 3) uniform CustomHitsBlock {
    mat4 view_to_clip;   // from the user's view space to clip space with standard depth
    vec2 resolution;
    int encoding;        // HITS_*
} given;

layout(location = 0) out vec4 hit;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    hit = vec4(-1.0, -1.0, -1.0, PATH_NONE);
    if (texelFetch(material_buffer, pixel, 0).r <= REFLECTS_ABOVE)
        return;
    vec4 value = textureLod(hit_buffer, gl_FragCoord.xy / given.resolution, 0.0);
    vec2 uv = value.xy;
    bool is_hit = all(greaterThanEqual(uv, vec2(0.0)));
    if (given.encoding == HITS_PIXEL) {
        uv = (floor(uv) + 0.5) / given.resolution;
    } else if (given.encoding == HITS_VIEW) {
        vec4 clip = given.view_to_clip * vec4(value.xyz, 1.0);
        is_hit = value.w > 0.0 && clip.w > 0.0;
        uv = clip.xy / clip.w * vec2(0.5, -0.5) + 0.5;
    } else if (given.encoding == HITS_UV_MASKED) {
        is_hit = value.w > 0.0;
    }
    if (given.encoding == HITS_UV_DEPTH)
        is_hit = value.z >= 0.0;
    else
        is_hit = is_hit && all(lessThanEqual(uv, vec2(1.0)));
    ivec2 there = min(ivec2(uv * given.resolution), ivec2(given.resolution) - 1);
    if (is_hit)
        hit = vec4(uv, given.encoding == HITS_UV_DEPTH ? value.z : texelFetch(depth_buffer, there, 0).r, PATH_LINEAR);
    else
        hit.w = PATH_LINEAR_MISS;
}
