// Which list a draw over tiles is for, and what it draws into.

layout(push_constant) uniform TileListBlock {
    int list;  // MIRROR_LIST, NARROW_LIST or WIDE_LIST
    int halve; // 1 where the targets have a texel for 2 x 2 pixels, else 0
} tile_list;
