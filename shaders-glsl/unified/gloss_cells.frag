#version 460
// The reflection of each cell with a wide lobe, from the thirteen rays of the diamond around it.

#include "unified/parameters.glsl"
#include "unified/ray.glsl"
#include "unified/gloss.glsl"

layout(binding = 1) uniform sampler2D depth_buffer;    // reversed
layout(binding = 2) uniform sampler2D normal_buffer;   // view space
layout(binding = 3) uniform sampler2D material_buffer; // reflectivity, roughness
layout(binding = 4, rgba32f) uniform readonly image2D place_image;
layout(binding = 5, rgba16f) uniform readonly image2D seen_image;

layout(location = 0) out vec4 out_reflection;
layout(location = 1) out vec4 out_surface; // normal, and 1 / ViewPoint.z; 0: none

#include "unified/gloss_cell.glsl"
#include "unified/gloss_gather.glsl"

void main() {
    ivec2 cell = ivec2(gl_FragCoord.xy), last = (unified.size - 1) >> 1;
    out_reflection = vec4(0.0);
    out_surface = vec4(0.0);
    float roughness;
    ivec2 pixel = WidePixel(cell, roughness);
    if (roughness > 0.0) {
        float depth = texelFetch(depth_buffer, pixel, 0).r;
        vec3 normal = texelFetch(normal_buffer, pixel, 0).xyz;
        Lobe lobe = LobeOf(pixel, depth, normal, roughness);
        Sum sum = Sum(vec4(0.0), 0.0, 0.0);
        for (int y = -2; y <= 2; ++y) {
            int reach = 2 - abs(y);
            for (int x = -reach; x <= reach; ++x) {
                ivec2 at = clamp(cell + ivec2(x, y), ivec2(0), last);
                Gather(sum, lobe, imageLoad(place_image, at), imageLoad(seen_image, at));
            }
        }
        out_reflection = Reflection(sum);
        out_surface = vec4(normal, depth + unified.depth_offset);
    }
}
