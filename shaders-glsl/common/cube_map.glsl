// Lookups in a cube map whose levels are blurred by roughness (`passes::CubeMap`). World axes.

// The level of a cube map for a roughness: level 0 is a mirror, level n > 0 holds roughness 2^(n - last), linear
// between 0 and level 1. Twin of `passes::cube_filter::level_roughness`, which is its inverse.
float CubeLevel(float roughness, int levels) {
    float last = float(levels - 1);
    float first = exp2(1.0 - last);
    return roughness < first ? max(roughness, 0.0) / first : min(last + log2(roughness), last);
}

// The colour of a blurred cube map along a direction in world axes, for a surface of a roughness.
vec4 SampleCube(samplerCube map, vec3 direction, float roughness) {
    return textureLod(map, direction, CubeLevel(roughness, textureQueryLevels(map)));
}
