// The one traversal of `unified`: a ray in an image of the scene, and its walk over the image's pyramid until it hits a
// pixel's block. The image is the screen, or, with FACES, the face `face_layer` of the captures (captures/faces.glsl);
// `unified` then is the block of a face. Needs the images `pyramid` and `normal_buffer`. CPU twin: reference::unified.

#ifndef UNIFIED_TRAVERSE_GLSL
#define UNIFIED_TRAVERSE_GLSL

#include "unified/pyramid.glsl"
#include "unified/trace/ray.glsl"

#ifdef FACES
#define FOLLOWED true
#define BLOCK_AT(texel) imageLoad(pyramid, ivec3(texel, face_layer)).xy
#define NORMAL_AT(pixel) imageLoad(normal_buffer, ivec3(pixel, face_layer)).xyz
#else
#define BLOCK_AT(texel) imageLoad(pyramid, texel).xy
#define NORMAL_AT(pixel) imageLoad(normal_buffer, pixel).xyz

layout(constant_id = 1) const int ORACLE = 1; // which version of the oracle says what is hit; 2 with FOLLOWED
layout(constant_id = 5) const bool FOLLOWED = false; // rays that the screen loses go on in captures or among triangles
#endif

// One walk serves every direction of a ray. The ray walks over cells of integer coordinates. The depth of the ray over
// a cell is an interval, whichever way the ray runs. If this interval misses the cell's [back, front], nothing in the
// cell can be hit, and the ray leaves the cell at once, in front of objects as well as behind them. Otherwise the walk
// goes down a level; in a pixel, the ray hits. The walk goes up a level if a step left the parent cell, since the cells
// before tell nothing about the next parent cell.
//
// Every step goes down a level or forward by a pixel or more, and goes up only with a step forward:
// MaxSteps bounds them all, so that no ray is ever cut off.

struct Hit {
    int code;        // PATH_HI_Z, PATH_MISS, PATH_MISS_BEHIND or PATH_UNFINISHED
    ivec2 pixel;     // that was hit
    vec2 position;   // continuous pixel coordinates, within that pixel
    float depth;     // reversed, of the ray there
    int steps;       // cells looked at
    float s;         // of the hit, or of where a miss ends
};

// The most steps of a walk. Each step forward goes over at least one pixel along an axis. Steps down are no more than
// the steps forward that also went up. A face adds the steps down from the level at which the walk begins, and one step
// for each pixel that is passed before a step forward.
int MaxSteps() {
#ifdef FACES
    return 3 * (unified.size.x + unified.size.y) + FACE_LEVEL;
#else
    return 2 * (unified.size.x + unified.size.y);
#endif
}

// The sum in the order of the CPU twin.
float Dot(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}

// The pixel from which a ray enters `pixel`: across the side that the ray crossed last. `ahead` is as Ahead returns it.
ivec2 PixelBefore(Ray ray, ivec2 pixel, ivec2 ahead) {
    precise vec2 entries = (vec2(pixel + 1 - ahead) - ray.start) * ray.inverse;
    ivec2 back = 1 - 2 * ahead;
    return pixel + ivec2(entries.x >= entries.y ? back.x : 0, entries.y >= entries.x ? back.y : 0);
}

// The test of version 2 of the oracle (reference::oracle), for a ray that enters a pixel behind the front of its block.
// If true, the ray passes behind the block and does not hit it. The test is true if the ray was behind the front of the
// pixel before. At an edge, it is also true if the ray is deeper in the block than the thickness times the cosine
// between the ray and the reversed normal. Sky has a negative thickness, so that its border with a surface always
// counts as an edge.
bool IsBehind(Ray ray, float entry_depth, ivec2 pixel, vec2 block, vec3 normal, ivec2 ahead) {
    vec2 block_before = BLOCK_AT(PixelTexel(PixelBefore(ray, pixel, ahead)));
    precise float thickness = block.x - block.y;
    precise float joined_gap = JOINED * (thickness + (block_before.x - block_before.y));
    precise float gap = block.x - block_before.x;
    float along_normal = Dot(ray.direction, normal);
    precise float depth_in_block = block.x - entry_depth;
    precise float depth_squared = (depth_in_block * depth_in_block)
                                * (Dot(normal, normal) * Dot(ray.direction, ray.direction));
    precise float limit_squared = (along_normal * along_normal) * (thickness * thickness);
    bool is_deep = along_normal >= 0.0 || depth_squared > limit_squared;
    return entry_depth < block_before.x || (gap > joined_gap && is_deep);
}

// The state of a walk.
struct Walk {
    ivec2 pixel;       // the pixel that the ray is in
    int level;         // of the cell that is looked at next; below 0 the pixel's block is met
    float entry;       // s at which the ray enters the pixel
    float entry_depth; // reversed depth there
    int steps;         // cells looked at
};

// Continues a walk until the ray meets a block or ends. With FOLLOWED, an image follows a ray only as long as it sees
// the ray. The ray then meets a block as soon as it is behind the block's front, and `passes` lets it through the pixel
// that it is in first.
//
// The loop holds nothing but the walk, and no branch but its end, since threads that walk together wait for each other
// in every branch that one of them takes. Parameters are read before the loop, and the block that was met after it,
// since the loop would repeat each read.
void Advance(Ray ray, ivec2 ahead, bool passes, inout Walk state) {
    Walk walk = state;
    bool recedes = ray.rate.z < 0.0;
    int strips = PyramidStrips();
    int top_level = unified.top_level;
    int max_steps = MaxSteps();
    vec2 start = ray.start;
    int border = unified.size.x - 1; // of a face, which is square
    ivec2 far_side = -ahead;     // all bits set where the ray leaves a cell by its far side
    ivec2 across = ahead - 1;    // from an edge to the pixel beyond it
    while (walk.level >= 0 && walk.entry < ray.end && walk.steps < max_steps) {
        ++walk.steps;
        ivec2 cell = walk.pixel >> walk.level;
        vec2 block = BLOCK_AT(StripTexel(cell, strips - (strips >> walk.level)));
        int size = 1 << walk.level;
        ivec2 first = walk.pixel & -size;
        ivec2 edge = first + (far_side & size);
        precise vec2 crossings = (vec2(edge) - start) * ray.inverse;
        bool leaves_x = crossings.x <= crossings.y;
        bool leaves_y = crossings.y <= crossings.x;
        float exit = min(crossings.x, crossings.y);
        float last_s = min(exit, ray.end);
        precise float exit_depth = ray.depth + last_s * ray.rate.z;
        float deepest = recedes ? exit_depth : walk.entry_depth;
        float nearest = recedes ? walk.entry_depth : exit_depth;
        bool meets = deepest <= block.x && (FOLLOWED ? !passes : nearest >= block.y);
        passes = false;

        // The next pixel lies exactly across the side that the ray crosses first. Along the other axis it is the pixel
        // in which the ray is there, within the cell.
        int first_other = leaves_x ? first.y : first.x;
        precise float other_position = (leaves_x ? start.y : start.x) + last_s * (leaves_x ? ray.rate.y : ray.rate.x);
        int other_coordinate = clamp(int(other_position), first_other, first_other + (size - 1));
#ifdef FACES
        // Rounding may move a ray that runs along a face's border beyond it, where no pixel is, before the ray ends.
        other_coordinate = min(other_coordinate, border);
#endif
        ivec2 next_pixel = ivec2(leaves_x ? edge.x + across.x : other_coordinate,
                                 leaves_y ? edge.y + across.y : other_coordinate);
        bool left_parent = ((leaves_x ? edge.x : edge.y) & size) == 0;
        walk.level = meets ? walk.level - 1 : left_parent ? min(walk.level + 1, top_level) : walk.level;
        walk.pixel = meets ? walk.pixel : next_pixel;
        walk.entry = meets ? walk.entry : exit;
        walk.entry_depth = meets ? walk.entry_depth : exit_depth;
    }
    state = walk;
}

// The s at which a ray leaves the pixel that it is in, or ends there.
float PixelExit(Ray ray, Walk walk, ivec2 ahead) {
    precise vec2 crossings = (vec2(walk.pixel + ahead) - ray.start) * ray.inverse;
    return max(min(min(crossings.x, crossings.y), ray.end), walk.entry);
}

// The s at which the ray crosses the front of the block of the pixel that it is in, if it does so inside the pixel;
// else the s at which it entered the pixel.
float FrontCrossing(Ray ray, Walk walk, ivec2 ahead, float front) {
    float exit = PixelExit(ray, walk, ahead);
    precise float exit_depth = ray.depth + exit * ray.rate.z;
    float near = max(walk.entry_depth, exit_depth), far = min(walk.entry_depth, exit_depth);
    precise float crossing = (front - ray.depth) * (1.0 / ray.rate.z);
    return far <= front && front <= near && far < near ? min(max(crossing, walk.entry), exit) : walk.entry;
}

// By which side along each axis a ray leaves a cell: 1 for the far side, if the coordinate grows, 0 for the near side.
ivec2 Ahead(Ray ray) {
    return ivec2(greaterThan(ray.inverse, vec2(0.0)));
}

#ifndef FACES

// Walks over the pyramid until the ray hits a block or ends. With FOLLOWED, a ray that passes wholly behind a block
// ends there, with the code PATH_MISS_BEHIND; without FOLLOWED the walk goes on.
Hit Traverse(Ray ray) {
    Hit hit = Hit(PATH_MISS, ray.pixel, vec2(0.0), 0.0, 0, ray.end);
    ivec2 ahead = Ahead(ray);

    // The first step leaves the ray's own pixel without a look at its block.
    precise vec2 sides = (vec2(ahead) - 0.5) * ray.inverse;
    float entry = min(sides.x, sides.y);
    if (!(entry < ray.end))
        return hit;
    precise vec2 at_side = ray.start + entry * ray.rate.xy;
    ivec2 pixel = ivec2(sides.x == entry ? ray.pixel.x + 2 * ahead.x - 1 : int(at_side.x),
                        sides.y == entry ? ray.pixel.y + 2 * ahead.y - 1 : int(at_side.y));
    precise float entry_depth = ray.depth + entry * ray.rate.z;
    // By version 2, the first pixel may show the surface that the ray leaves. The ray then enters this pixel at a depth
    // beyond all others, so that it meets nothing there.
    bool leaves_surface = ORACLE == 2 && Dot(ray.direction, NORMAL_AT(pixel)) > 0.0;
    if (leaves_surface && !FOLLOWED)
        entry_depth = ray.rate.z < 0.0 ? -NEVER : NEVER;
    Walk walk = Walk(pixel, 0, entry, entry_depth, 0);
    Advance(ray, ahead, leaves_surface, walk);
    hit.steps = walk.steps;
    hit.code = walk.entry < ray.end ? PATH_UNFINISHED : PATH_MISS;
    // The walk stops below level 0 in the pixel whose block the ray hit.
    if (walk.level < 0) {
        vec2 block = BLOCK_AT(PixelTexel(walk.pixel));
        float s = FrontCrossing(ray, walk, ahead, block.x);
        precise vec2 offset = s * ray.rate.xy + 0.5;
        precise float depth = ray.depth + s * ray.rate.z;
        vec2 first_corner = vec2(walk.pixel - ray.pixel);
        hit.code = PATH_HI_Z;
        hit.pixel = walk.pixel;
        hit.position = vec2(ray.pixel) + clamp(offset, first_corner, first_corner + 1.0);
        hit.depth = depth;
        hit.s = s;
        bool is_behind = ORACLE == 2 && hit.steps > 1 && walk.entry_depth < block.x
            && IsBehind(ray, walk.entry_depth, walk.pixel, block, NORMAL_AT(walk.pixel), ahead);
        // A ray that lies wholly behind the block has not hit it.
        precise float exit_depth = ray.depth + PixelExit(ray, walk, ahead) * ray.rate.z;
        if (is_behind || (FOLLOWED && max(walk.entry_depth, exit_depth) < block.y)) {
            hit.code = PATH_MISS_BEHIND;
            hit.s = walk.entry;
        }
    }
    return hit;
}

// The code PATH_MISS_* of a ray that hit nothing (docs/definitions.md, "Oracle", item 5).
int MissCode(Ray ray) {
    precise vec2 pixel_offset = floor(ray.end * ray.rate.xy + 0.5);
    precise float depth = ray.depth + ray.end * ray.rate.z;
    ivec2 last_pixel = clamp(ray.pixel + ivec2(pixel_offset), ivec2(0), unified.size - 1);
    vec2 block = BLOCK_AT(PixelTexel(last_pixel));
    if (block.x >= block.y && depth < block.y)
        return PATH_MISS_BEHIND;
    ivec2 side = ivec2(greaterThan(ray.inverse, vec2(0.0))) * unified.size;
    precise vec2 sides = (vec2(side - ray.pixel) - 0.5) * ray.inverse;
    if (ray.end == min(sides.x, sides.y))
        return PATH_MISS_SCREEN;
    return ray.rate.z > 0.0 ? PATH_MISS_NEAR : PATH_MISS_SKY;
}

#endif

#endif
