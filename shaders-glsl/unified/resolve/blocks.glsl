// Blocks of 2 x 2 pixels or cells, which are shaded together.

#ifndef UNIFIED_BLOCKS_GLSL
#define UNIFIED_BLOCKS_GLSL

// From a block's pixel to the outside of the block, along each axis: 1 or -1.
ivec2 DirectionOutOfBlock(ivec2 texel) {
    return 2 * (texel & 1) - 1;
}

#endif
