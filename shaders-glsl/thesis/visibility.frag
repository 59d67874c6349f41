#version 460
#pragma program(Visibility)
// Pre-integration: one level of the visibility buffer from the level below (thesis 4.2.5 and its
// listing, Eq. 4.2).

layout(binding = 0) uniform sampler2D depthMap;      // Hi-Z, the level below
layout(binding = 1) uniform sampler2D visibilityMap; // visibility, the level below

layout(push_constant) uniform VisibilityBlock {
    float near_plane;
    float far_plane;
} range;

layout(location = 0) out float coarseVisibility;

// Eq. 4.2, as printed. It linearises z in [-1, 1] and is fed z in [0, 1]: an erratum that is kept.
float Linearize(float z) {
    return (2.0 * range.near_plane) / (range.far_plane + range.near_plane - z * (range.far_plane - range.near_plane));
}

void main() {
    // Fetch texels from the level below. Departure: clamped, as in hi_z.frag; and both maps are
    // bound as views of that one level, so the listing's mipLevel - 1 is level 0 here.
    ivec2 coordCoarse = ivec2(gl_FragCoord.xy);
    ivec2 coordFine = coordCoarse * ivec2(2);
    ivec2 last = textureSize(depthMap, 0) - 1;

    vec4 fineZ;
    fineZ.x = Linearize(texelFetch(depthMap, min(coordFine, last), 0).r);
    fineZ.y = Linearize(texelFetch(depthMap, min(coordFine + ivec2(1, 0), last), 0).r);
    fineZ.z = Linearize(texelFetch(depthMap, min(coordFine + ivec2(0, 1), last), 0).r);
    fineZ.w = Linearize(texelFetch(depthMap, min(coordFine + ivec2(1, 1), last), 0).r);

    // Fetch fine visibility.
    vec4 visibility;
    visibility.x = texelFetch(visibilityMap, min(coordFine, last), 0).r;
    visibility.y = texelFetch(visibilityMap, min(coordFine + ivec2(1, 0), last), 0).r;
    visibility.z = texelFetch(visibilityMap, min(coordFine + ivec2(0, 1), last), 0).r;
    visibility.w = texelFetch(visibilityMap, min(coordFine + ivec2(1, 1), last), 0).r;

    // Integrate visibility.
    float maxZ = max(max(fineZ.x, fineZ.y), max(fineZ.z, fineZ.w));
    vec4 integration = visibility * (fineZ / maxZ);

    // Compute coarse visibility.
    coarseVisibility = dot(vec4(0.25), integration);
}
