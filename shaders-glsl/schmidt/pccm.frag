#version 460
#pragma program(Pccm)
#pragma in_either_stage
// The method `pccm`: parallax-corrected cube mapping (Schmidt 2013, section 5.2, listing 1), which blends between two
// maps as its section 6 suggests. The method `local-map` is `pccm` without the correction (thesis 3.1.3).

#include "common/either_stage.glsl"
#include "common/camera.glsl"
#include "common/reflecting_pixel.glsl"
#include "common/cube_map.glsl"

struct LocalCubeMap {
    vec4 position; // where the map was captured, world; w unused
    vec4 box_min;  // proxy box, world; w unused
    vec4 box_max;
};

layout(std140, binding = 4) uniform PccmBlock {
    LocalCubeMap maps[2]; // the two nearest; twice the same where there is one
} pccm;

layout(binding = 5) uniform samplerCube first_map;
layout(binding = 6) uniform samplerCube second_map;

layout(constant_id = 0) const bool CORRECTED = true; // else the map is looked up by the direction alone

OUTPUT(0, rgba16f, vec4, out_reflection); // colour, and 1 in a: nothing fades

struct Box {
    vec3 min;
    vec3 max;
};

// Print: listing 1.
// 1-3: Parallax corrected cube mapping
// Departure: box and position of the map are arguments, as there are two maps.
vec3 ParallaxCorrecteCubeMapping(in vec3 wsPosition, in vec3 wsReflectionVector, Box AABB, vec3 wsCubeMapPosition) {
    // 4, 5: Intersect with first AABB plane
    vec3 firstPlaneIntersection = (AABB.max - wsPosition) / wsReflectionVector;
    // 6, 7: Intersect with second AABB plane
    vec3 secondPlaneIntersection = (AABB.min - wsPosition) / wsReflectionVector;

    // 9-11: the furthest plane of each axis, and of these the nearest
    // Erratum, kept: a position outside the box gets a distance that means nothing.
    vec3 furthesPlane = max(firstPlaneIntersection, secondPlaneIntersection);
    float distance = min(min(furthesPlane.x, furthesPlane.y), furthesPlane.z);

    // 13: wsIntersection
    vec3 wsIntersection = wsPosition + distance * wsReflectionVector;

    // 15-23: Calculate parallax-corrected reflection vector; sample cube map texture with it
    // Departure: line 20 samples the map; here the caller does, with the roughness.
    return wsIntersection - wsCubeMapPosition;
}

// Whether a position lies inside a map's box. Surfaces often lie on the sides of their box, so that positions up to
// 0.05 m outside of it count as inside.
bool IsInside(vec3 position, Box box) {
    return all(greaterThanEqual(position, box.min - 0.05)) && all(lessThanEqual(position, box.max + 0.05));
}

SHADE(out_reflection) {
    ReflectingPixel pixel = FetchReflectingPixel(PIXEL_CENTRE);
    out_reflection = vec4(0.0);
    if (!pixel.reflects) {
        return;
    }
    vec3 looked_up[2];
    vec2 distances;
    bvec2 inside;
    for (int k = 0; k < 2; ++k) {
        LocalCubeMap map = pccm.maps[k];
        Box box = Box(map.box_min.xyz, map.box_max.xyz);
        looked_up[k] = CORRECTED
            ? ParallaxCorrecteCubeMapping(pixel.position, pixel.reflection, box, map.position.xyz)
            : pixel.reflection;
        distances[k] = distance(pixel.position, map.position.xyz);
        inside[k] = IsInside(pixel.position, box);
    }
    // If the position lies in one box only, that map counts alone. Otherwise each map counts by the inverse square of the
    // distance to where it was captured.
    float second = distances[0] * distances[0] / max(dot(distances, distances), 1e-12);
    if (inside[0] != inside[1]) {
        second = inside[1] ? 1.0 : 0.0;
    }
    vec3 color = vec3(0.0);
    if (second < 1.0) {
        color += (1.0 - second) * SampleCube(first_map, looked_up[0], pixel.roughness).rgb;
    }
    if (second > 0.0) {
        color += second * SampleCube(second_map, looked_up[1], pixel.roughness).rgb;
    }
    out_reflection = vec4(color, 1.0);
}
