#version 460
#pragma program(ScreenSpaceReflections)
// Screen space reflections (Schmidt 2013, section 5.4.1): listing 4, and with OPTIMIZED the march of
// listing 5 in its place. Spaces here: texture coordinates from the top left and standard depth,
// which are the listing's 0.5 * ndc + 0.5 but for the direction of y. With LAYERS what a ray that went behind the first
// layer of depth meets is the second one (section 6).

#include "common/camera.glsl"
#include "common/constants.glsl"

layout(constant_id = 0) const bool OPTIMIZED = false; // listing 5, `ssr-fast`; else listing 4, `ssr`
layout(constant_id = 1) const bool HITS = false;      // whether out_hit is wanted
layout(constant_id = 2) const bool LAYERS = false;    // whether there is a second layer

layout(push_constant) uniform SchmidtBlock {
    float user_pixelStepSize; // pixels that are marched at once
    int fadeToEdges;          // 0 or 1
    int toggleBlur;           // 0 or 1; listing 5 alone has a blur
} schmidt;

layout(binding = 1) uniform sampler2D DepthTex;        // reversed; nearest
layout(binding = 2) uniform sampler2D normalBuffer;    // view space
layout(binding = 3) uniform sampler2D materialBuffer;  // reflectivity, roughness
layout(binding = 4) uniform sampler2D DiffuseTex;      // lit colour; trilinear
layout(binding = 5) uniform sampler2D BehindDepthTex;  // the same two of the second layer, which are read with LAYERS
layout(binding = 6) uniform sampler2D BehindDiffuseTex; // alone

// Eq. 28, as printed. It linearises z in [-1, 1] and is fed z in [0, 1]: an erratum that is kept. It
// gives 2 d / (d + far) for a view depth d.
float linearizeDepth(float z) {
    return (2.0 * camera.near_plane)
        / (camera.far_plane + camera.near_plane - z * (camera.far_plane - camera.near_plane));
}

// Departure: the G-buffer's depth is reversed; the listing reads ".z" of a depth texture, which is 0
// in the OpenGL versions that the text names.
float SampleDepth(vec2 samplingPosition) {
    return 1.0 - textureLod(DepthTex, samplingPosition, 0.0).r;
}

float SampleBehind(vec2 samplingPosition) {
    return 1.0 - textureLod(BehindDepthTex, samplingPosition, 0.0).r;
}

vec4 SampleDiffuse(vec2 samplingPosition, float level, bool behind) {
    if (LAYERS && behind)
        return textureLod(BehindDiffuseTex, samplingPosition, level);
    return textureLod(DiffuseTex, samplingPosition, level);
}

vec3 Project(vec3 vsPoint) {
    vec4 csPoint = camera.view_to_clip * vec4(vsPoint, 1.0);
    vec3 ndcsPoint = csPoint.xyz / csPoint.w;
    return vec3(0.5 * ndcsPoint.x + 0.5, 0.5 - 0.5 * ndcsPoint.y, ndcsPoint.z);
}

// The reflected colour, and the fade in a, which the listing multiplies in. `hit`: texture
// coordinates and standard depth of what was returned, PATH_*.
vec4 ScreenSpaceReflections(in vec3 vsPosition, in vec3 vsNormal, in vec3 vsReflectionVector, out vec4 hit) {
    // Variables
    vec4 reflectedColor = vec4(0.0);
    vec2 pixelSize = 1.0 / camera.resolution;
    hit = vec4(vec3(-1.0), PATH_LINEAR_MISS);

    // Project vertex position to screen space
    vec3 ssPosition = Project(vsPosition);

    // Project reflected vector to screen space. Erratum, kept: the point one metre along the
    // reflection may lie behind the camera, where the projection turns the vector round.
    vsReflectionVector += vsPosition;
    vec3 ssReflectionVector = Project(vsReflectionVector);
    ssReflectionVector = normalize(ssReflectionVector - ssPosition);

    // Ray trace. The initial step is one pixel; pixelStepSize describes how many pixels at once are
    // ray marched. Erratum: both listings declare it and use it nowhere.
    float initialStep = OPTIMIZED ? pixelSize.y : min(pixelSize.x, pixelSize.y);
    float pixelStepSize = schmidt.user_pixelStepSize;
    ssReflectionVector *= initialStep * pixelStepSize;

    // Sampling positions
    vec3 lastSamplePosition = ssPosition + ssReflectionVector;
    vec3 currentSamplePosition = lastSamplePosition + ssReflectionVector;

    int sampleCount = max(int(camera.resolution.x), int(camera.resolution.y));
    if (OPTIMIZED)
        sampleCount /= 10;
    int count = 0;
    while (count < sampleCount) {
        // Out of texture space --> break
        if (currentSamplePosition.x < 0.0 || currentSamplePosition.x > 1.0 ||
            currentSamplePosition.y < 0.0 || currentSamplePosition.y > 1.0 ||
            currentSamplePosition.z < 0.0 || currentSamplePosition.z > 1.0) {
            break;
        }

        // Update ray marching variables
        vec2 samplingPosition = currentSamplePosition.xy;
        float samplingZ = currentSamplePosition.z;
        float currentDepth = linearizeDepth(samplingZ);
        float sampledDepth = linearizeDepth(SampleDepth(samplingPosition));
        // A ray that is deeper than the first layer is thick is held against the second one.
        bool behind = LAYERS && currentDepth - sampledDepth > (OPTIMIZED ? 0.002 : 0.001);
        if (behind)
            sampledDepth = linearizeDepth(SampleBehind(samplingPosition));

        if (OPTIMIZED) {
            // Step ray: behind the sampled depth a tenth of the vector back, before it ten forward.
            if (currentDepth > sampledDepth) {
                lastSamplePosition = currentSamplePosition;
                currentSamplePosition = lastSamplePosition - ssReflectionVector / 10.0;
            } else if (currentDepth < sampledDepth) {
                lastSamplePosition = currentSamplePosition;
                currentSamplePosition = lastSamplePosition + ssReflectionVector * 10.0;
            }

            // Ray hit. Errata, kept: on either side of the surface, so at the start the surface itself; and
            // the march goes on, so that the last hit is what is seen.
            float delta = abs(currentDepth - sampledDepth);
            if (delta < 0.002) {
                hit = vec4(samplingPosition, samplingZ, PATH_LINEAR);
                if (schmidt.toggleBlur != 0) {
                    // Blurring dependent on the viewer's distance. Erratum, kept: the colour of level 7 is
                    // added to the sum and not counted.
                    float f = currentDepth;
                    float blurSize = 15.0 * f;
                    reflectedColor = SampleDiffuse(samplingPosition, 7.0, behind);

                    int counter = 0;
                    for (float i = -blurSize / 2.0; i < blurSize / 2.0; i += 1.5) {
                        vec2 tap = vec2(samplingPosition.x, samplingPosition.y + 1.0 * i * pixelSize.y);
                        reflectedColor += SampleDiffuse(tap, 0.0, behind);
                        counter++;
                    }
                    reflectedColor /= float(counter);
                } else {
                    // No blurring, just the colour at the sampled position
                    reflectedColor = SampleDiffuse(samplingPosition, 0.0, behind);
                }
            }
        } else {
            // If currentDepth (z-value of ray) is bigger than the sampled depth from texture
            // the ray hit something
            if (currentDepth > sampledDepth) {
                float delta = abs(currentDepth - sampledDepth);
                if (delta <= 0.001) {
                    reflectedColor = SampleDiffuse(samplingPosition, 0.0, behind);
                    hit = vec4(samplingPosition, samplingZ, PATH_LINEAR);
                    break;
                }
            }

            // Step ray
            lastSamplePosition = currentSamplePosition;
            currentSamplePosition = lastSamplePosition + ssReflectionVector;
        }
        count++;
    }

    // Fading to screen edges
    vec2 fadeToScreenEdge = vec2(1.0);
    if (schmidt.fadeToEdges != 0) {
        // x-direction
        fadeToScreenEdge.x = distance(lastSamplePosition.x, 1.0);
        fadeToScreenEdge.x *= distance(lastSamplePosition.x, 0.0) * 4.0;
        // y-direction
        fadeToScreenEdge.y = distance(lastSamplePosition.y, 1.0);
        fadeToScreenEdge.y *= distance(lastSamplePosition.y, 0.0) * 4.0;
    }

    if (hit.w != PATH_LINEAR) {
        return vec4(0.0);
    }
    return vec4(reflectedColor.rgb, fadeToScreenEdge.x * fadeToScreenEdge.y);
}

layout(location = 0) out vec4 out_reflection; // colour, and fade in a
layout(location = 1) out vec4 out_hit;        // texture coordinates, standard depth, PATH_*

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(DepthTex, pixel, 0).r;
    float reflectivity = texelFetch(materialBuffer, pixel, 0).r;
    vec4 reflectedColor = vec4(0.0);
    vec4 hit = vec4(vec3(-1.0), PATH_NONE);
    if (reflectivity > REFLECTS_ABOVE && depth > 0.0) {
        // Departure: the listing's G-buffer keeps positions; here they come from the depth.
        vec2 ndc = gl_FragCoord.xy / camera.resolution * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
        vec4 h = camera.clip_to_view_reversed * vec4(ndc, depth, 1.0);
        vec3 vsPosition = h.xyz / h.w;
        vec3 vsNormal = normalize(texelFetch(normalBuffer, pixel, 0).xyz);
        vec3 vsReflectionVector = reflect(normalize(vsPosition), vsNormal);
        reflectedColor = ScreenSpaceReflections(vsPosition, vsNormal, vsReflectionVector, hit);
    }
    out_reflection = reflectedColor;
    if (HITS)
        out_hit = hit;
}
