#version 460
#pragma program(Lighting)
// Lit colour = albedo * mix(0.2, 1, min(sum of lights, 1)), without shadows, and as under full light for the share
// of it that is emitted (docs/definitions.md, "Surfaces"); the sky where nothing stands or where a surface shows it.

#include "common/camera.glsl"
#include "common/constants.glsl"

struct LightData {
    vec4 place;      // point: view-space position, 1; directional: view-space direction to the light, 0
    vec4 energy;     // x: energy
};

layout(std140, binding = 1) uniform LightBlock {
    LightData lights[MAX_LIGHTS];
    uint count;
} scene;

layout(binding = 2) uniform sampler2D depth_buffer;    // reversed
layout(binding = 3) uniform sampler2D albedo_buffer;
layout(binding = 4) uniform sampler2D normal_buffer;
layout(binding = 5) uniform samplerCube environment;

layout(constant_id = 0) const bool SKY_APART = false; // the sky is left out: black

layout(location = 0) out vec4 out_color; // in a, 1 for what is lit and 0 where the sky is seen

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(depth_buffer, pixel, 0).r;
    vec4 albedo = texelFetch(albedo_buffer, pixel, 0);
    vec2 ndc = gl_FragCoord.xy / camera.resolution * vec2(2.0, -2.0) + vec2(-1.0, 1.0);

    if (depth <= 0.0 || albedo.a < 0.5) {
        vec4 along = camera.clip_to_view * vec4(ndc, 0.5, 1.0);
        vec3 direction = mat3(camera.view_to_world) * (along.xyz / along.w);
        out_color = vec4(SKY_APART ? vec3(0.0) : textureLod(environment, direction, 0.0).rgb, 0.0);
        return;
    }
    vec4 h = camera.clip_to_view_reversed * vec4(ndc, depth, 1.0);
    vec3 position = h.xyz / h.w;
    vec3 normal = normalize(texelFetch(normal_buffer, pixel, 0).xyz);

    float shading = 0.0;
    for (uint i = 0u; i < scene.count; ++i) {
        LightData light = scene.lights[i];
        float energy = light.energy.x;
        if (light.place.w > 0.5) {
            vec3 to_light = light.place.xyz - position;
            float d = length(to_light);
            float attenuation = 1.0 / (1.0 + d / energy + d * d / energy);
            shading += max(0.0, dot(normal, to_light / max(d, 1e-6))) * attenuation;
        } else {
            shading += max(0.0, dot(normal, light.place.xyz)) * energy;
        }
    }
    float emission = clamp((1.0 - albedo.a) / EMISSION, 0.0, 1.0);
    out_color = vec4(albedo.rgb * mix(mix(0.2, 1.0, min(shading, 1.0)), 1.0, emission), 1.0);
}
