#version 460
#pragma program(Visibility)
#pragma in_either_stage
// Pre-integration: one level of the visibility buffer from the level below (thesis 4.2.5 and its
// listing, Eq. 4.2).

#include "common/either_stage.glsl"

layout(binding = 0) uniform sampler2D depthMap;      // Hi-Z, the level below
layout(binding = 1) uniform sampler2D visibilityMap; // visibility, the level below

layout(push_constant) uniform VisibilityBlock {
    float near_plane;
    float far_plane;
} range;

OUTPUT(0, r8, float, coarseVisibility);

// Print: §4.2.5, Eq. 4.2.
// 1: Linearize(z) = 2 P_near / (P_far + P_near - z * (P_far - P_near))
// Erratum, kept: it linearises z in [-1, 1] and is fed z in [0, 1].
float Linearize(float z) {
    return (2.0 * range.near_plane) / (range.far_plane + range.near_plane - z * (range.far_plane - range.near_plane));
}

// Print: §4.2.5, listing.
SHADE(coarseVisibility) {
    // 1-5: Fetch texels from previous depth map LOD
    // Departure: clamped, as in hi_z.frag; and both maps are bound as views of that one level, so that the listing's
    // mipPrevious is level 0 here.
    ivec2 coordCoarse = ivec2(PIXEL_CENTRE);
    ivec2 coordFine = coordCoarse * ivec2(2);
    ivec2 last = textureSize(depthMap, 0) - 1;

    // 7-11: fineZ
    vec4 fineZ;
    fineZ.x = Linearize(texelFetch(depthMap, min(coordFine, last), 0).r);
    fineZ.y = Linearize(texelFetch(depthMap, min(coordFine + ivec2(1, 0), last), 0).r);
    fineZ.z = Linearize(texelFetch(depthMap, min(coordFine + ivec2(0, 1), last), 0).r);
    fineZ.w = Linearize(texelFetch(depthMap, min(coordFine + ivec2(1, 1), last), 0).r);

    // 13-18: Fetch fine visibility from previous visibility map LOD
    vec4 visibility;
    visibility.x = texelFetch(visibilityMap, min(coordFine, last), 0).r;
    visibility.y = texelFetch(visibilityMap, min(coordFine + ivec2(1, 0), last), 0).r;
    visibility.z = texelFetch(visibilityMap, min(coordFine + ivec2(0, 1), last), 0).r;
    visibility.w = texelFetch(visibilityMap, min(coordFine + ivec2(1, 1), last), 0).r;

    // 20-22: Integrate visibility
    float maxZ = max(max(fineZ.x, fineZ.y), max(fineZ.z, fineZ.w));
    vec4 integration = visibility * (fineZ / maxZ);

    // 24-26: Compute coarse visibility, the output value for the current render target
    coarseVisibility = dot(vec4(0.25), integration);
}
