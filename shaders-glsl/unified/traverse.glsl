// One Hi-Z traversal for every direction. Needs parameters.glsl, pyramid.glsl, normal.glsl, ray.glsl and the
// image `pyramid`. CPU twin: reference::unified.
//
// The ray walks over cells of integer coordinates. Over a cell its depth is an interval, whichever
// way it runs; where that misses the cell's [back, front], nothing in the cell can be hit and the
// ray leaves it at once, in front of objects as well as behind them. Otherwise it goes down a level;
// in a pixel, it hits. It goes up a level where a step left the parent cell, which the cells before
// have not spoken for.
//
// Every step goes down a level or forward by a pixel or more, and goes up only with a step forward:
// MaxSteps bounds them all, so that no ray is ever cut off.

struct Hit {
    int code;        // HIT_* or MISS_BEHIND
    ivec2 pixel;     // that was hit
    vec2 position;   // continuous pixel coordinates, within that pixel
    float depth;     // reversed, of the ray there
    int steps;       // cells looked at
};

// As passes::PathCode.
#define HIT_NONE       0 // the pixel does not reflect
#define HIT_SURFACE    1
#define HIT_NOTHING    3 // it left the frustum; WhyMissed tells more
#define HIT_UNFINISHED 7 // out of steps, which cannot be; never a hit
#define MISS_SCREEN    8 // it left by a side of the screen,
#define MISS_NEAR      9 // the near plane
#define MISS_SKY      10 // or the far plane, with nothing before it,
#define MISS_BEHIND   11 // or wherever, behind the back of a block; with oracle 2 also at a block, from behind

// reference::thickness.
#define JOINED 0.8

// Forward: a pixel each at least, over both axes. Down: no more often than up.
int MaxSteps() {
    return 2 * (unified.size.x + unified.size.y);
}

// In this order (the twin's).
float Dot(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}

// The pixel that a ray comes from as it enters another: across the boundary that it crossed last.
ivec2 PixelBefore(Ray ray, ivec2 pixel, ivec2 ahead) {
    precise vec2 entries = (vec2(pixel + 1 - ahead) - (vec2(ray.pixel) + 0.5)) * ray.inverse;
    ivec2 back = 1 - 2 * ahead;
    return pixel + ivec2(entries.x >= entries.y ? back.x : 0, entries.y >= entries.x ? back.y : 0);
}

// What version 2 of the oracle asks (reference::oracle): whether a ray that enters a pixel behind its block's front has
// come behind the block. It has behind the pixel before; and beside an edge, if it is deeper in the block than
// the thickness times the cosine by which it runs against the normal. Beside sky, whose span is negative, is an edge.
bool IsBehind(Ray ray, float entry_depth, ivec2 pixel, vec2 block, ivec2 ahead) {
    vec2 before = imageLoad(pyramid, PixelTexel(PixelBefore(ray, pixel, ahead))).xy;
    vec3 normal = Normal(pixel);
    precise float thickness = block.x - block.y;
    precise float joined = JOINED * (thickness + (before.x - before.y));
    precise float gap = block.x - before.x;
    float along = Dot(ray.direction, normal);
    precise float below = block.x - entry_depth;
    precise float depth_squared = (below * below) * (Dot(normal, normal) * Dot(ray.direction, ray.direction));
    precise float limit_squared = (along * along) * (thickness * thickness);
    bool is_deep = along >= 0.0 || depth_squared > limit_squared;
    return entry_depth < before.x || (gap > joined && is_deep);
}

Hit Traverse(Ray ray) {
    Hit hit = Hit(HIT_NOTHING, ray.pixel, vec2(0.0), 0.0, 0);
    // Where a cell is left: by its far side in a direction that grows, else by its near side.
    ivec2 ahead = ivec2(greaterThan(ray.inverse, vec2(0.0)));
    vec2 start = vec2(ray.pixel) + 0.5;

    // The first step leaves the starting pixel unseen.
    precise vec2 sides = (vec2(ahead) - 0.5) * ray.inverse;
    float entry = min(sides.x, sides.y);
    if (!(entry < ray.end))
        return hit;
    precise vec2 at_side = start + entry * ray.rate.xy;
    ivec2 pixel = ivec2(sides.x == entry ? ray.pixel.x + 2 * ahead.x - 1 : int(at_side.x),
                        sides.y == entry ? ray.pixel.y + 2 * ahead.y - 1 : int(at_side.y));
    precise float entry_depth = ray.depth + entry * ray.rate.z;
    bool recedes = ray.rate.z < 0.0;
    int level = 0;
    int strips = PyramidStrips();
    int top_level = unified.top_level;
    int bound = MaxSteps();
    ivec2 far_side = -ahead;     // all bits where a cell's far side is its edge
    ivec2 across = ahead - 1;    // from an edge to the pixel beyond it
    // By version 2, the first pixel's surface may be the one that it leaves: from a depth beyond all, it meets nothing.
    if (ORACLE == 2 && Dot(ray.direction, Normal(pixel)) > 0.0)
        entry_depth = recedes ? -NEVER : NEVER;

    // The loop holds nothing but the walk, and no branch but its end: threads that walk together wait
    // for each other in every branch that one of them takes. Parameters are read before it, the block that was hit
    // after it: what is read or written in the loop is so as often as it runs.
    while (level >= 0 && entry < ray.end && hit.steps < bound) {
        ++hit.steps;
        ivec2 cell = pixel >> level;
        vec2 block = imageLoad(pyramid, StripTexel(cell, strips - (strips >> level))).xy;
        int size = 1 << level;
        ivec2 first = pixel & -size;
        ivec2 edge = first + (far_side & size);
        precise vec2 crossings = (vec2(edge) - start) * ray.inverse;
        bool leaves_x = crossings.x <= crossings.y;
        bool leaves_y = crossings.y <= crossings.x;
        float exit = min(crossings.x, crossings.y);
        float last = min(exit, ray.end);
        precise float exit_depth = ray.depth + last * ray.rate.z;
        bool meets = (recedes ? exit_depth : entry_depth) <= block.x && (recedes ? entry_depth : exit_depth) >= block.y;

        // Onward: across the side that is nearer, exactly; along the other axis, to the pixel that the ray
        // is in there, which is in the same cell.
        int low = leaves_x ? first.y : first.x;
        precise float inside = (leaves_x ? start.y : start.x) + last * (leaves_x ? ray.rate.y : ray.rate.x);
        int beside = clamp(int(inside), low, low + (size - 1));
        ivec2 onward = ivec2(leaves_x ? edge.x + across.x : beside, leaves_y ? edge.y + across.y : beside);
        bool left_parent = ((leaves_x ? edge.x : edge.y) & size) == 0;
        level = meets ? level - 1 : left_parent ? min(level + 1, top_level) : level;
        pixel = meets ? pixel : onward;
        entry = meets ? entry : exit;
        entry_depth = meets ? entry_depth : exit_depth;
    }
    hit.code = entry < ray.end ? HIT_UNFINISHED : HIT_NOTHING;
    if (level < 0) {
        vec2 block = imageLoad(pyramid, PixelTexel(pixel)).xy;
        float front = block.x;
        // The crossing with the front if it lies inside the pixel, else the point of entry.
        precise vec2 crossings = (vec2(pixel + ahead) - start) * ray.inverse;
        float last = max(min(min(crossings.x, crossings.y), ray.end), entry);
        precise float exit_depth = ray.depth + last * ray.rate.z;
        float near = max(entry_depth, exit_depth), far = min(entry_depth, exit_depth);
        precise float crossing = (front - ray.depth) * (1.0 / ray.rate.z);
        float s = far <= front && front <= near && far < near ? min(max(crossing, entry), last) : entry;
        precise vec2 offset = s * ray.rate.xy + 0.5;
        precise float depth = ray.depth + s * ray.rate.z;
        vec2 low = vec2(pixel - ray.pixel);
        hit.code = HIT_SURFACE;
        hit.pixel = pixel;
        hit.position = vec2(ray.pixel) + clamp(offset, low, low + 1.0);
        hit.depth = depth;
        if (ORACLE == 2 && hit.steps > 1 && entry_depth < front && IsBehind(ray, entry_depth, pixel, block, ahead))
            hit.code = MISS_BEHIND;
    }
    return hit;
}

// Which of MISS_* a ray is that hit nothing (DEFINITIONS, "Oracle", item 5).
int WhyMissed(Ray ray) {
    precise vec2 inside = floor(ray.end * ray.rate.xy + 0.5);
    precise float depth = ray.depth + ray.end * ray.rate.z;
    ivec2 last = clamp(ray.pixel + ivec2(inside), ivec2(0), unified.size - 1);
    vec2 block = imageLoad(pyramid, PixelTexel(last)).xy;
    if (block.x >= block.y && depth < block.y)
        return MISS_BEHIND;
    ivec2 side = ivec2(greaterThan(ray.inverse, vec2(0.0))) * unified.size;
    precise vec2 sides = (vec2(side - ray.pixel) - 0.5) * ray.inverse;
    if (ray.end == min(sides.x, sides.y))
        return MISS_SCREEN;
    return ray.rate.z > 0.0 ? MISS_NEAR : MISS_SKY;
}
