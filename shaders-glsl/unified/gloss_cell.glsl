// The cells of 2 x 2 pixels that wide lobes are traced and resolved for. Needs parameters.glsl, tiles.glsl,
// gloss.glsl, pyramid and material_buffer.

// The pixel that stands for a cell: its first or its last, by turns as on a chequerboard, so that what is a pixel
// wide and straight is met by some of the cells that it runs through.
ivec2 CellPixel(ivec2 cell) {
    return 2 * cell + ((cell.x + cell.y) & 1);
}

// The pixel that a cell's ray is of, CellPixel or another if that has no wide lobe, and its roughness; 0 if none has.
ivec2 WidePixel(ivec2 cell, out float roughness) {
    ivec2 pixel = CellPixel(cell);
    ivec2 turned = pixel & 1;
    roughness = 0.0;
    for (int i = 0; i < 4 && !(roughness > 0.0); ++i) {
        ivec2 p = min(2 * cell + (ivec2(i & 1, i >> 1) ^ turned), unified.size - 1);
        vec2 material = imageLoad(material_buffer, p).rg;
        if (Reflects(material) && ListOf(material) == WIDE_LIST && imageLoad(pyramid, PixelTexel(p)).r > 0.0) {
            pixel = p;
            roughness = material.g;
        }
    }
    return pixel;
}
