#version 460
#pragma program(Pyramid)
// The pyramid of front and back depths, all levels in one dispatch. A workgroup makes a tile of
// 64 x 64 pixels and everything above it up to one cell. A thread makes 8 x 8 pixels and up to level 3 alone, in strips; above,
// the threads meet in shared memory, and nothing depends on the subgroup's size. CPU twin: reference::unified.
//
// A pixel is a block from its own depth to T behind it (docs/definitions.md, "Oracle", item 3). With
// reversed depth, d + k = (1 + k) near / z is proportional to 1 / z, and no view depth is needed:
//   |z - z'| / z = |d' - d| / (d' + k),   d(z + T) = (d - k q) / (1 + q),   q = T / z.
// The differences of nearby depths are exact, so nothing cancels at any distance. If rays of sight are parallel, depth itself
// is proportional to z, and T is a difference of depths.

layout(local_size_x = 8, local_size_y = 8) in;

#include "common/sight.glsl"
#include "unified/pyramid.glsl"

layout(binding = 1) uniform sampler2D depth_buffer; // reversed; 0 is sky
layout(binding = 2, rg32f) uniform writeonly image2D pyramid;

#define NOTHING 1e30 // the span to a neighbour that is sky or off screen

// The tile's cells, as in the image: level n from row CellRow(n) on. Levels don't share rows, so that one
// barrier a level is enough.
shared vec2 cells[16][8];

int CellRow(int level) {
    return 16 - (128 >> level);
}

// 1 / (d + k), or 1 if rays of sight are parallel; negative for sky.
float Reciprocal(float depth) {
    precise float offset = ORTHOGRAPHIC ? 1.0 : depth + unified.depth_offset;
    return depth > 0.0 ? 1.0 / offset : -1.0;
}

float Span(float depth, float neighbour, float reciprocal) {
    precise float span = abs(depth - neighbour) * reciprocal;
    return reciprocal > 0.0 ? span : NOTHING;
}

// Front and back of a pixel; each neighbour with its Reciprocal.
vec2 Block(float depth, vec2 left, vec2 right, vec2 up, vec2 down) {
    float x = min(Span(depth, left.x, left.y), Span(depth, right.x, right.y));
    float y = min(Span(depth, up.x, up.y), Span(depth, down.x, down.y));
    x = x < NOTHING ? x : 0.0;
    y = y < NOTHING ? y : 0.0;
    if (ORTHOGRAPHIC) {
        precise float least = SHARE_OF_DEPTH * (unified.reach * unified.depth_offset);
        precise float behind = depth - ((x + y) + least);
        return depth > 0.0 ? vec2(depth, behind) : EMPTY_BLOCK;
    }
    precise float thickness = (x + y) + SHARE_OF_DEPTH;
    precise float scale = 1.0 / (1.0 + thickness);
    precise float back = (depth - unified.depth_offset * thickness) * scale;
    return depth > 0.0 ? vec2(depth, back) : EMPTY_BLOCK;
}

vec2 Union(vec2 a, vec2 b) {
    return vec2(max(a.x, b.x), min(a.y, b.y));
}

void Store(ivec2 cell, int level, vec2 block) {
    if (level <= unified.top_level && all(lessThan(cell, unified.padded >> level)))
        imageStore(pyramid, CellTexel(cell, level), vec4(block, 0.0, 0.0));
}

// Depth and Reciprocal of two rows of four pixels: two of a strip, and one beyond on each side.
struct Rows {
    vec2 upper[4];
    vec2 lower[4];
};

// Two by two pixels, the first at p; sky beyond the image.
void Fetch(ivec2 p, out vec2 upper_left, out vec2 upper_right, out vec2 lower_left, out vec2 lower_right) {
    // Where the four meet: no rounding can reach another texel.
    vec4 d = textureGather(depth_buffer, vec2(p + 1) / vec2(unified.size));
    bvec2 low = lessThan(uvec2(p), uvec2(unified.size)), high = lessThan(uvec2(p + 1), uvec2(unified.size));
    d = mix(vec4(0.0), d, bvec4(low.x && high.y, high.x && high.y, high.x && low.y, low.x && low.y));
    upper_left = vec2(d.w, Reciprocal(d.w));
    upper_right = vec2(d.z, Reciprocal(d.z));
    lower_left = vec2(d.x, Reciprocal(d.x));
    lower_right = vec2(d.y, Reciprocal(d.y));
}

Rows FetchRows(ivec2 p) {
    Rows rows;
    Fetch(p, rows.upper[0], rows.upper[1], rows.lower[0], rows.lower[1]);
    Fetch(p + ivec2(2, 0), rows.upper[2], rows.upper[3], rows.lower[2], rows.lower[3]);
    return rows;
}

// The block of a pixel, to its place in the pyramid.
vec2 Pixel(ivec2 pixel, float depth, vec2 left, vec2 right, vec2 up, vec2 down) {
    vec2 block = Block(depth, left, right, up, down);
    Store(pixel, 0, block);
    return block;
}

// Four pixels, the first of which is `pixel`, and the cell above them. They are in the middle of the lower row of `above` and of
// the upper row of `below`.
vec2 Quad(ivec2 pixel, Rows above, Rows below) {
    vec2 row[4] = above.lower, next[4] = below.upper;
    vec2 top = Union(Pixel(pixel, row[1].x, row[0], row[2], above.upper[1], next[1]),
                     Pixel(pixel + ivec2(1, 0), row[2].x, row[1], row[3], above.upper[2], next[2]));
    vec2 bottom = Union(Pixel(pixel + ivec2(0, 1), next[1].x, next[0], next[2], row[1], below.lower[1]),
                        Pixel(pixel + 1, next[2].x, next[1], next[3], row[2], below.lower[2]));
    vec2 cell = Union(top, bottom);
    Store(pixel >> 1, 1, cell);
    return cell;
}

// A strip of 2 x 8 pixels from the one at p: what is above its upper and its lower half. A strip is as narrow as it can be, and
// a loop goes down along it, so that a thread holds few pixels at a time.
vec2[2] Strip(ivec2 p) {
    vec2 upper_half = EMPTY_BLOCK, cell = EMPTY_BLOCK;
    Rows above = FetchRows(p - 1);
    for (int row = 0; row < 8; row += 2) {
        Rows below = FetchRows(p + ivec2(-1, row + 1));
        vec2 own = Quad(p + ivec2(0, row), above, below);
        upper_half = row == 4 ? cell : upper_half;
        cell = row == 4 ? own : Union(cell, own);
        above = below;
    }
    return vec2[2](upper_half, cell);
}

void main() {
    ivec2 local = ivec2(gl_LocalInvocationID.xy);
    ivec2 tile = ivec2(gl_WorkGroupID.xy);
    ivec2 p = 64 * tile + 8 * local;
    vec2 cell = EMPTY_BLOCK;
    for (int x = 0; x < 8; x += 4) {
        vec2 left[2] = Strip(p + ivec2(x, 0)), right[2] = Strip(p + ivec2(x + 2, 0));
        for (int half_row = 0; half_row < 2; ++half_row) {
            vec2 sixteen = Union(left[half_row], right[half_row]);
            Store((p + ivec2(x, 4 * half_row)) >> 2, 2, sixteen);
            cell = Union(cell, sixteen);
        }
    }
    Store(p >> 3, 3, cell);
    cells[local.y][local.x] = cell;
    for (int level = 4; level <= unified.top_level; ++level) {
        int side = 64 >> level;
        barrier();
        if (all(lessThan(local, ivec2(side)))) {
            ivec2 below = ivec2(2 * local.x, CellRow(level - 1) + 2 * local.y);
            vec2 upper = Union(cells[below.y][below.x], cells[below.y][below.x + 1]);
            cell = Union(upper, Union(cells[below.y + 1][below.x], cells[below.y + 1][below.x + 1]));
            cells[CellRow(level) + local.y][local.x] = cell;
            Store(side * tile + local, level, cell);
        }
    }
}
