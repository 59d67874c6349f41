// Lookups in a cube map whose levels are blurred by roughness (`passes::CubeMap`). World axes.

// The level of a cube map for a roughness: level 0 holds roughness 0, and level n > 0 holds roughness 2^(n - last).
// Between levels 0 and 1 the roughness is linear in the level. Twin of `passes::cube_filter::level_roughness`, which is
// its inverse.
float CubeLevel(float roughness, int levels) {
    float last = float(levels - 1);
    float first_roughness = exp2(1.0 - last);
    return roughness < first_roughness ? max(roughness, 0.0) / first_roughness : min(last + log2(roughness), last);
}

// The colour of a blurred cube map along a direction in world axes, for a surface of a roughness.
vec4 SampleCube(samplerCube map, vec3 direction, float roughness) {
    return textureLod(map, direction, CubeLevel(roughness, textureQueryLevels(map)));
}
