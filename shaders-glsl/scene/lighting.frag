#version 460
#pragma program(Lighting)
#pragma in_either_stage
// Writes the lit colour of surfaces (lit.glsl), and the sky where nothing stands or a surface shows the sky.

#include "common/either_stage.glsl"
#include "common/camera.glsl"
#include "common/constants.glsl"
#include "common/sight.glsl"
#include "scene/lit.glsl"

layout(binding = 2) uniform sampler2D depth_buffer;    // reversed
layout(binding = 3) uniform sampler2D albedo_buffer;
layout(binding = 4) uniform sampler2D normal_buffer;
layout(binding = 5) uniform samplerCube environment;

layout(constant_id = 0) const bool SKY_APART = false; // the sky is left out: black

OUTPUT(0, rgba16f, vec4, out_color); // in a, 1 for what is lit and 0 where the sky is seen

SHADE(out_color) {
    ivec2 pixel = ivec2(PIXEL_CENTRE);
    float depth = texelFetch(depth_buffer, pixel, 0).r;
    vec4 albedo = texelFetch(albedo_buffer, pixel, 0);
    vec2 ndc = PIXEL_CENTRE / camera.resolution * vec2(2.0, -2.0) + vec2(-1.0, 1.0);

    if (depth <= 0.0 || albedo.a < 0.5) {
        vec4 far_point = camera.clip_to_view * vec4(ndc, 0.5, 1.0);
        vec3 direction = mat3(camera.view_to_world) * ViewDirection(far_point.xyz / far_point.w);
        out_color = vec4(SKY_APART ? vec3(0.0) : textureLod(environment, direction, 0.0).rgb, 0.0);
        return;
    }
    vec4 homogeneous = camera.clip_to_view_reversed * vec4(ndc, depth, 1.0);
    vec3 position = homogeneous.xyz / homogeneous.w;
    vec3 normal = normalize(texelFetch(normal_buffer, pixel, 0).xyz);

    float emission = clamp((1.0 - albedo.a) / EMISSION, 0.0, 1.0);
    out_color = vec4(LitColor(albedo.rgb, emission, position, normal), 1.0);
}
