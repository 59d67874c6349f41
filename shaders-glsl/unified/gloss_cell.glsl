// The cells of 2 x 2 pixels that wide lobes are traced and resolved for. Needs parameters.glsl, tiles.glsl,
// gloss.glsl, depth_buffer and material_buffer.

// The cell's pixel that stands for it, the first with a wide lobe, and its roughness; 0 if none has.
ivec2 WidePixel(ivec2 cell, out float roughness) {
    ivec2 pixel = 2 * cell;
    roughness = 0.0;
    for (int i = 0; i < 4 && !(roughness > 0.0); ++i) {
        ivec2 p = min(2 * cell + ivec2(i & 1, i >> 1), unified.size - 1);
        vec2 material = texelFetch(material_buffer, p, 0).rg;
        if (Reflects(material) && ListOf(material) == WIDE_LIST && texelFetch(depth_buffer, p, 0).r > 0.0) {
            pixel = p;
            roughness = material.g;
        }
    }
    return pixel;
}
