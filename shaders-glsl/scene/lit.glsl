// The lit colour of a surface: albedo * mix(0.2, 1, min(sum of lights, 1)), without shadows. The emitted share of the
// albedo counts as fully lit (docs/definitions.md, "Surfaces"). The lighting pass and the colours of hits on triangles
// share this file.

#ifndef SCENE_LIT_GLSL
#define SCENE_LIT_GLSL

#include "common/constants.glsl"

#ifndef LIGHT_BINDING
#define LIGHT_BINDING 1
#endif

struct LightData {
    vec4 place;      // point: position, 1; directional: direction to the light, 0
    vec4 energy;     // x: energy
};

// Positions and directions are in the space in which surfaces are lit: view space, or the tree's space.
layout(std140, binding = LIGHT_BINDING) uniform LightBlock {
    LightData lights[MAX_LIGHTS];
    uint count;
} scene;

#ifdef CONSTANT_LIGHTS
layout(constant_id = 22) const uint LIGHTS = 16u; // at least the number of lights; lights beyond it have no energy
#else
#define LIGHTS scene.count
#endif

// The lit colour at a position and a unit normal. `albedo` is linear, and `emission` is its emitted share, 0 to 1.
vec3 LitColor(vec3 albedo, float emission, vec3 position, vec3 normal) {
    float shading = 0.0;
    for (uint i = 0u; i < LIGHTS; ++i) {
        LightData light = scene.lights[i];
        float energy = light.energy.x;
        // A directional light's place is the direction to it. Both kinds share one formula, since a device may execute
        // both sides of a branch.
        vec3 to_light = light.place.xyz - position * light.place.w;
        float squared = dot(to_light, to_light);
        float inverse = inversesqrt(max(squared, 1e-12));
        // 1 / (1 + d / energy + d d / energy)
        float attenuation = energy / (energy + squared * inverse + squared);
        shading += max(dot(normal, to_light) * inverse, 0.0) * (light.place.w > 0.5 ? attenuation : energy);
    }
    return albedo * mix(mix(0.2, 1.0, min(shading, 1.0)), 1.0, emission);
}

#endif
