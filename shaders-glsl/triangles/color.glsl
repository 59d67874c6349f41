// What a ray sees where it meets a triangle: the lit colour of the surface there, made of the triangle's attributes, the
// images of its material and the scene's lights, as the G-buffer and the lighting pass make it of a pixel, with the images'
// level by the ray's footprint. Needs captures/captures.glsl for the sky.

#ifndef TRIANGLES_COLOR_GLSL
#define TRIANGLES_COLOR_GLSL

#define LIGHT_BINDING 27
#include "common/octahedral.glsl"
#include "captures/captures.glsl"
#include "scene/lit.glsl"
#include "scene/shading_normal.glsl"
#include "triangles/image.glsl"
#include "triangles/walk.glsl"

// The least cosine at which a footprint on a surface is taken to stretch.
const float LEAST_FACING = 0.05;

vec3 Between(vec3 weights, vec3 a, vec3 b, vec3 c) {
    return weights.x * a + weights.y * b + weights.z * c;
}

vec3 UnitVector(uint word) {
    return FromOctahedral(unpackSnorm2x16(word));
}

vec2 PlaceOnMaps(vec3 weights, uvec4 first, uvec4 second) {
    return weights.x * uintBitsToFloat(first.xy) + weights.y * uintBitsToFloat(first.zw)
         + weights.z * uintBitsToFloat(second.xy);
}

vec3 Weights(Met met) {
    return vec3(1.0 - met.weight.x - met.weight.y, met.weight);
}

// Whether a surface whose material decides that at each hit stops the ray: it has no hole there, and is seen from in front
// if it has but one side.
bool StopsRay(TreeRay ray, Met met) {
    uint id = met.id & ~ASKS_MATERIAL;
    uint word = Attribute(id, 0).w;
    uint bits = Material(word, 1).w;
    bool behind = dot(UnitVector(Attribute(id, 3).w), ray.direction) > 0.0;
    int mask = int(Material(word, 2).x);
    vec2 place = PlaceOnMaps(Weights(met), Attribute(id, 1), Attribute(id, 2));
    bool hole = mask >= 0 && ImageAt(max(mask, 0), place, 0.0).x < 0.5;
    return !hole && !(behind && (bits & MATERIAL_SINGLE_SIDED) != 0u);
}

// Half a unit in the last place of 1.
const float ROUNDING = 5.9604645e-8;

// Whether a triangle lies so near to where the ray begins that rounding cannot tell its plane from the ray's own: one beside
// the triangle that the ray begins on, or over it. The distance to a plane along a ray is the mean of three products of four
// roundings each, of lengths up to the scene's extent, so that it errs by up to a dozen half units of that.
bool IsOwnPlane(TreeRay ray, Met met) {
    float facing = dot(UnitVector(Attribute(met.id & ~ASKS_MATERIAL, 3).w), ray.direction);
    return met.t * abs(facing) <= 12.0 * ROUNDING * triangles.extent;
}

// The nearest triangle that stops the ray. One after the other, those that let it through are left behind.
Met Closest(TreeRay ray) {
    Met met;
    bool passes = true;
    while (passes) {
        met = WalkTree(ray);
        bool asks = (met.id & ASKS_MATERIAL) != 0u;
        passes = met.id != NO_TRIANGLE && (IsOwnPlane(ray, met) || (asks && !StopsRay(ray, met)));
        ray.after = met;
    }
    return met;
}

// The colour that a ray sees, over a footprint that measures `width` metres across it where it ends.
vec3 ColorMet(TreeRay ray, Met met, float width) {
    bool is_met = met.id != NO_TRIANGLE;
    uint id = is_met ? met.id & ~ASKS_MATERIAL : 0u;
    uvec4 first = Attribute(id, 0), second = Attribute(id, 1), third = Attribute(id, 2), fourth = Attribute(id, 3);
    uvec4 colors = Material(first.w, 0), maps = Material(first.w, 1);
    vec3 weights = Weights(met);
    vec2 place = PlaceOnMaps(weights, second, third);
    float facing = dot(UnitVector(fourth.w), ray.direction);
    float repeats = width * inversesqrt(max(abs(facing), LEAST_FACING)) * uintBitsToFloat(third.z);
    vec4 albedo = vec4(uintBitsToFloat(colors.xyz), 1.0);
    if (int(maps.x) >= 0)
        albedo *= ImageAt(int(maps.x), place, repeats);
    vec3 normal = normalize(Between(weights, UnitVector(first.x), UnitVector(first.y), UnitVector(first.z)));
    float deviation = uintBitsToFloat(maps.z);
    if (int(maps.y) >= 0 && deviation > 0.0) {
        vec3 along = Between(weights, UnitVector(fourth.x), UnitVector(fourth.y), UnitVector(fourth.z));
        vec4 tangent = vec4(along, (first.w >> 31) != 0u ? -1.0 : 1.0);
        normal = ShadingNormal(normal, tangent, ImageAt(int(maps.y), place, repeats).xyz * 2.0 - 1.0, deviation);
    }
    normal = facing <= 0.0 ? normal : -normal;
    float emission = uintBitsToFloat(colors.w) * albedo.a;
    vec3 lit = LitColor(albedo.rgb, emission, ray.origin + met.t * ray.direction, normal);
    return is_met && (maps.w & MATERIAL_SKY) == 0u ? Sound(lit) : Sky(ray.direction);
}

#endif
