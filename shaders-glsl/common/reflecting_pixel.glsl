// A reflecting pixel in world axes, for methods that look up its reflection by position and direction. Needs
// camera.glsl.

#include "common/constants.glsl"
#include "common/sight.glsl"

layout(binding = 1) uniform sampler2D depth_buffer;    // reversed
layout(binding = 2) uniform sampler2D normal_buffer;   // view space
layout(binding = 3) uniform sampler2D material_buffer; // reflectivity, roughness

struct ReflectingPixel {
    bool reflects;    // if false, the other fields are not set
    vec3 position;    // world, metres
    vec3 reflection;  // world, unit
    float roughness;
};

// Fetches the pixel whose centre is at `frag_coord`, in continuous pixel coordinates.
ReflectingPixel FetchReflectingPixel(vec2 frag_coord) {
    ivec2 pixel = ivec2(frag_coord);
    float depth = texelFetch(depth_buffer, pixel, 0).r;
    vec2 material = texelFetch(material_buffer, pixel, 0).rg;
    ReflectingPixel found;
    found.reflects = depth > 0.0 && material.r > REFLECTS_ABOVE;
    if (!found.reflects) {
        return found;
    }
    vec2 ndc = frag_coord / camera.resolution * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    vec4 h = camera.clip_to_view_reversed * vec4(ndc, depth, 1.0);
    vec3 position = h.xyz / h.w;
    vec3 normal = normalize(texelFetch(normal_buffer, pixel, 0).xyz);
    found.position = (camera.view_to_world * vec4(position, 1.0)).xyz;
    found.reflection = normalize(mat3(camera.view_to_world) * reflect(normalize(ViewDirection(position)), normal));
    found.roughness = material.g;
    return found;
}
