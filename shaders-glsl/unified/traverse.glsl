// The one traversal of `unified`: a ray in an image of the scene, and its walk over the image's pyramid until it hits a
// pixel's block. The image is the screen, or, with FACES, the face `face_layer` of the captures (captures/faces.glsl);
// `unified` then is the block of a face. Needs the images `pyramid` and `normal_buffer`. CPU twin: reference::unified.

#ifndef UNIFIED_TRAVERSE_GLSL
#define UNIFIED_TRAVERSE_GLSL

#include "unified/pyramid.glsl"

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

// A ray in the image: a straight line in (pixel x, pixel y, reversed depth), by a parameter s >= 0
// that counts pixels along the axis in which the ray moves faster.
//
// Divided by its view depth, the pixel's point has the clip image P = (ndc, depth, 1). A view-space
// direction d has D = (M_00 d_x, M_11 d_y, -k d_z, d_z), so that the exact derivative of the
// projected ray, (D.xyz P.w - P.xyz D.w) / P.w^2, is
//   (M_00 d_x - ndc.x d_z,  M_11 d_y - ndc.y d_z,  -(depth + k) d_z).
// The point at P + tD projects to P.xyz + s D' with s = t / (1 + t d_z). The six clip planes,
// |x|, |y| <= w and 0 <= z <= w, are the sides of a box there, and the near plane is met before
// w = 0: the homogeneous clip is a clip against the box, without its cancellation.

struct Ray {
    vec2 start;     // continuous pixel coordinates: the centre of a pixel of the screen, any place of a face
    ivec2 pixel;    // begins in this pixel
    float depth;    // reversed depth there
    vec3 rate;      // change of x, y and depth with s; max(|x|, |y|) is 1
    vec2 inverse;   // 1 / rate.xy; where that is infinite, so large that no edge is ever reached
    float end;      // s at which it leaves the frustum
    vec3 direction; // in view space, of any length; for version 2 of the oracle
};


// From a place in a pixel along a view-space direction that is a change of (ndc x, ndc y, depth), of any length. `end`
// is 0 for a ray that does not move in the image.
Ray MakeRay(vec2 start, ivec2 pixel, float depth, vec3 direction, vec3 change) {
    Ray ray;
    ray.start = start;
    ray.pixel = pixel;
    ray.depth = depth;
    ray.direction = direction;
    precise vec2 moved = change.xy * vec2(unified.size) * vec2(0.5, -0.5);
    float fastest = max(abs(moved.x), abs(moved.y));
    if (!(fastest > 1e-30)) {
        ray.rate = vec3(0.0);
        ray.inverse = vec2(NEVER);
        ray.end = 0.0;
        return ray;
    }
    precise float scale = 1.0 / fastest;
    precise vec2 rate = moved * scale;
    precise float depth_rate = change.z * scale;
    precise float depth_inverse = abs(depth_rate) > 1.0 / NEVER ? 1.0 / depth_rate : NEVER;
    precise vec2 inverse = vec2(abs(rate.x) > 1.0 / NEVER ? 1.0 / rate.x : NEVER,
                                abs(rate.y) > 1.0 / NEVER ? 1.0 / rate.y : NEVER);
    // The screen's sides by the expression of every cell's side (Traverse): a cell that ends
    // with the screen ends the ray to the bit.
    ivec2 side = ivec2(inverse.x > 0.0 ? unified.size.x : 0, inverse.y > 0.0 ? unified.size.y : 0);
    precise vec2 sides = (vec2(side) - start) * inverse;
    precise float plane = ((depth_inverse > 0.0 ? 1.0 : 0.0) - depth) * depth_inverse;
    ray.rate = vec3(rate, depth_rate);
    ray.inverse = inverse;
    ray.end = min(min(sides.x, sides.y), plane);
    return ray;
}

// The point of a pixel, divided by its view depth, as a view-space vector, and as ndc from the axis of the view.
void PixelPoint(ivec2 pixel, out vec3 view, out vec2 ndc) {
    precise vec2 centre = vec2(2 * pixel.x + 1 - unified.size.x, unified.size.y - 2 * pixel.y - 1) - unified.shift;
    precise vec2 v = centre * unified.pixel_to_view;
    precise vec2 c = centre * unified.pixel_to_clip;
    view = vec3(v, 1.0);
    ndc = c;
}

// Along a view-space direction of any length.
Ray RayAlong(ivec2 pixel, float depth, vec3 direction) {
    vec3 view;
    vec2 ndc;
    PixelPoint(pixel, view, ndc);
    precise vec2 change = unified.view_to_clip * direction.xy - ndc * direction.z;
    precise float change_z = -((depth + unified.depth_offset) * direction.z);
    return MakeRay(vec2(pixel) + 0.5, pixel, depth, direction, vec3(change, change_z));
}

// Along the mirror direction v + a n, a = -2 (v.n) / (n.n), of the direction v in which the pixel is
// seen, for a normal of any length. v itself projects to a point and drops out of the derivative:
// what remains has no difference of nearly equal numbers, however flat the ray meets the surface.
// `faces` is false where the pixel is seen from behind its normal: the ray goes below the surface.
Ray MirrorRay(ivec2 pixel, float depth, vec3 normal, out bool faces) {
    vec3 view;
    vec2 ndc;
    PixelPoint(pixel, view, ndc);
    precise float along = view.x * normal.x + view.y * normal.y + normal.z;
    precise float squared = normal.x * normal.x + normal.y * normal.y + normal.z * normal.z;
    precise float a = -2.0 * along * (1.0 / squared);
    precise vec2 change = (unified.view_to_clip * normal.xy - ndc * normal.z) * a;
    precise float change_z = -((depth + unified.depth_offset) * (1.0 + a * normal.z));
    precise vec3 direction = view + a * normal;
    faces = along < 0.0;
    return MakeRay(vec2(pixel) + 0.5, pixel, depth, direction, vec3(change, change_z));
}

// The walk, one for every direction. The ray walks over cells of integer coordinates. Over a cell its depth is an interval, whichever
// way it runs; where that misses the cell's [back, front], nothing in the cell can be hit and the
// ray leaves it at once, in front of objects as well as behind them. Otherwise it goes down a level;
// in a pixel, it hits. It goes up a level where a step left the parent cell, which the cells before
// have not spoken for.
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

// Forward: a pixel each at least, over both axes. Down: no more often than up; in a face also from the level at which it
// begins, and once for each pixel that is passed, which comes before a step forward.
int MaxSteps() {
#ifdef FACES
    return 3 * (unified.size.x + unified.size.y) + FACE_LEVEL;
#else
    return 2 * (unified.size.x + unified.size.y);
#endif
}

// In this order (the twin's).
float Dot(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}

// The pixel that a ray comes from as it enters another: across the boundary that it crossed last.
ivec2 PixelBefore(Ray ray, ivec2 pixel, ivec2 ahead) {
    precise vec2 entries = (vec2(pixel + 1 - ahead) - ray.start) * ray.inverse;
    ivec2 back = 1 - 2 * ahead;
    return pixel + ivec2(entries.x >= entries.y ? back.x : 0, entries.y >= entries.x ? back.y : 0);
}

// What version 2 of the oracle asks (reference::oracle): whether a ray that enters a pixel behind its block's front has
// come behind the block. It has behind the pixel before; and beside an edge, if it is deeper in the block than
// the thickness times the cosine by which it runs against the normal. Beside sky, whose span is negative, is an edge.
bool IsBehind(Ray ray, float entry_depth, ivec2 pixel, vec2 block, vec3 normal, ivec2 ahead) {
    vec2 before = BLOCK_AT(PixelTexel(PixelBefore(ray, pixel, ahead)));
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

// Where a walk is.
struct Walk {
    ivec2 pixel;       // that the ray is in
    int level;         // of the cell that is looked at next; below 0 the pixel's block is met
    float entry;       // s at which the ray enters the pixel
    float entry_depth; // reversed depth there
    int steps;         // cells looked at
};

// Walks on until a block is met or the ray ends. A ray that goes on in captures is followed only as long as the image sees
// it: it meets a block as soon as it is behind its front, and `passes` lets it through the pixel that it begins in.
//
// The loop holds nothing but the walk, and no branch but its end: threads that walk together wait for each other in
// every branch that one of them takes. Parameters are read before it, the block that was met after it: what is read or
// written in the loop is so as often as it runs.
void Advance(Ray ray, ivec2 ahead, bool passes, inout Walk w) {
    Walk walk = w;
    bool recedes = ray.rate.z < 0.0;
    int strips = PyramidStrips();
    int top_level = unified.top_level;
    int bound = MaxSteps();
    vec2 start = ray.start;
    int border = unified.size.x - 1; // of a face, which is square
    ivec2 far_side = -ahead;     // all bits where a cell's far side is its edge
    ivec2 across = ahead - 1;    // from an edge to the pixel beyond it
    while (walk.level >= 0 && walk.entry < ray.end && walk.steps < bound) {
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
        float last = min(exit, ray.end);
        precise float exit_depth = ray.depth + last * ray.rate.z;
        float deepest = recedes ? exit_depth : walk.entry_depth;
        float nearest = recedes ? walk.entry_depth : exit_depth;
        bool meets = deepest <= block.x && (FOLLOWED ? !passes : nearest >= block.y);
        passes = false;

        // Onward: across the side that is nearer, exactly; along the other axis, to the pixel that the ray
        // is in there, which is in the same cell.
        int low = leaves_x ? first.y : first.x;
        precise float inside = (leaves_x ? start.y : start.x) + last * (leaves_x ? ray.rate.y : ray.rate.x);
        int beside = clamp(int(inside), low, low + (size - 1));
#ifdef FACES
        // A ray along the border of a face may be rounded beyond it before it ends, where nothing stands.
        beside = min(beside, border);
#endif
        ivec2 onward = ivec2(leaves_x ? edge.x + across.x : beside, leaves_y ? edge.y + across.y : beside);
        bool left_parent = ((leaves_x ? edge.x : edge.y) & size) == 0;
        walk.level = meets ? walk.level - 1 : left_parent ? min(walk.level + 1, top_level) : walk.level;
        walk.pixel = meets ? walk.pixel : onward;
        walk.entry = meets ? walk.entry : exit;
        walk.entry_depth = meets ? walk.entry_depth : exit_depth;
    }
    w = walk;
}

// Where a ray leaves the pixel that it is in, or ends there: s.
float Exit(Ray ray, Walk walk, ivec2 ahead) {
    precise vec2 crossings = (vec2(walk.pixel + ahead) - ray.start) * ray.inverse;
    return max(min(min(crossings.x, crossings.y), ray.end), walk.entry);
}

// The crossing of the ray with the front of the pixel that it is in, if that lies inside the pixel, else the point
// of entry: s.
float Crossing(Ray ray, Walk walk, ivec2 ahead, float front) {
    float last = Exit(ray, walk, ahead);
    precise float exit_depth = ray.depth + last * ray.rate.z;
    float near = max(walk.entry_depth, exit_depth), far = min(walk.entry_depth, exit_depth);
    precise float crossing = (front - ray.depth) * (1.0 / ray.rate.z);
    return far <= front && front <= near && far < near ? min(max(crossing, walk.entry), last) : walk.entry;
}

// Where a cell is left: by its far side in a direction that grows, else by its near side.
ivec2 Ahead(Ray ray) {
    return ivec2(greaterThan(ray.inverse, vec2(0.0)));
}

#ifndef FACES

Hit Traverse(Ray ray) {
    Hit hit = Hit(PATH_MISS, ray.pixel, vec2(0.0), 0.0, 0, ray.end);
    ivec2 ahead = Ahead(ray);

    // The first step leaves the starting pixel unseen.
    precise vec2 sides = (vec2(ahead) - 0.5) * ray.inverse;
    float entry = min(sides.x, sides.y);
    if (!(entry < ray.end))
        return hit;
    precise vec2 at_side = ray.start + entry * ray.rate.xy;
    ivec2 pixel = ivec2(sides.x == entry ? ray.pixel.x + 2 * ahead.x - 1 : int(at_side.x),
                        sides.y == entry ? ray.pixel.y + 2 * ahead.y - 1 : int(at_side.y));
    precise float entry_depth = ray.depth + entry * ray.rate.z;
    // By version 2, the first pixel's surface may be the one that it leaves: from a depth beyond all, it meets nothing.
    bool leaves = ORACLE == 2 && Dot(ray.direction, NORMAL_AT(pixel)) > 0.0;
    if (leaves && !FOLLOWED)
        entry_depth = ray.rate.z < 0.0 ? -NEVER : NEVER;
    Walk walk = Walk(pixel, 0, entry, entry_depth, 0);
    Advance(ray, ahead, leaves, walk);
    hit.steps = walk.steps;
    hit.code = walk.entry < ray.end ? PATH_UNFINISHED : PATH_MISS;
    if (walk.level < 0) {
        vec2 block = BLOCK_AT(PixelTexel(walk.pixel));
        float s = Crossing(ray, walk, ahead, block.x);
        precise vec2 offset = s * ray.rate.xy + 0.5;
        precise float depth = ray.depth + s * ray.rate.z;
        vec2 low = vec2(walk.pixel - ray.pixel);
        hit.code = PATH_HI_Z;
        hit.pixel = walk.pixel;
        hit.position = vec2(ray.pixel) + clamp(offset, low, low + 1.0);
        hit.depth = depth;
        hit.s = s;
        bool is_behind = ORACLE == 2 && hit.steps > 1 && walk.entry_depth < block.x
            && IsBehind(ray, walk.entry_depth, walk.pixel, block, NORMAL_AT(walk.pixel), ahead);
        // Behind the block as a whole a ray that is not followed would go on.
        precise float exit_depth = ray.depth + Exit(ray, walk, ahead) * ray.rate.z;
        if (is_behind || (FOLLOWED && max(walk.entry_depth, exit_depth) < block.y)) {
            hit.code = PATH_MISS_BEHIND;
            hit.s = walk.entry;
        }
    }
    return hit;
}

// Which of MISS_* a ray is that hit nothing (docs/definitions.md, "Oracle", item 5).
int WhyMissed(Ray ray) {
    precise vec2 inside = floor(ray.end * ray.rate.xy + 0.5);
    precise float depth = ray.depth + ray.end * ray.rate.z;
    ivec2 last = clamp(ray.pixel + ivec2(inside), ivec2(0), unified.size - 1);
    vec2 block = BLOCK_AT(PixelTexel(last));
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
