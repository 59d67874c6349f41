#version 460
#pragma program(BeginInCaptures)
// The method `captures`: puts the mirror ray of each reflecting pixel on the list of lost rays, to be followed in the
// captures from its beginning. As a fallback, it does so only for pixels where the reflection in front is not opaque.

layout(local_size_x = 8, local_size_y = 8) in;

#include "captures/push.glsl"

layout(constant_id = 0) const bool BEHIND = false; // another reflection is shown in front of this one

layout(binding = 1) uniform sampler2D depth_buffer;      // reversed; 0 is sky
layout(binding = 2) uniform sampler2D normal_buffer;     // view space
layout(binding = 3) uniform sampler2D material_buffer;   // reflectivity, roughness
layout(binding = 4) uniform sampler2D reflection_buffer; // the reflection in front; without BEHIND, any image

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, unified.size)))
        return;
    float depth = texelFetch(depth_buffer, pixel, 0).r;
    vec3 normal = texelFetch(normal_buffer, pixel, 0).xyz;
    vec2 material = texelFetch(material_buffer, pixel, 0).xy;
    if (!Reflects(material) || !(depth > 0.0) || !(dot(normal, normal) > NO_NORMAL))
        return;
    if (BEHIND && texelFetch(reflection_buffer, pixel, 0).a >= 1.0)
        return;
    vec3 point = ViewPoint(vec2(pixel) + 0.5, depth) * captures.view_unit;
    vec3 sight = ViewDirection(point);
    float along_normal = dot(sight, normal);
    // A pixel that is seen from below its surface reflects nothing.
    if (along_normal >= 0.0)
        return;
    vec3 direction = sight - (2.0 * along_normal / dot(normal, normal)) * normal;
    // A mirror's ray has the footprint of its pixel, which widens from the eye on; a lobe's ray has the cone of the
    // thesis (4.2.4).
    float mirror_widened_m = ORTHOGRAPHIC ? FAR_EYE : length(point);
    bool is_mirror = material.y <= 0.0;
    PushLostRay(uvec2(pixel), point, direction, is_mirror ? mirror_widened_m : 0.0,
                is_mirror ? PixelSpread() : 2.0 * tan(0.5 * material.y), NO_TRIANGLE);
}
