#version 460
#pragma program(ScreenSpaceReflections)
#pragma in_either_stage
// Screen space reflections (Schmidt 2013, section 5.4.1): listing 4, and with OPTIMIZED the march of listing 5 in place
// of its own. Positions are texture coordinates from the top left and standard depth: the listing's 0.5 * ndc + 0.5 but
// for the direction of y. With LAYERS, a ray that went behind the first layer of depth meets the second one (section
// 6); only SampleDepth and SampleDiffuse know of it.

#include "common/either_stage.glsl"
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

// Print: §5.4.1, Eq. 28.
// 1: z_linear = 2 n / (f + n - z_ndc * (f - n))
// Erratum, kept: it linearises z in [-1, 1] and is fed z in [0, 1]. It gives 2 d / (d + far) for a view depth d.
float linearizeDepth(float z) {
    return (2.0 * camera.near_plane)
        / (camera.far_plane + camera.near_plane - z * (camera.far_plane - camera.near_plane));
}

// Whether SampleDepth read the second layer of depth last.
bool behind = false;

// Reads the linearised depth at a place. With LAYERS, a ray that is behind the first layer by more than `thickness` gets the
// depth of the second layer. Departure: the G-buffer's depth is reversed; the listings read ".z" of a depth texture, which
// is 0 in the OpenGL versions that the text names.
float SampleDepth(vec2 samplingPosition, float currentDepth, float thickness) {
    float sampledDepth = linearizeDepth(1.0 - textureLod(DepthTex, samplingPosition, 0.0).r);
    behind = LAYERS && currentDepth - sampledDepth > thickness;
    if (behind)
        sampledDepth = linearizeDepth(1.0 - textureLod(BehindDepthTex, samplingPosition, 0.0).r);
    return sampledDepth;
}

// Reads the lit colour of the layer that SampleDepth read last.
vec4 SampleDiffuse(vec2 samplingPosition, float level) {
    if (LAYERS && behind)
        return textureLod(BehindDiffuseTex, samplingPosition, level);
    return textureLod(DiffuseTex, samplingPosition, level);
}

// The texture coordinates and the standard depth of a view-space point.
vec3 Project(vec3 vsPoint) {
    vec4 csPoint = camera.view_to_clip * vec4(vsPoint, 1.0);
    vec3 ndcsPoint = csPoint.xyz / csPoint.w;
    return vec3(0.5 * ndcsPoint.x + 0.5, 0.5 - 0.5 * ndcsPoint.y, ndcsPoint.z);
}

// Variables of ScreenSpaceReflections, which is one function in print. `hit` has texture coordinates and standard depth of
// what was hit, and PATH_*.
vec2 pixelSize;
vec4 reflectedColor;
vec3 lastSamplePosition;
vec3 currentSamplePosition;
vec4 hit;

bool OutOfTextureSpace(vec3 currentSamplePosition) {
    return currentSamplePosition.x < 0.0 || currentSamplePosition.x > 1.0 ||
           currentSamplePosition.y < 0.0 || currentSamplePosition.y > 1.0 ||
           currentSamplePosition.z < 0.0 || currentSamplePosition.z > 1.0;
}

// Print: listing 4.
// 20-25: Ray trace: the initial step is one pixel; pixelStepSize describes how much pixel at once are ray marched
// Erratum: both listings declare pixelStepSize and never use it; here it scales the step.
void UnoptimizedRayTrace(vec3 ssPosition, vec3 ssReflectionVector) {
    float initialStep = min(pixelSize.x, pixelSize.y);
    float pixelStepSize = schmidt.user_pixelStepSize;
    ssReflectionVector *= initialStep * pixelStepSize;

    // 27-29: Sampling positions
    lastSamplePosition = ssPosition + ssReflectionVector;
    currentSamplePosition = lastSamplePosition + ssReflectionVector;

    // 31-37: sampleCount, count
    int sampleCount = max(int(camera.resolution.x), int(camera.resolution.y));
    int count = 0;
    while (count < sampleCount) {
        // 39-50: Out of texture space --> break
        if (OutOfTextureSpace(currentSamplePosition))
            break;

        // 52-55: Update ray marching variables
        // Departure: of two layers of depth, the one that the ray may hit (--layers).
        vec2 samplingPosition = currentSamplePosition.xy;
        float currentDepth = linearizeDepth(currentSamplePosition.z);
        float sampledDepth = SampleDepth(samplingPosition, currentDepth, 0.001);

        // 57-68: If currentDepth (z-value of ray) is bigger than the sampled depth from texture the ray hit something
        if (currentDepth > sampledDepth) {
            float delta = abs(currentDepth - sampledDepth);
            if (delta <= 0.001) {
                reflectedColor = SampleDiffuse(samplingPosition, 0.0);
                hit = vec4(currentSamplePosition, PATH_LINEAR);
                break;
            }
        }

        // 70-72: Step ray
        lastSamplePosition = currentSamplePosition;
        currentSamplePosition = lastSamplePosition + ssReflectionVector;

        // 74, 75: count++
        count++;
    }
}

// Print: listing 5.
// 1-6: Optimized ray trace
// Erratum: the listing stands in place of lines 20 to 75 of listing 4, and declares pixelStepSize and uses it nowhere.
void OptimizedRayTrace(vec3 ssPosition, vec3 ssReflectionVector) {
    float initialStep = pixelSize.y;
    float pixelStepSize = schmidt.user_pixelStepSize;
    ssReflectionVector *= initialStep * pixelStepSize;

    // 8, 9: lastSamplePosition, currentSamplePosition
    lastSamplePosition = ssPosition + ssReflectionVector;
    currentSamplePosition = lastSamplePosition + ssReflectionVector;

    // 11-15: sampleCount, count
    int sampleCount = max(int(camera.resolution.x), int(camera.resolution.y)) / 10;
    int count = 0;
    while (count < sampleCount) {
        // 17-28: Out of texture space --> break
        if (OutOfTextureSpace(currentSamplePosition))
            break;

        // 30-32: samplingPosition, sampledDepth, currentDepth
        // Departure: of two layers of depth, the one that the ray may hit (--layers).
        vec2 samplingPosition = currentSamplePosition.xy;
        float samplingZ = currentSamplePosition.z;
        float currentDepth = linearizeDepth(samplingZ);
        float sampledDepth = SampleDepth(samplingPosition, currentDepth, 0.002);

        // 35-42: If ray's z is bigger than sampled depth --> step backward by subtracting a tenth of the reflected vector
        if (currentDepth > sampledDepth) {
            lastSamplePosition = currentSamplePosition;
            currentSamplePosition = lastSamplePosition - ssReflectionVector / 10.0;
        }
        // 43-49: If ray's z is smaller than sampled depth --> step forward by adding a tenth of the reflected vector
        // Erratum, kept: the words say a tenth, the code ten times the vector.
        else if (currentDepth < sampledDepth) {
            lastSamplePosition = currentSamplePosition;
            currentSamplePosition = lastSamplePosition + ssReflectionVector * 10.0;
        }

        // 51-54: Ray hit
        // Erratum, kept: on either side of the surface, so at the start the surface itself; and the march goes on, so that
        // the last hit is what is seen.
        float delta = abs(currentDepth - sampledDepth);
        if (delta < 0.002) {
            hit = vec4(samplingPosition, samplingZ, PATH_LINEAR);

            // 55-61: Blurring dependent on viewer's distance
            // Erratum, kept: the colour of level 7 is added to the sum and not counted.
            if (schmidt.toggleBlur != 0) {
                float f = currentDepth;
                float blurSize = 15.0 * f;
                reflectedColor = SampleDiffuse(samplingPosition, 7.0);

                // 63-71: the mean of samples along y
                int counter = 0;
                for (float i = -blurSize / 2.0; i < blurSize / 2.0; i += 1.5) {
                    vec2 tap = vec2(samplingPosition.x, samplingPosition.y + 1.0 * i * pixelSize.y);
                    reflectedColor += SampleDiffuse(tap, 0.0);
                    counter++;
                }
                reflectedColor /= float(counter);
            }
            // 72-77: No blurring, just return color at sampled position
            else {
                reflectedColor = SampleDiffuse(samplingPosition, 0.0);
            }
        }

        // 79-81: count++
        count++;
    }
}

// Print: listing 4.
// 1-3: ScreenSpaceReflections
// Departure: the fade is returned in a; the listing multiplies it in.
vec4 ScreenSpaceReflections(in vec3 vsPosition, in vec3 vsNormal, in vec3 vsReflectionVector) {
    // 4-6: Variables
    reflectedColor = vec4(0.0);
    pixelSize = 1.0 / camera.resolution;
    hit = vec4(vec3(-1.0), PATH_LINEAR_MISS);

    // 8-11: Project vertex position to screen space
    vec3 ssPosition = Project(vsPosition);

    // 13-18: Project reflected vector to screen space
    // Erratum, kept: the point one metre along the reflection may lie behind the camera, where the projection turns the
    // vector round.
    vsReflectionVector += vsPosition;
    vec3 ssReflectionVector = Project(vsReflectionVector);
    ssReflectionVector = normalize(ssReflectionVector - ssPosition);

    if (OPTIMIZED)
        OptimizedRayTrace(ssPosition, ssReflectionVector);
    else
        UnoptimizedRayTrace(ssPosition, ssReflectionVector);

    // 77-90: Fading to screen edges
    // Erratum, kept: 4 x (1 - x) is 1 in the middle of the screen alone.
    vec2 fadeToScreenEdge = vec2(1.0);
    if (schmidt.fadeToEdges != 0) {
        // x-direction
        fadeToScreenEdge.x = distance(lastSamplePosition.x, 1.0);
        fadeToScreenEdge.x *= distance(lastSamplePosition.x, 0.0) * 4.0;
        // y-direction
        fadeToScreenEdge.y = distance(lastSamplePosition.y, 1.0);
        fadeToScreenEdge.y *= distance(lastSamplePosition.y, 0.0) * 4.0;
    }

    // 92, 93: return reflectedColor * fadeToScreenEdge.x * fadeToScreenEdge.y
    if (hit.w != PATH_LINEAR)
        return vec4(0.0);
    return vec4(reflectedColor.rgb, fadeToScreenEdge.x * fadeToScreenEdge.y);
}

OUTPUT(0, rgba16f, vec4, out_reflection); // colour, and fade in alpha
OUTPUT(1, rgba32f, vec4, out_hit);        // texture coordinates, standard depth, PATH_*

SHADE_ALL(out_reflection, STORE_IF(HITS, out_hit)) {
    ivec2 pixel = ivec2(PIXEL_CENTRE);
    float depth = texelFetch(DepthTex, pixel, 0).r;
    float reflectivity = texelFetch(materialBuffer, pixel, 0).r;
    out_reflection = vec4(0.0);
    hit = vec4(vec3(-1.0), PATH_NONE);
    if (reflectivity > REFLECTS_ABOVE && depth > 0.0) {
        // Departure: the listing's G-buffer keeps positions; here they come from the depth.
        vec2 ndc = PIXEL_CENTRE / camera.resolution * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
        vec4 h = camera.clip_to_view_reversed * vec4(ndc, depth, 1.0);
        vec3 vsPosition = h.xyz / h.w;
        vec3 vsNormal = normalize(texelFetch(normalBuffer, pixel, 0).xyz);
        vec3 vsReflectionVector = reflect(normalize(vsPosition), vsNormal);
        out_reflection = ScreenSpaceReflections(vsPosition, vsNormal, vsReflectionVector);
    }
    if (HITS)
        out_hit = hit;
}
