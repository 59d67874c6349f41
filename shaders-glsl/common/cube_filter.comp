#version 460
#pragma program(CubeFilter)
// One level of a cube map blurred by roughness: each texel is the mean over the Phong lobe around its direction
// (docs/definitions.md, "Surfaces"). The lobe's directions are a Hammersley set, the same for every texel. Each
// direction reads the level of the source whose texel is about as large as the solid angle that the sample stands for
// (Krivanek and Colbert 2008), so that few samples are enough.

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform samplerCube source;                      // box-filtered chain
layout(binding = 1, rgba16f) uniform writeonly imageCube filtered;   // the level that is written

layout(push_constant) uniform CubeFilterBlock {
    float exponent;  // of the lobe
    uint samples;
} lobe;

const float TAU = 6.28318530718;

// The direction, of any length, to the position `st` (-1 to 1) on a face. Faces have Vulkan's order +x -x +y -y +z -z.
// Twin of `scene::sky::face_direction`.
vec3 FaceDirection(uint face, vec2 st) {
    switch (face) {
        case 0: return vec3(1.0, -st.y, -st.x);
        case 1: return vec3(-1.0, -st.y, st.x);
        case 2: return vec3(st.x, 1.0, st.y);
        case 3: return vec3(st.x, -1.0, -st.y);
        case 4: return vec3(st.x, -st.y, 1.0);
        default: return vec3(-st.x, -st.y, -1.0);
    }
}

// The bits of i mirrored at the binary point, 0 to 1: the second coordinate of point i of a Hammersley set.
float RadicalInverse(uint i) {
    return float(bitfieldReverse(i)) * exp2(-32.0);
}

void main() {
    uvec3 cube_texel = gl_GlobalInvocationID;
    ivec2 size = imageSize(filtered);
    if (any(greaterThanEqual(cube_texel.xy, uvec2(size)))) {
        return;
    }
    vec3 axis = normalize(FaceDirection(cube_texel.z, (vec2(cube_texel.xy) + 0.5) / vec2(size) * 2.0 - 1.0));
    vec3 tangent = normalize(cross(abs(axis.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0), axis));
    vec3 bitangent = cross(axis, tangent);
    float source_side = float(textureSize(source, 0).x);
    // The mean solid angle of a texel of the source's level 0: that of the sphere over the number of texels.
    float texel_solid_angle = 2.0 * TAU / (6.0 * source_side * source_side);

    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < lobe.samples; ++i) {
        // u = cos^(exponent + 1) of the angle to the axis is uniform. Its logarithm keeps the sines of narrow lobes
        // exact.
        float u = (float(i) + 0.5) / float(lobe.samples);
        float log2_cos = log2(u) / (lobe.exponent + 1.0);
        float cosine = exp2(log2_cos);
        float sine = sqrt(max(0.0, 1.0 - cosine * cosine));
        float phi = TAU * RadicalInverse(i);
        vec3 direction = sine * cos(phi) * tangent + sine * sin(phi) * bitangent + cosine * axis;
        float density = (lobe.exponent + 1.0) / TAU * exp2(lobe.exponent * log2_cos);
        // The sample stands for the solid angle 1 / (samples * density). Four texels of a level make one of the next.
        float level = 0.5 * log2(1.0 / (float(lobe.samples) * density * texel_solid_angle));
        sum += textureLod(source, direction, max(level, 0.0)).rgb;
    }
    imageStore(filtered, ivec3(cube_texel), vec4(sum / float(lobe.samples), 1.0));
}
