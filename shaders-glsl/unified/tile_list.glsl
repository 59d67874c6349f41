// Which list a draw over tiles is for.

layout(push_constant) uniform TileListBlock {
    int list; // MIRROR_LIST or GLOSSY_LIST
} tile_list;
