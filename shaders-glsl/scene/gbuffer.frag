#version 460
#pragma program(GBufferFragment)
#pragma program(GBufferPeeled, PEELED)
#pragma program(GBufferNumbered, NUMBERED)
// Writes albedo, normal and material of the nearest surface. NUMBERED also writes which triangle each pixel shows.
// PEELED draws the nearest surface behind those of another depth buffer, by depth peeling (Everitt 2001).

#include "common/camera.glsl"
#include "common/constants.glsl"
#include "scene/draw.glsl"
#include "scene/shading_normal.glsl"
#include "scene/side.glsl"

layout(binding = 1) uniform sampler2D albedo_map;
layout(binding = 2) uniform sampler2D normal_map;
layout(binding = 3) uniform sampler2D alpha_mask;
layout(binding = 4) uniform sampler2D reflectivity_map;
layout(binding = 7) uniform sampler2D roughness_map;

#ifdef PEELED
layout(binding = 5) uniform sampler2D first_depth; // reversed, of the layer in front
layout(std140, binding = 6) uniform PeelBlock {
    float separation; // metres of view depth by which a surface must lie behind that layer
} peel;
#endif

layout(location = 0) in vec3 in_normal;
layout(location = 1) in vec2 in_uv;
layout(location = 2) in vec4 in_tangent;
layout(location = 3) flat in uint in_last_triangle;  // the number of the mesh's last triangle among the scene's; it is drawn first

layout(location = 0) out vec4 out_albedo;    // a: 0 for a surface that shows the sky; 1 for a lit one, less its emission (EMISSION)
layout(location = 1) out vec4 out_normal;    // view space, unit
layout(location = 2) out vec2 out_material;  // reflectivity, roughness
#ifdef NUMBERED
layout(location = 3) out uint out_triangle;  // the triangle's number in the scene
#endif

// Number of repeats of a map across a pixel above which the pixel shows the mean of the map.
#define MOST_REPEATS 16.0

#ifdef PEELED
// The view-space z, in metres, of a reversed depth.
float ViewDepth(float depth) {
    mat4 m = camera.clip_to_view_reversed;
    return (m[2][2] * depth + m[3][2]) / (m[2][3] * depth + m[3][3]);
}

// Whether this fragment belongs to the layer in front, or lies too close behind it, and so is left out. The layer has a
// depth above 0 wherever anything is drawn.
bool IsPeeled() {
    float first = texelFetch(first_depth, ivec2(gl_FragCoord.xy), 0).r;
    return !(ViewDepth(gl_FragCoord.z) > ViewDepth(first) + peel.separation);
}
#endif

// The difference, as a share of texture coordinates, that neighbouring pixels with equal coordinates get. It is at most
// a 256th of a texel of a map of 4096 texels, the finest step that filters resolve.
#define POINT_WIDTH (1.0 / 1048576.0)

// The texture coordinates at which a pixel samples: those of the surface, but for two cases.
//
// Very close to the eye, or where rounding makes neighbouring coordinates jump, a map repeats thousands of times within
// a pixel. The sampler then uses the last level anyway, but lavapipe's anisotropic filter goes over the repeats one by
// one, for seconds. The pixel's own position as coordinates repeats the map once a pixel, which also selects the last
// level.
//
// On a surface without coordinates, all pixels have equal ones. There the anisotropic filter of lavapipe since Mesa 24
// divides zero by zero and gives 0 (in Vulkan, the ratio of anisotropy is 1). So neighbours get slightly different
// coordinates.
vec2 SamplingUv() {
    vec2 repeats = fwidthCoarse(in_uv);
    if (repeats == vec2(0.0)) {
        return in_uv + POINT_WIDTH * max(abs(in_uv), vec2(1.0)) * vec2(uvec2(gl_FragCoord.xy) & 1u);
    }
    return all(lessThanEqual(repeats, vec2(MOST_REPEATS))) ? in_uv : gl_FragCoord.xy;
}

void main() {
    // Sampled before the discard, so that every quad has its derivatives.
    vec2 uv = SamplingUv();
    vec4 albedo = texture(albedo_map, uv);
    vec3 mapped = texture(normal_map, uv).xyz * 2.0 - 1.0;
    float reflectivity = texture(reflectivity_map, uv).r;
    float mask = texture(alpha_mask, uv).r;
    // Few materials have this map, and the others need not pay for it.
    float roughness = (draw.maps & ROUGHNESS_MAP) != 0u ? texture(roughness_map, uv).g : 1.0;
    if ((draw.maps & ALPHA_MASK) != 0u && mask < 0.5) {
        discard;
    }
    bool is_behind = IsSeenFromBehind();
    if (IsInvisibleBack(is_behind)) {
        discard;
    }
#ifdef PEELED
    if (IsPeeled())
        discard;
#endif
    vec3 geometric = normalize(in_normal);
    vec3 normal = geometric;
    if ((draw.maps & NORMAL_MAP) != 0u && draw.normal_deviation > 0.0) {
        normal = ShadingNormal(geometric, in_tangent, mapped, draw.normal_deviation);
    }
    // A surface that is seen from behind shows its back, whose normal is reversed.
    if (is_behind) {
        normal = -normal;
    }
    out_albedo = vec4(albedo.rgb * draw.albedo.rgb, draw.albedo.a - EMISSION * draw.emission * albedo.a);
    out_normal = vec4(normal, 0.0);
#ifdef NUMBERED
    out_triangle = in_last_triangle - uint(gl_PrimitiveID);
#endif
    out_material = vec2(draw.reflectivity * reflectivity, draw.roughness * roughness);
}
