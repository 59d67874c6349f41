#version 460
#pragma program(Pyramid)
// Makes the pyramid of front and back depths, all levels in one dispatch. A workgroup makes a tile of 64 x 64 pixels
// and all levels above it, up to one cell. A thread makes 8 x 8 pixels, and their levels up to level 3, alone and strip
// by strip. Above level 3 the threads exchange cells in shared memory, and nothing depends on the subgroup's size. CPU
// twin: reference::unified.
//
// A pixel is a block from its own depth to T behind it (docs/definitions.md, "Oracle", item 3). With
// reversed depth, d + k = (1 + k) near / z is proportional to 1 / z, and no view depth is needed:
//   |z - z'| / z = |d' - d| / (d' + k),   d(z + T) = (d - k q) / (1 + q),   q = T / z.
// The differences of nearby depths are exact, so nothing cancels at any distance. If rays of sight are parallel, depth itself
// is proportional to z, and T is a difference of depths.

#extension GL_EXT_control_flow_attributes : require

layout(local_size_x = 8, local_size_y = 8) in;

#include "common/sight.glsl"
#include "unified/pyramid.glsl"

layout(binding = 1) uniform sampler2D depth_buffer; // reversed; 0 is sky
layout(binding = 2, rg32f) uniform writeonly image2D pyramid;

#define NOTHING 1e30 // the span to a neighbour that is sky or off screen

// The tile's cells of levels 3 to 6, which have 8, 4, 2 and 1 rows; level n begins at row CellRow(n). Levels share no
// rows, so that one barrier a level is enough.
shared vec2 cells[16][8];

// The first row of `cells` that holds cells of a level: 0, 8, 12 and 14 for the levels 3 to 6.
int CellRow(int level) {
    return 16 - (128 >> level);
}

// Choices are made by mix(), which does not branch: SwiftShader of Chromium 156 uses up all memory when it compiles a
// loop with many branches. Loops are marked `dont_unroll`, since drivers would unroll loops without branches, and then
// hold all pixels at once. The condition of each loop stands at its end. If it stood at the beginning, lavapipe would
// run the body once too often (findings/lavapipe-runs-a-loop-once-more.sh).

// 1 / (d + k), or 1 if rays of sight are parallel; negative for sky.
float Reciprocal(float depth) {
    precise float offset = mix(depth + unified.depth_offset, 1.0, ORTHOGRAPHIC);
    return mix(-1.0, 1.0 / offset, depth > 0.0);
}

// How far behind a pixel its neighbour stands, as a share of the pixel's own view depth, or in depth if rays of sight
// are parallel; negative if the neighbour stands before the pixel.
float DepthBehind(float depth, vec2 neighbour) {
    precise float behind = (depth - neighbour.x) * neighbour.y;
    return mix(-NOTHING, behind, neighbour.y > 0.0);
}

// The span of a surface in depth across its pixel along an axis, from the neighbours on both sides. A surface that
// stands far before both neighbours is thinner than two pixels, and the neighbours say nothing of its span.
float DepthSpan(float depth, vec2 before, vec2 after) {
    precise float thin_limit = THIN * mix(1.0, unified.reach * unified.depth_offset, ORTHOGRAPHIC);
    float behind_before = DepthBehind(depth, before), behind_after = DepthBehind(depth, after);
    float span = min(abs(behind_before), abs(behind_after));
    return mix(0.0, span, all(bvec2(span < NOTHING, min(behind_before, behind_after) <= thin_limit)));
}

// Front and back of a pixel of a depth. The neighbours are pairs of a depth and its Reciprocal.
vec2 DepthBlock(float depth, vec2 left, vec2 right, vec2 up, vec2 down) {
    float x = DepthSpan(depth, left, right), y = DepthSpan(depth, up, down);
    // `parallel` is the back if rays of sight are parallel. SHARE_OF_DEPTH is then a share of the reach.
    precise float least = SHARE_OF_DEPTH * (unified.reach * unified.depth_offset);
    precise float parallel = depth - ((x + y) + least);
    precise float thickness = (x + y) + SHARE_OF_DEPTH;
    precise float scale = 1.0 / (1.0 + thickness);
    precise float back = (depth - unified.depth_offset * thickness) * scale;
    return mix(EMPTY_BLOCK, vec2(depth, mix(back, parallel, ORTHOGRAPHIC)), bvec2(depth > 0.0));
}

// The smallest block (front, back) that contains two blocks.
vec2 Union(vec2 a, vec2 b) {
    return vec2(max(a.x, b.x), min(a.y, b.y));
}

// Stores a cell. A cell beyond the border or the levels is written outside of the image, where a write has no effect
// (Vulkan, "Texel Output Coordinate Validation"). Branches would take an execution mask for each write.
void StoreCell(ivec2 cell, int level, vec2 block) {
    bool inside = all(bvec3(level <= unified.top_level, lessThan(cell, unified.padded >> level)));
    imageStore(pyramid, mix(ivec2(-1), CellTexel(cell, level), bvec2(inside)), vec4(block, 0.0, 0.0));
}

// Depth and Reciprocal of two rows of four pixels: the two pixels of a strip, and one pixel beyond on each side. The
// rows are vectors, since an array would not be held in registers.
struct Rows {
    vec4 upper_depth, upper_reciprocal;
    vec4 lower_depth, lower_reciprocal;
};

// The depths of 2 x 2 pixels from `first` on, in the order of textureGather; sky beyond the image.
vec4 FetchDepths(ivec2 first) {
    // The coordinates are those of the corner where the four texels meet, so that no rounding can reach another texel.
    vec4 depths = textureGather(depth_buffer, vec2(first + 1) / vec2(unified.size));
    bvec2 low = lessThan(uvec2(first), uvec2(unified.size)), high = lessThan(uvec2(first + 1), uvec2(unified.size));
    return mix(vec4(0.0), depths, bvec4(low.x && high.y, high.x && high.y, high.x && low.y, low.x && low.y));
}

vec4 Reciprocals(vec4 depths) {
    return vec4(Reciprocal(depths.x), Reciprocal(depths.y), Reciprocal(depths.z), Reciprocal(depths.w));
}

// Fetches two rows of four pixels, from `first` on.
Rows FetchRows(ivec2 first) {
    vec4 left = FetchDepths(first), right = FetchDepths(first + ivec2(2, 0));
    vec4 upper = vec4(left.wz, right.wz), lower = vec4(left.xy, right.xy);
    return Rows(upper, Reciprocals(upper), lower, Reciprocals(lower));
}

// Makes the block of a pixel, and stores it at its place in the pyramid.
vec2 BuildPixel(ivec2 pixel, float depth, vec2 left, vec2 right, vec2 up, vec2 down) {
    vec2 block = DepthBlock(depth, left, right, up, down);
    StoreCell(pixel, 0, block);
    return block;
}

// Depth and Reciprocal of pixel x of the upper row; LowerPixel returns those of the lower row.
vec2 UpperPixel(Rows rows, int x) {
    return vec2(rows.upper_depth[x], rows.upper_reciprocal[x]);
}

vec2 LowerPixel(Rows rows, int x) {
    return vec2(rows.lower_depth[x], rows.lower_reciprocal[x]);
}

// Makes 2 x 2 pixels, the first of which is `pixel`, and their cell of level 1, which it returns. The pixels are the
// two middle ones in the lower row of `above` and in the upper row of `below`.
vec2 BuildQuad(ivec2 pixel, Rows above, Rows below) {
    vec2 first = LowerPixel(above, 1), second = LowerPixel(above, 2);
    vec2 third = UpperPixel(below, 1), fourth = UpperPixel(below, 2);
    vec2 top = Union(BuildPixel(pixel, first.x, LowerPixel(above, 0), second, UpperPixel(above, 1), third),
                     BuildPixel(pixel + ivec2(1, 0), second.x, first, LowerPixel(above, 3), UpperPixel(above, 2), fourth));
    vec2 bottom = Union(BuildPixel(pixel + ivec2(0, 1), third.x, UpperPixel(below, 0), fourth, first, LowerPixel(below, 1)),
                        BuildPixel(pixel + 1, fourth.x, third, UpperPixel(below, 3), second, LowerPixel(below, 2)));
    vec2 cell = Union(top, bottom);
    StoreCell(pixel >> 1, 1, cell);
    return cell;
}

// Makes a strip of 2 x 8 pixels from `first` on. Returns the block of its upper half (xy) and that of its
// lower half (zw). The strip is as narrow as possible, and a loop goes down along it, so that a thread holds few pixels
// at a time.
vec4 BuildStrip(ivec2 first) {
    vec2 upper_half = EMPTY_BLOCK, cell = EMPTY_BLOCK;
    Rows above = FetchRows(first - 1);
    int row = 0;
    [[dont_unroll]] do {
        Rows below = FetchRows(first + ivec2(-1, row + 1));
        vec2 quad_cell = BuildQuad(first + ivec2(0, row), above, below);
        upper_half = mix(upper_half, cell, bvec2(row == 4));
        cell = mix(Union(cell, quad_cell), quad_cell, bvec2(row == 4));
        above = below;
        row += 2;
    } while (row < 8);
    return vec4(upper_half, cell);
}

void main() {
    ivec2 local = ivec2(gl_LocalInvocationID.xy);
    ivec2 tile = ivec2(gl_WorkGroupID.xy);
    ivec2 first_pixel = 64 * tile + 8 * local;
    vec2 cell = EMPTY_BLOCK;
    int x = 0;
    [[dont_unroll]] do {
        vec4 left = BuildStrip(first_pixel + ivec2(x, 0)), right = BuildStrip(first_pixel + ivec2(x + 2, 0));
        vec2 upper = Union(left.xy, right.xy), lower = Union(left.zw, right.zw);
        StoreCell((first_pixel + ivec2(x, 0)) >> 2, 2, upper);
        StoreCell((first_pixel + ivec2(x, 4)) >> 2, 2, lower);
        cell = Union(cell, Union(upper, lower));
        x += 4;
    } while (x < 8);
    StoreCell(first_pixel >> 3, 3, cell);
    cells[local.y][local.x] = cell;
    for (int level = 4; level <= unified.top_level; ++level) {
        int side = 64 >> level;
        barrier();
        if (all(lessThan(local, ivec2(side)))) {
            ivec2 below = ivec2(2 * local.x, CellRow(level - 1) + 2 * local.y);
            vec2 upper = Union(cells[below.y][below.x], cells[below.y][below.x + 1]);
            cell = Union(upper, Union(cells[below.y + 1][below.x], cells[below.y + 1][below.x + 1]));
            cells[CellRow(level) + local.y][local.x] = cell;
            StoreCell(side * tile + local, level, cell);
        }
    }
}
