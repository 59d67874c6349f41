// The parameters of every pass of `unified`: the camera, the image and its tiles, and rules for materials.

#ifndef UNIFIED_PARAMETERS_GLSL
#define UNIFIED_PARAMETERS_GLSL

#include "common/constants.glsl"
#include "common/sound.glsl"

#ifndef UNIFIED_BINDING
#define UNIFIED_BINDING 0
#endif

// Filled in by src/methods/unified.rs.
layout(std140, binding = UNIFIED_BINDING) uniform UnifiedBlock {
    vec2 view_to_clip;   // M_00 and M_11 of the projection
    vec2 pixel_to_clip;  // 1 / width and 1 / height
    vec2 pixel_to_view;  // pixel_to_clip / view_to_clip: half a pixel in metres, at z = 1 m with perspective
    ivec2 size;          // pixels
    ivec2 padded;        // pixels of the pyramid: whole cells of its coarsest level
    int top_level;       // the pyramid's coarsest level
    float depth_offset;  // near / (far - near), which is -M_22 with reversed depth; 1 / (far - near) without perspective
    float fade_start;    // I_start and I_end of Eq. 4.7
    float fade_end;
    int fade;            // 0: no fade at all
    vec2 shift;          // how far the image is shifted against the axis of the view, in half pixels: x to the right, y up
    int sky;             // 1: where sky is reflected, its colour is that of `environment` along the ray
    int turn;            // frames of a history before this one; 0 without one
    float depth_origin;  // reversed depth at z = 0 without perspective, which is M_23
    float reach;         // metres from the lower to the upper side of the image without perspective
} unified;

bool Reflects(vec2 material) {
    return material.x > REFLECTS_ABOVE;
}

// The list for a reflecting pixel's kind of reflector. The classification puts a tile on the list of each kind that the
// tile contains, and passes are drawn over the tiles of a list.
int TileListOf(vec2 material) {
    return material.y > WIDE_ABOVE ? WIDE_LIST : material.y > 0.0 ? NARROW_LIST : MIRROR_LIST;
}

ivec2 TileCount() {
    return (unified.size + TILE_SIDE - 1) / TILE_SIDE;
}

// Packs a tile's column and row into a word.
uint PackTile(uvec2 tile) {
    return tile.x | tile.y << 16;
}

ivec2 UnpackTile(uint word) {
    return ivec2(word & 0xffffu, word >> 16);
}

// Workgroups of a compute program along a side of a tile. `halved` is 1 where the images that the program writes have a
// texel for 2 x 2 pixels, else 0.
int GroupsPerTile(int halved) {
    return (TILE_SIDE >> halved) / GROUP_SIDE;
}

// One buffer holds the arguments of indirect draws and dispatches over the lists (passes::tiles): first of one draw for
// each list, then of two dispatches for each list, one for each value of `halved`. Each of the two functions below
// returns the index of the first word of a command.

// The words of a draw: vertices (one point for each tile), instances, first vertex, first instance.
int DrawArguments(int list) {
    return 4 * list;
}

// The words of a dispatch: workgroups of a tile, tiles in a row, and rows. None is more than every device takes.
int DispatchArguments(int list, int halved) {
    return 4 * LISTS + 3 * (2 * list + halved);
}

// The border fade of the thesis (4.2.9, Eq. 4.7) for a hit at texture coordinates.
float Fade(vec2 uv) {
    float boundary = length(uv - vec2(0.5)) * 2.0;
    float fade = 1.0 - clamp((boundary - unified.fade_start) / (unified.fade_end - unified.fade_start), 0.0, 1.0);
    return unified.fade != 0 ? fade : 1.0;
}

#endif
