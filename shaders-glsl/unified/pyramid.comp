#version 460
// The pyramid of front and back depths, all levels in one dispatch. A workgroup makes a tile of
// 64 x 64 pixels and everything above it up to one cell; its threads meet in shared memory, and
// nothing depends on the subgroup's size. CPU twin: reference::unified.
//
// A pixel is a block from its own depth to T behind it (DEFINITIONS, "Oracle", item 3). With
// reversed depth, d + k = (1 + k) near / z is proportional to 1 / z, and no view depth is needed:
//   |z - z'| / z = |d' - d| / (d' + k),   d(z + T) = (d - k q) / (1 + q),   q = T / z.
// The differences of nearby depths are exact, so nothing cancels at any distance.

layout(local_size_x = 16, local_size_y = 16) in;

#include "unified/parameters.glsl"
#include "unified/pyramid.glsl"

layout(binding = 1) uniform sampler2D depth_buffer; // reversed; 0 is sky
layout(binding = 2, rg32f) uniform writeonly image2D pyramid;

#define SHARE_OF_DEPTH 0.004
#define NOTHING 1e30 // the span to a neighbour that is sky or off screen

shared vec2 cells[16][16];

float Depth(ivec2 p) {
    bool inside = all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, unified.size));
    float depth = texelFetch(depth_buffer, clamp(p, ivec2(0), unified.size - 1), 0).r;
    return inside ? depth : 0.0;
}

// 1 / (d + k); negative for sky.
float Reciprocal(float depth) {
    precise float offset = depth + unified.depth_offset;
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

vec2 At(ivec2 p) {
    float depth = Depth(p);
    return vec2(depth, Reciprocal(depth));
}

// Four pixels and the cell above them.
vec2 Quad(ivec2 p) {
    vec2 d00 = At(p), d10 = At(p + ivec2(1, 0)), d01 = At(p + ivec2(0, 1)), d11 = At(p + ivec2(1, 1));
    vec2 b00 = Block(d00.x, At(p + ivec2(-1, 0)), d10, At(p + ivec2(0, -1)), d01);
    vec2 b10 = Block(d10.x, d00, At(p + ivec2(2, 0)), At(p + ivec2(1, -1)), d11);
    vec2 b01 = Block(d01.x, At(p + ivec2(-1, 1)), d11, d00, At(p + ivec2(0, 2)));
    vec2 b11 = Block(d11.x, d01, At(p + ivec2(2, 1)), d10, At(p + ivec2(1, 2)));
    Store(p, 0, b00);
    Store(p + ivec2(1, 0), 0, b10);
    Store(p + ivec2(0, 1), 0, b01);
    Store(p + ivec2(1, 1), 0, b11);
    vec2 cell = Union(Union(b00, b10), Union(b01, b11));
    Store(p >> 1, 1, cell);
    return cell;
}

void main() {
    ivec2 local = ivec2(gl_LocalInvocationID.xy);
    ivec2 tile = ivec2(gl_WorkGroupID.xy);
    ivec2 p = 64 * tile + 4 * local;
    vec2 top = Union(Quad(p), Quad(p + ivec2(2, 0)));
    vec2 bottom = Union(Quad(p + ivec2(0, 2)), Quad(p + ivec2(2, 2)));
    vec2 cell = Union(top, bottom);
    Store(p >> 2, 2, cell);
    cells[local.y][local.x] = cell;
    for (int level = 3; level <= unified.top_level; ++level) {
        int side = 64 >> level;
        bool mine = all(lessThan(local, ivec2(side)));
        barrier();
        if (mine) {
            ivec2 p = 2 * local;
            cell = Union(Union(cells[p.y][p.x], cells[p.y][p.x + 1]), Union(cells[p.y + 1][p.x], cells[p.y + 1][p.x + 1]));
        }
        barrier();
        if (mine) {
            cells[local.y][local.x] = cell;
            Store(side * tile + local, level, cell);
        }
    }
}
