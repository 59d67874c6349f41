#version 460
#pragma program(AreaLight)
#pragma in_either_stage
// The method `area-light`: highlights of lights with an extent, by the roughness of each pixel (thesis 3.1.1). A pixel
// reflects these lights alone, and nothing hides a light.

#include "common/either_stage.glsl"
#include "common/camera.glsl"
#include "common/constants.glsl"
#include "area_light/share.glsl"

struct AreaLightData { // view space, metres
    vec4 a;        // centre, or one end; w: radius, or half of a cuboid's third side
    vec4 b;        // the other end, or half_u
    vec4 c;        // half_v
    vec4 radiance; // linear; w: SHAPE_*
};

layout(std140, binding = 1) uniform AreaLightBlock {
    AreaLightData lights[MAX_AREA_LIGHTS];
    uint count;
} area;

layout(binding = 2) uniform sampler2D depth_buffer;    // reversed
layout(binding = 3) uniform sampler2D normal_buffer;
layout(binding = 4) uniform sampler2D material_buffer; // reflectivity, roughness

OUTPUT(0, rgba16f, vec4, out_reflection);

SHADE(out_reflection) {
    ivec2 pixel = ivec2(PIXEL_CENTRE);
    out_reflection = vec4(0.0);
    float depth = texelFetch(depth_buffer, pixel, 0).r;
    vec2 material = texelFetch(material_buffer, pixel, 0).rg;
    if (depth <= 0.0 || material.r <= REFLECTS_ABOVE)
        return;
    vec2 ndc = PIXEL_CENTRE / camera.resolution * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    vec4 homogeneous = camera.clip_to_view_reversed * vec4(ndc, depth, 1.0);
    vec3 position = homogeneous.xyz / homogeneous.w;
    vec3 normal = normalize(texelFetch(normal_buffer, pixel, 0).xyz);
    vec3 mirrored = reflect(normalize(position), normal);
    float power = BoundedLobePower(material.g);

    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < area.count; ++i) {
        AreaLightData light = area.lights[i];
        vec3 from_point = light.a.xyz - position;
        float share;
        if (light.radiance.w == SHAPE_SPHERE)
            share = SphereShare(mirrored, normal, from_point, light.a.w, power);
        else if (light.radiance.w == SHAPE_CAPSULE || light.radiance.w == SHAPE_CYLINDER)
            share = TubeShare(mirrored, normal, from_point, light.b.xyz - position, light.a.w,
                              light.radiance.w == SHAPE_CYLINDER, power);
        else if (light.radiance.w == SHAPE_CUBOID)
            share = CuboidShare(mirrored, normal, from_point, light.b.xyz, light.c.xyz, light.a.w, power);
        else
            share = RectangleShare(mirrored, normal, from_point, light.b.xyz, light.c.xyz, power);
        sum += share * light.radiance.rgb;
    }
    // Alpha is 1 where a light shows. Smaller sums than LEAST_NORMAL count as 0, since devices may flush denormal
    // numbers to 0 in one shader stage and not in the other.
    out_reflection = vec4(sum, all(lessThan(abs(sum), vec3(LEAST_NORMAL))) ? 0.0 : 1.0);
}
