#version 460
#pragma program(Pyramid)
// The pyramid of front and back depths, all levels in one dispatch. A workgroup makes a tile of
// 64 x 64 pixels and everything above it up to one cell. A thread makes 8 x 8 pixels and up to level 3 alone; above,
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

// Depth and Reciprocal of 4 x 4 pixels and those around them.
vec2 at[6][6];

// Two by two of them, the first at (x, y); sky beyond the image.
void Fetch(ivec2 first, int x, int y) {
    ivec2 p = first + ivec2(x, y);
    // Where the four meet: no rounding can reach another texel.
    vec4 d = textureGather(depth_buffer, vec2(p + 1) / vec2(unified.size));
    bvec2 low = lessThan(uvec2(p), uvec2(unified.size)), high = lessThan(uvec2(p + 1), uvec2(unified.size));
    d = mix(vec4(0.0), d, bvec4(low.x && high.y, high.x && high.y, high.x && low.y, low.x && low.y));
    at[y][x] = vec2(d.w, Reciprocal(d.w));
    at[y][x + 1] = vec2(d.z, Reciprocal(d.z));
    at[y + 1][x] = vec2(d.x, Reciprocal(d.x));
    at[y + 1][x + 1] = vec2(d.y, Reciprocal(d.y));
}

// The block of a pixel, from its place among those fetched, to its place in the pyramid.
vec2 Pixel(ivec2 first, int x, int y) {
    vec2 block = Block(at[y][x].x, at[y][x - 1], at[y][x + 1], at[y - 1][x], at[y + 1][x]);
    Store(first + ivec2(x, y), 0, block);
    return block;
}

// Four pixels and the cell above them.
vec2 Quad(ivec2 first, int x, int y) {
    vec2 top = Union(Pixel(first, x, y), Pixel(first, x + 1, y));
    vec2 bottom = Union(Pixel(first, x, y + 1), Pixel(first, x + 1, y + 1));
    vec2 cell = Union(top, bottom);
    Store((first + ivec2(x, y)) >> 1, 1, cell);
    return cell;
}

// 4 x 4 pixels from the one at p, and the cell above them.
vec2 Sixteen(ivec2 p) {
    ivec2 first = p - 1;
    Fetch(first, 0, 0);
    Fetch(first, 2, 0);
    Fetch(first, 4, 0);
    Fetch(first, 0, 2);
    Fetch(first, 2, 2);
    Fetch(first, 4, 2);
    Fetch(first, 0, 4);
    Fetch(first, 2, 4);
    Fetch(first, 4, 4);
    vec2 top = Union(Quad(first, 1, 1), Quad(first, 3, 1));
    vec2 cell = Union(top, Union(Quad(first, 1, 3), Quad(first, 3, 3)));
    Store(p >> 2, 2, cell);
    return cell;
}

void main() {
    ivec2 local = ivec2(gl_LocalInvocationID.xy);
    ivec2 tile = ivec2(gl_WorkGroupID.xy);
    ivec2 p = 64 * tile + 8 * local;
    vec2 top = Union(Sixteen(p), Sixteen(p + ivec2(4, 0)));
    vec2 cell = Union(top, Union(Sixteen(p + ivec2(0, 4)), Sixteen(p + 4)));
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
