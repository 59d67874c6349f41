// One Hi-Z traversal for every direction. Needs parameters.glsl, pyramid.glsl, ray.glsl and
// `pyramid`. CPU twin: reference::unified.
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
    int code;        // HIT_*
    ivec2 pixel;     // that was hit
    vec2 position;   // continuous pixel coordinates, within that pixel
    float depth;     // reversed, of the ray there
    int steps;       // cells looked at
};

// As passes::PathCode.
#define HIT_NONE       0 // the pixel does not reflect
#define HIT_SURFACE    1
#define HIT_NOTHING    3 // it left the frustum
#define HIT_UNFINISHED 7 // out of steps, which cannot be; never a hit

// Forward steps: a pixel each at least, over both axes. Down: no more than up and the first level.
int MaxSteps() {
    return 2 * (unified.size.x + unified.size.y) + unified.top_level;
}

Hit Traverse(Ray ray) {
    Hit hit = Hit(HIT_NOTHING, ray.pixel, vec2(0.0), 0.0, 0);
    // Where a cell is left: by its far side in a direction that grows, else by its near side.
    ivec2 ahead = ivec2(greaterThan(ray.inverse, vec2(0.0)));

    // The first step leaves the starting pixel unseen.
    precise vec2 sides = (vec2(ahead) - 0.5) * ray.inverse;
    float entry = min(sides.x, sides.y);
    if (!(entry < ray.end))
        return hit;
    precise vec2 beside = floor(entry * ray.rate.xy + 0.5);
    ivec2 pixel = ray.pixel + ivec2(sides.x == entry ? 2 * ahead.x - 1 : int(beside.x),
                                    sides.y == entry ? 2 * ahead.y - 1 : int(beside.y));
    precise float entry_depth = ray.depth + entry * ray.rate.z;
    int level = 0;
    int rows = 2 * unified.padded.y;
    int bound = MaxSteps();

    while (hit.steps < bound) {
        ++hit.steps;
        ivec2 cell = pixel >> level;
        vec2 block = texelFetch(pyramid, ivec2(cell.x, cell.y + rows - (rows >> level)), 0).xy;
        ivec2 edge = (cell + ahead) << level;
        precise vec2 crossings = (vec2(edge - ray.pixel) - 0.5) * ray.inverse;
        float exit = min(crossings.x, crossings.y);
        float last = min(exit, ray.end);
        precise float exit_depth = ray.depth + last * ray.rate.z;
        bool meets = min(entry_depth, exit_depth) <= block.x && max(entry_depth, exit_depth) >= block.y;

        if (meets ? level == 0 : !(exit < ray.end)) {
            if (!meets)
                return hit;
            // The crossing with the front if it lies inside, else the point of entry.
            bool crosses = min(entry_depth, exit_depth) <= block.x && max(entry_depth, exit_depth) >= block.x;
            precise float crossing = (block.x - ray.depth) * (1.0 / ray.rate.z);
            float s = crosses && entry_depth != exit_depth ? clamp(crossing, entry, max(entry, last)) : entry;
            precise vec2 offset = s * ray.rate.xy + 0.5;
            precise float depth = ray.depth + s * ray.rate.z;
            vec2 low = vec2(pixel - ray.pixel);
            hit.code = HIT_SURFACE;
            hit.pixel = pixel;
            hit.position = vec2(ray.pixel) + clamp(offset, low, low + 1.0);
            hit.depth = depth;
            return hit;
        }

        // Onward: across the side that is nearer, exactly; beside it, to the pixel that the ray is in
        // there, which is in the same cell.
        precise vec2 inside = floor(last * ray.rate.xy + 0.5);
        ivec2 first = cell << level;
        ivec2 onward = clamp(ray.pixel + ivec2(inside), first, first + (1 << level) - 1);
        onward.x = crossings.x == exit ? edge.x - 1 + ahead.x : onward.x;
        onward.y = crossings.y == exit ? edge.y - 1 + ahead.y : onward.y;
        ivec2 differs = onward ^ pixel;
        bool left_parent = ((differs.x | differs.y) >> (level + 1)) != 0;

        level = meets ? level - 1 : left_parent ? min(level + 1, unified.top_level) : level;
        pixel = meets ? pixel : onward;
        entry = meets ? entry : exit;
        entry_depth = meets ? entry_depth : exit_depth;
    }
    hit.code = HIT_UNFINISHED;
    return hit;
}
