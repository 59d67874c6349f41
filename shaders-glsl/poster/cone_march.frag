#version 460
#pragma program(ConeMarchMip)
#pragma program(ConeMarchVolume, VOLUME)
#pragma in_either_stage
// The poster's cone march (Hermanns and Franke 2014, "Technical Approach"): from a pixel's position along the reflected
// view direction through the pre-filtered G-buffer, whose filter level follows the cone. VOLUME reads the volumes
// instead of the mip chains. With LAYERS there is a second layer of depth behind the first (the poster's conclusion),
// and each layer has a thickness, so that rays can pass behind the first one.

#include "common/either_stage.glsl"
#include "common/camera.glsl"
#include "common/constants.glsl"
#include "thesis/cone_angle.glsl"
#include "thesis/border_fade.glsl"

#ifdef VOLUME
#define FILTERED sampler3D
#else
#define FILTERED sampler2D
#endif

layout(binding = 1) uniform sampler2D normal_buffer;     // view space
layout(binding = 2) uniform sampler2D material_buffer;   // reflectivity, roughness
layout(binding = 3) uniform FILTERED filtered_depth;     // view-space z, metres
layout(binding = 4) uniform FILTERED filtered_normal;    // view space, shorter where normals differ
layout(binding = 5) uniform FILTERED filtered_color;     // lit colour
layout(binding = 6) uniform FILTERED behind_depth;       // the same three of the second layer, which are read with
layout(binding = 7) uniform FILTERED behind_normal;      // LAYERS alone
layout(binding = 8) uniform FILTERED behind_color;

layout(push_constant) uniform PosterBlock {
    float first_step;       // as a part of the screen's height at the pixel's depth
    float epsilon;          // of a hit-point, as a part of its depth
    int edge_retries;       // how often a step that leaves the screen is halved
    float fade_start;
    float fade_end;
    int fade;               // 0: no fade
    float thickness;        // of a layer, in metres of view depth; with LAYERS alone
} poster;

// Numbers of the print, which `published` leaves as they are.
layout(constant_id = 20) const float STEP_INCREASE = 1.5;
layout(constant_id = 21) const int STEP_COUNT = 100;
layout(constant_id = 22) const int SEARCH_COUNT = 30;
layout(constant_id = 23) const float SEARCH_DECREASE = 0.5;

layout(constant_id = 0) const bool HITS = false;   // whether out_hit is wanted
layout(constant_id = 1) const bool LAYERS = false; // whether there is a second layer

OUTPUT(0, rgba16f, vec4, out_reflection); // colour, and fade in alpha
OUTPUT(1, rgba32f, vec4, out_hit);        // texture coordinates, standard depth, PATH_*

// Samples a filtered image at a level, which is a mip level, or with VOLUME a slice.
vec4 Filtered(FILTERED tex, vec2 texCoord, float level) {
#ifdef VOLUME
    return textureLod(tex, vec3(texCoord, (level + 0.5) / float(textureSize(tex, 0).z)), 0.0);
#else
    return textureLod(tex, texCoord, level);
#endif
}

// Texture coordinates and standard depth of a point in view space.
vec3 Project(vec3 position) {
    vec4 clip = camera.view_to_clip * vec4(position, 1.0);
    return vec3(clip.xy / clip.w * vec2(0.5, -0.5) + vec2(0.5), clip.z / clip.w);
}

bool LeftScreen(vec2 texCoord) {
    return any(lessThan(texCoord, vec2(0.0))) || any(greaterThan(texCoord, vec2(1.0)));
}

// The greatest length of a path that is seen to cross a texel, in widths of the texel.
const float MOST_SHORTENED = 8.0;

// Metres that the screen's height spans at a depth.
float ScreenHeight(float z) {
    return 2.0 * z / camera.view_to_clip[1][1];
}

// Print: Technical Approach.
// 8: "for each texture access to the depth buffer, we first compute the current path length and solid angle of the cone to
// compute the MIP-level"
// Departure: the level at which one texel (figure 1: a quad) is as large as the cone's cross-section. That is the side of the
// square that the solid angle cuts out at the path's length, in pixels at that depth.
float Level(float solidAngle, float pathLength, float z) {
    float side = sqrt(solidAngle) * pathLength * camera.resolution.y / ScreenHeight(z);
    return log2(max(side, 1.0));
}

struct Cone {
    vec3 origin;      // P
    vec3 direction;   // V_R, unit
    float solidAngle; // steradians
};

// The point at a length of path along the axis of a cone, in view space.
vec3 At(Cone cone, float pathLength) {
    return cone.origin + cone.direction * pathLength;
}

// How far a cone's position lies before the average depth of a layer's geometry that it covers.
float DepthDelta(Cone cone, float pathLength, int layer) {
    vec3 Q = At(cone, pathLength);
    vec2 texCoord = Project(Q).xy;
    float level = Level(cone.solidAngle, pathLength, Q.z);
    if (LAYERS && layer == 1)
        return Filtered(behind_depth, texCoord, level).r - Q.z;
    return Filtered(filtered_depth, texCoord, level).r - Q.z;
}

// 5: "and further refine the hit position Q with a binary search of 30 steps, decreasing the step size by a factor of 0.5 in
// each iteration"
float BinarySearch(Cone cone, float pathLength, float stride, int layer) {
    for (int i = 0; i < SEARCH_COUNT; ++i) {
        // 6: "If Q is within a defined epsilon we found our final hit-point"
        // Departure: epsilon, which is not printed, is a part of the depth.
        float delta = DepthDelta(cone, pathLength, layer);
        if (abs(delta) <= poster.epsilon * At(cone, pathLength).z)
            return pathLength;

        // 5: the next step
        pathLength += delta > 0.0 ? stride : -stride;
        stride *= SEARCH_DECREASE;
    }
    // 7: no hit-point after the search: -1
    // Departure: the print does not say what follows then.
    return -1.0;
}

// Whether a hit-point lies on a surface of its layer, and not on the slope that the filter makes between the depths of
// two surfaces. A texel further on, the axis may then lie behind the layer by no more than the layer's thickness and
// the change of the axis's own depth.
bool Stands(Cone cone, float pathLength, int layer) {
    vec3 Q = At(cone, pathLength);
    float texel = exp2(Level(cone.solidAngle, pathLength, Q.z));
    // The path goes on by a texel's width, and by more where it is seen shortened, up to MOST_SHORTENED times.
    float further = texel * ScreenHeight(Q.z) / camera.resolution.y;
    vec2 across = (Project(At(cone, pathLength + further)).xy - Project(Q).xy) * camera.resolution;
    further *= clamp(texel / max(length(across), 1e-6), 1.0, MOST_SHORTENED);
    float deeper = abs(At(cone, pathLength + further).z - Q.z);
    return DepthDelta(cone, pathLength + further, layer) >= -(poster.thickness + deeper);
}

// The length of the path to the hit-point, -1 for none, and the layer that it lies on.
// 2: "ray-march through the image from P in the reflected viewing direction V_R with continuously increasing step size by a
// factor of 1.5 for a maximum of 100 steps"
float ConeMarch(Cone cone, out int layer) {
    layer = 0;
    bvec2 wasBehind = bvec2(false);
    float previous = 0.0;
    float stride = poster.first_step * ScreenHeight(cone.origin.z);
    int edgeHits = 0;
    for (int i = 0; i < STEP_COUNT; ++i) {
        float pathLength = previous + stride;
        vec3 Q = At(cone, pathLength);

        // Departure: a step that leaves the screen is a miss, or is halved; the print does not speak of it.
        if (Q.z <= camera.near_plane || Q.z >= camera.far_plane || LeftScreen(Project(Q).xy)) {
            if (edgeHits >= poster.edge_retries)
                return -1.0;
            ++edgeHits;
            stride *= 0.5;
            continue;
        }
        edgeHits = 0;

        // 3, 4: "If we step through the depth buffer (i.e. the current cone positions Z is behind the sampled depth), a
        // hit-point is detected. We go back to the midpoint of the current position Q_N and the previous position Q_N-1"
        // Departure: the hit is at most half a step from the midpoint, so that the search begins with a quarter step.
        if (!LAYERS && DepthDelta(cone, pathLength, 0) < 0.0)
            return BinarySearch(cone, previous + 0.5 * stride, 0.25 * stride, 0);

        // Departure: with two layers of depth, each is searched where the ray went behind it.
        for (int l = 0; LAYERS && l < 2; ++l) {
            bool isBehind = DepthDelta(cone, pathLength, l) < 0.0;
            if (isBehind && !wasBehind[l]) {
                float found = BinarySearch(cone, previous + 0.5 * stride, 0.25 * stride, l);
                if (found >= 0.0 && Stands(cone, found, l)) {
                    layer = l;
                    return found;
                }
            }
            wasBehind[l] = isBehind;
        }

        // 2: the next step
        previous = pathLength;
        stride *= STEP_INCREASE;
    }
    return -1.0;
}

SHADE_ALL(out_reflection, STORE_IF(HITS, out_hit)) {
    out_reflection = vec4(0.0);
    if (HITS)
        out_hit = vec4(vec3(-1.0), PATH_NONE);
    ivec2 pixel = ivec2(PIXEL_CENTRE);
    vec2 material = texelFetch(material_buffer, pixel, 0).rg;
    vec3 normal = texelFetch(normal_buffer, pixel, 0).xyz;
    if (material.r <= REFLECTS_ABOVE || dot(normal, normal) <= NO_NORMAL)
        return;

    // 1: "we reconstruct the position P of each pixel in world space and its normal N from the GBuffer"
    // Departure: in view space, along the pixel's line of sight.
    vec2 texCoord = PIXEL_CENTRE / camera.resolution;
    vec4 sight = camera.clip_to_view * vec4(texCoord * vec2(2.0, -2.0) + vec2(-1.0, 1.0), 0.5, 1.0);
    float z = Filtered(filtered_depth, texCoord, 0.0).r;
    Cone cone;
    cone.origin = sight.xyz * (z / sight.z);
    cone.direction = reflect(normalize(cone.origin), normalize(normal));
    float halfAngle = ConeAngle(material.g);
    // 2 pi (1 - cos(halfAngle)), without the difference of nearly equal numbers
    cone.solidAngle = 4.0 * 3.14159265 * pow(sin(0.5 * halfAngle), 2.0);

    if (HITS)
        out_hit = vec4(vec3(-1.0), PATH_LINEAR_MISS);
    int layer;
    float pathLength = ConeMarch(cone, layer);
    if (pathLength < 0.0)
        return;
    vec3 Q = At(cone, pathLength);
    vec3 hit = Project(Q);
    float level = Level(cone.solidAngle, pathLength, Q.z);

    // 9: "After we found a hit point Q, we also access the filtered normal"
    // Departure: not said what for. What faces away from the cone sends nothing along it. Seen a pixel further on: where
    // surfaces meet, the texel of the hit-point may still be the surface that the cone began on.
    vec2 across = (hit.xy - texCoord) * camera.resolution;
    vec2 beyond = hit.xy + across / (max(length(across), 1e-6) * camera.resolution);
    bool isSecond = LAYERS && layer == 1;
    vec3 facing = isSecond ? Filtered(behind_normal, beyond, level).xyz : Filtered(filtered_normal, beyond, level).xyz;
    if (dot(facing, cone.direction) >= 0.0)
        return;
    if (HITS)
        out_hit = vec4(hit, PATH_LINEAR);

    // 10: "and color texture to compute the final incident radiance of the cone, which we add as secondary contribution to the
    // pixel's radiance"
    float fade = poster.fade != 0 ? BorderFade(hit.xy, poster.fade_start, poster.fade_end) : 1.0;
    vec3 color = isSecond ? Filtered(behind_color, hit.xy, level).rgb : Filtered(filtered_color, hit.xy, level).rgb;
    out_reflection = vec4(color, fade);
}
