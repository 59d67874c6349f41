// The lit colour that a ray sees where it meets a triangle. It is made from the triangle's attributes, the images of
// its material and the scene's lights, as the G-buffer and the lighting pass do for a pixel. The ray's footprint
// chooses the level of the images. With SCREEN_COLORS, the colour is that of the screen where the screen shows the hit.
// Needs captures/captures.glsl for the sky.

#ifndef TRIANGLES_COLOR_GLSL
#define TRIANGLES_COLOR_GLSL

#define LIGHT_BINDING 27
#define CONSTANT_LIGHTS
#include "captures/captures.glsl"
#include "scene/lit.glsl"
#include "scene/shading_normal.glsl"
#include "triangles/image.glsl"
#include "triangles/walk.glsl"
#include "triangles/screen_color.glsl"

vec3 InterpolateCorners(vec3 weights, vec3 a, vec3 b, vec3 c) {
    return weights.x * a + weights.y * b + weights.z * c;
}

// Unpacks a unit vector from three signed numbers of ten bits each, x in the lowest bits.
vec3 UnpackUnitVector(uint word) {
    ivec3 parts = ivec3(int(word << 22), int(word << 12), int(word << 2)) >> 22;
    return vec3(parts) * (1.0 / 511.0);
}

vec2 InterpolateUv(vec3 weights, uvec4 first, uvec4 second) {
    return weights.x * uintBitsToFloat(first.xy) + weights.y * uintBitsToFloat(first.zw)
         + weights.z * uintBitsToFloat(second.xy);
}

vec3 BarycentricWeights(TriangleHit hit) {
    return vec3(1.0 - hit.weight.x - hit.weight.y, hit.weight);
}

// Whether a surface whose material decides at each hit (ASKS_MATERIAL) stops the ray: it must have no hole there, and
// if it is single-sided, the ray must come from in front.
bool StopsRay(TriangleHit hit) {
    uint id = hit.id & ~ASKS_MATERIAL;
    uint material_word = Attribute(id, 0).w;
    uvec4 mask = Material(material_word, 2);
    vec2 uv = InterpolateUv(BarycentricWeights(hit), Attribute(id, 1), Attribute(id, 2));
    bool is_hole = SampleImage(mask.zw, mask.x >> MASK_SHIFT, uv, 0.0).x < 0.5;
    return !is_hole && !(hit.side < 0.0 && (mask.x & MATERIAL_SINGLE_SIDED) != 0u);
}

#ifdef RAY_QUERY
#include "triangles/query.glsl"
#elif !defined(CONFIRMED)

// The hit on the nearest triangle that stops the ray. After each triangle that lets the ray through, the walk is
// repeated for the hits after that one.
TriangleHit ClosestHit(TreeRay ray) {
    if (!ASKS)
        return TraverseTree(ray);
    TriangleHit hit;
    bool passes;
    do {
        hit = TraverseTree(ray);
        passes = hit.id != NO_TRIANGLE && (hit.id & ASKS_MATERIAL) != 0u && !StopsRay(hit);
        ray.after = hit;
    } while (passes);
    return hit;
}

#endif

// The colour that a ray sees at a hit, or that of the sky without a hit, over a footprint that measures `width` metres
// across the ray at its end. The normal is made before the albedo, and the tangents are read only where a map needs
// them, so that few attributes are held at a time.
vec3 HitColor(TreeRay ray, TriangleHit hit, float width) {
    bool is_hit = hit.id != NO_TRIANGLE;
    uint triangle = is_hit ? hit.id & ~ASKS_MATERIAL : 0u;
    uvec4 normals = Attribute(triangle, 0), uvs = Attribute(triangle, 1), more_uvs = Attribute(triangle, 2);
    uint material_word = normals.w;
    uvec4 colors = Material(material_word, 0), maps = Material(material_word, 1), details = Material(material_word, 2);
    vec3 weights = BarycentricWeights(hit);
    vec2 uv = InterpolateUv(weights, uvs, more_uvs);
    float repeats_per_m = uintBitsToFloat(more_uvs.z);
    // A footprint is longer on a surface that the ray meets at a slant.
    float repeats = width * repeats_per_m * inversesqrt(max(abs(hit.side), LEAST_FACING));
    vec3 normal = normalize(InterpolateCorners(weights, UnpackUnitVector(normals.x), UnpackUnitVector(normals.y),
                                               UnpackUnitVector(normals.z)));
    float normal_deviation = uintBitsToFloat(details.y);
    if (normal_deviation > 0.0) {
        uvec4 tangents = Attribute(triangle, 3);
        vec3 tangent_direction = InterpolateCorners(weights, UnpackUnitVector(tangents.x), UnpackUnitVector(tangents.y),
                                                    UnpackUnitVector(tangents.z));
        vec4 tangent = vec4(tangent_direction, (material_word >> 31) != 0u ? -1.0 : 1.0);
        vec3 mapped = SampleImage(maps.zw, details.x >> NORMAL_SHIFT, uv, repeats).xyz * 2.0 - 1.0;
        normal = ShadingNormal(normal, tangent, mapped, normal_deviation);
    }
    normal = hit.side >= 0.0 ? normal : -normal;
    vec4 albedo = vec4(uintBitsToFloat(colors.xyz), 1.0) * SampleImage(maps.xy, details.x >> ALBEDO_SHIFT, uv, repeats);
    float emission = uintBitsToFloat(colors.w) * albedo.a;
    vec3 lit = LitColor(albedo.rgb, emission, ray.origin + hit.t * ray.direction, normal);
    bool is_surface = is_hit && (details.x & MATERIAL_SKY) == 0u;
    vec3 screen_lit;
    if (SCREEN_COLORS && is_surface && SampleScreenColor(ray, hit, width, screen_lit))
        lit = screen_lit;
    // Sound makes a colour fit to be summed and stored: without NaN, infinity and negative values.
    return is_surface ? Sound(lit) : SampleSkyWorld(ray.direction);
}

#endif
