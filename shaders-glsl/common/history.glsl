// Temporal filtering (thesis 4.2.11): the reflection of earlier frames, taken from where the reflected point was seen then, and
// averaged with that of this frame, over as many frames as what is reflected agrees (docs/definitions.md, "Histories").
//
// What a pixel reflects is known: its rays ended somewhere, on something that may move. The frame before shows the same point
// where its reflection was then, at another place of the surface. A pixel whose own reflection stays as it is, to the bit,
// keeps its history as it is. A mirror has no history: its one ray says all.

#ifndef COMMON_HISTORY_GLSL
#define COMMON_HISTORY_GLSL

#extension GL_EXT_control_flow_attributes : require

#include "common/constants.glsl"
#include "common/lobe.glsl"
#include "common/octahedral.glsl"
#include "common/sight.glsl"
#include "common/sound.glsl"

// A thing that moved since the frame before: the numbers of its triangles, and the way from this frame's view space to
// that of the frame before for what stands still on it.
struct MoverData {
    mat4 to_before;
    uvec4 triangles; // the first, and the one behind the last
};

// Filled in by src/passes/history.rs.
layout(std140, binding = 0) uniform HistoryBlock {
    mat4 clip_to_view;        // of this frame, reversed depth
    mat4 view_to_view_before; // from this frame's view space to that of the frame before
    mat4 view_to_clip_before; // of the frame before, reversed depth
    mat4 clip_to_view_before;
    vec2 resolution;          // pixels
    ivec2 size;               // the same
    vec2 beyond;              // BEYOND pixels outside of the last corner
    float unit;               // metres to one unit of a distance
    float frames;             // that are averaged at most while the camera moves
    float most;               // that are averaged at most now
    float deviations;         // standard deviations around the mean within which the history is kept
    int begins;               // 1: there is no frame before
    int has_ends;             // 1: `ends_image` is known
    int rests;                // 1: the frame before had this camera, or the same with its image shifted; 2: so had as many as are
                              // averaged, none of them shifted
    int repeats;              // 1: and the same directions of rays
    int mover_count;
    int may_move;             // 1: something may have moved since the frame before
    mat4 view_to_clip;        // of this frame, reversed depth
    vec2 motion_scale;        // of what motion_buffer holds to pixels
    vec2 motion_shift;        // pixels that are added to it
    MoverData movers[MOST_MOVERS];
} history;

layout(binding = 1) uniform sampler2D depth_buffer;      // reversed; 0 is sky
layout(binding = 2) uniform sampler2D normal_buffer;     // view space
layout(binding = 3, rgba16f) uniform readonly image2D reflection_buffer; // of this frame: colour, and fade in a
layout(binding = 4, rg16f) uniform readonly image2D material_buffer;     // reflectivity, roughness
layout(binding = 5, rgba16f) uniform readonly image2D color_before;      // Averaged of the frame before
layout(binding = 6, rgba32ui) uniform readonly uimage2D guide_before;
layout(binding = 7, rg32ui) uniform readonly uimage2D ends_image;     // where rays ended (unified/ends.glsl)
layout(binding = 8, r32ui) uniform readonly uimage2D triangle_buffer; // of each pixel; one texel where none is known
layout(binding = 9) uniform sampler2D color_buffer;                   // lit colour
layout(binding = 10) uniform sampler2D motion_buffer; // in red and green, the way to where a surface was seen; with MOTION

layout(constant_id = 0) const bool COMPOSITE = true; // the finished image is wanted
layout(constant_id = 1) const bool MOTION = false;   // motion_buffer is known

// What a pixel of the frame is.
struct Averaged {
    vec4 reflection; // colour, and fade in a
    uvec4 guide;     // Guide, packed
    vec4 color;      // lit colour + reflectivity * fade * reflection, where it is wanted
};

// A point of an earlier frame is the same surface if its normal is turned by less than this cosine, and it lies off the
// plane by less than this share of its depth.
#define SAME_NORMAL 0.9
#define SAME_PLANE 0.02
// Least weight that pixels of the same surface must have among the four pixels around a place.
#define LEAST_SHARE 0.05
// What is reflected is as far away as it was, within this share.
#define SAME_DISTANCE 0.2
// How a mirror is curved is asked of the pixels so far away along each axis. They count if the way at the place between them is, within
// this share, what they say of it, and if the product of how much of each pixel the way becomes shorter by along both axes is above that.
#define BESIDE 2
#define UNEVEN 0.25
#define LEAST_SHORTENING 0.25
// Bounds of a history's Lag: of the length of its mean, in standard deviations of the lobe, which are 1 / sqrt(alpha + 1) each, and of
// the mean of its square.
#define MOST_LAG 0.35
#define MOST_SQUARE 0.5
// The history may lie so many times as far from what the pixels around show where what is reflected is known to agree,
// and where nothing moves.
#define AGREED 4.0
#define AT_REST 8.0
// What is seen so many pixels from where a thing at rest would be seen stands still, and so much of the way farther, since
// 16-bit floats round motion by a quarter of that.
#define STILL 0.05
#define STILL_SHARE (1.0 / 512.0)
// A thing that moves is as far away as it was, within this share.
#define SAME_DEPTH 0.1
// The screen shows a reflected point where it shows something at its depth, within this share.
#define SHOWN 0.05

// Steps of a guide's ages to a frame, and of the root of a mean square from 0 to MOST_SQUARE.
#define AGE_STEPS 4.0
#define SQUARE_STEPS 63.0

// How far the frames that were averaged point past what is reflected, in standard deviations of the lobe.
struct Lag {
    vec3 mean;
    float square; // its mean
};

// What is kept of a pixel.
struct Guide {
    float depth;
    vec3 normal;   // view space, of any length
    float age;     // frames averaged; 0 for no history
    float inverse; // 1 / the way from the eye over the surface to what is reflected; 0 where that is not known
    vec2 lag;      // the mean of Lag along the two Tangents of the mirrored direction
    float square;  // that of Lag
};

// A byte of the mean lag replaces the last one of the depth, which is precise enough with 16 bits. The other stands in the last byte of
// the number that tells reflections apart.
uvec4 Pack(Guide g, uint alone) {
    uint depth = floatBitsToUint(g.depth) + 128u, lag = packSnorm4x8(vec4(g.lag / MOST_LAG, 0.0, 0.0));
    uint age = uint(min(g.age * AGE_STEPS + 0.5, 1023.0)), square = uint(min(sqrt(g.square / MOST_SQUARE), 1.0) * SQUARE_STEPS + 0.5);
    uint more = packHalf2x16(vec2(0.0, g.inverse)) | square << 10 | age;
    return uvec4((depth & ~255u) | (lag & 255u), packSnorm2x16(Octahedral(g.normal)), more, alone | (lag >> 8));
}

Guide Unpack(uvec4 words) {
    vec2 lag = MOST_LAG * unpackSnorm4x8((words.x & 255u) | (words.w & 255u) << 8).xy;
    float age = float(words.z & 1023u) / AGE_STEPS, root = float(words.z >> 10 & 63u) / SQUARE_STEPS;
    float depth = uintBitsToFloat(words.x & ~255u), inverse = unpackHalf2x16(words.z).y;
    return Guide(depth, AlongOctahedral(unpackSnorm2x16(words.y)), age, inverse, lag, MOST_SQUARE * root * root);
}

// A number of 24 bits that tells reflections apart; its last byte is zero.
uint Alone(vec4 reflection) {
    uint first = packHalf2x16(reflection.rg), second = packHalf2x16(reflection.ba);
    return (first * 0x9e3779b1u ^ second * 0x85ebca6bu) & ~255u;
}

float Luminance(vec3 color) {
    return dot(color, vec3(0.2126, 0.7152, 0.0722));
}

// A reflection in a form of which means may be taken: its colour, black for a miss, and in a the luminance that is left
// of it after its fade.
vec4 Linear(vec4 reflection) {
    vec3 color = Sound(reflection.rgb);
    return vec4(color, Luminance(color) * reflection.a);
}

vec4 FromLinear(vec4 mean) {
    float whole = Luminance(mean.rgb);
    return vec4(Sound(mean.rgb), whole > 0.0 ? clamp(mean.a / whole, 0.0, 1.0) : 0.0);
}

// By the few entries that the inverse of a projection has.
vec3 Unproject(mat4 m, vec2 position, float depth) {
    vec2 ndc = position / history.resolution * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    vec3 h = vec3(vec2(m[0].x, m[1].y) * ndc + m[2].xy * depth + m[3].xy, m[2].z * depth + m[3].z);
    return h / (m[2].w * depth + m[3].w);
}

// A pixel's surface and what it reflects, in the view space of the frame before.
struct Sought {
    vec3 surface;
    vec3 normal;
    vec3 end;      // the reflected point itself
    float inverse; // that of Guide which it should have; 0 if it is not known
    float power;   // of its lobe
};

bool IsOn(ivec2 pixel) {
    return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, history.size));
}

// Whether a pixel of the frame before, whose point is `there`, showed the surface that is sought.
bool ShowsSurface(ivec2 pixel, Guide guide, vec3 there, Sought sought) {
    float off = abs(dot(there - sought.surface, sought.normal));
    bool same_plane = off < SAME_PLANE * Reach(there.z, history.clip_to_view_before);
    float facing = dot(guide.normal, sought.normal), squared = dot(guide.normal, guide.normal);
    bool same_normal = facing * abs(facing) > SAME_NORMAL * SAME_NORMAL * squared;
    return guide.age > 0.0 && same_plane && same_normal && IsOn(pixel);
}

// How much of what a pixel of the frame before showed is what is sought, and how far its average points past that.
float Agrees(ivec2 pixel, Guide guide, Sought sought, out Lag lag) {
    vec3 there = Unproject(history.clip_to_view_before, vec2(pixel) + 0.5, guide.depth);
    float agrees = ShowsSurface(pixel, guide, there, sought) ? 1.0 : 0.0;
    vec3 to = sought.end - there;
    vec3 mirrored = MirrorDirection(Sight(there), guide.normal);
    vec3 beside = to * inversesqrt(max(dot(to, to), 1e-30)) - mirrored;
    // Nothing is added where nothing moved. If every averaged frame that pointed past by v now points past by v + more, the mean of the
    // square v * v becomes that of v * v + 2 v * more + more * more.
    vec3 more = (sought.inverse > 0.0 ? sqrt(sought.power) : 0.0) * beside;
    vec3 before = Tangents(mirrored) * guide.lag;
    lag = Lag(before + more, max(guide.square + dot(2.0 * before + more, more), 0.0));
    float outside = 0.5 * sought.power * dot(beside, beside);
    // How far away what it reflected was.
    float nearer = (guide.inverse / max(sought.inverse, 1e-12) - 1.0) / SAME_DISTANCE;
    nearer *= nearer;
    float known = 1.0 / ((1.0 + outside + outside * outside) * (1.0 + nearer * nearer));
    return sought.inverse > 0.0 ? agrees * known : agrees;
}

Guide GuideAt(ivec2 pixel) {
    return Unpack(imageLoad(guide_before, clamp(pixel, ivec2(0), history.size - 1)));
}

float AgreesAt(vec2 position, Sought sought) {
    ivec2 pixel = ivec2(floor(position));
    Lag lag;
    return Agrees(pixel, GuideAt(pixel), sought, lag);
}

// A history that was found.
struct Found {
    vec4 color; // Linear
    float age;
    float agreement; // the part of it that agrees; 0 for none
    Lag lag;
};

const Found NOTHING = Found(vec4(0.0), 0.0, 0.0, Lag(vec3(0.0), 0.0));

// What the frame before showed of what is sought, around a position in pixels.
Found At(vec2 position, Sought sought) {
    position -= 0.5;
    vec2 first = floor(position), part = position - first;
    Found found = NOTHING;
    // Colours are loaded once nothing else is needed of the guides.
    vec4 weights = vec4(0.0);
    [[dont_unroll]] for (int i = 0; i < 4; ++i) {
        ivec2 next = ivec2(i & 1, i >> 1);
        ivec2 pixel = ivec2(first) + next;
        vec2 near = mix(1.0 - part, part, vec2(next));
        Guide guide = GuideAt(pixel);
        Lag lag;
        float weight = near.x * near.y * Agrees(pixel, guide, sought, lag);
        found.age += weight * guide.age;
        found.agreement += weight;
        found.lag.mean += weight * lag.mean;
        found.lag.square += weight * lag.square;
        weights = mix(weights, vec4(weight), equal(ivec4(i), ivec4(0, 1, 2, 3)));
    }
    [[dont_unroll]] for (int i = 0; i < 4; ++i) {
        ivec2 pixel = ivec2(first) + ivec2(i & 1, i >> 1);
        vec2 of_row = i < 2 ? weights.xy : weights.zw;
        vec4 color = imageLoad(color_before, clamp(pixel, ivec2(0), history.size - 1));
        found.color += ((i & 1) == 0 ? of_row.x : of_row.y) * Linear(color);
    }
    float whole = found.agreement;
    Lag lag = Lag(found.lag.mean / whole, found.lag.square / whole);
    return whole > LEAST_SHARE ? Found(found.color / whole, found.age / whole, whole, lag) : NOTHING;
}

// Where a projection shows a point, in pixels; outside if it is behind the eye.
vec2 PositionBy(mat4 view_to_clip, vec3 seen) {
    vec4 clip = view_to_clip * vec4(seen, 1.0);
    vec2 position = (clip.xy / clip.w * vec2(0.5, -0.5) + 0.5) * history.resolution;
    return clip.w > 0.0 ? clamp(position, vec2(-BEYOND), history.beyond) : vec2(-BEYOND);
}

// Where a point was seen in the frame before.
vec2 Position(vec3 seen) {
    return PositionBy(history.view_to_clip_before, seen);
}

// Where a plane mirror with a point and a normal, of any length, shows what is sought.
vec2 InPlane(vec3 point, vec3 normal, Sought sought) {
    float before_plane = dot(sought.end - point, normal) / max(dot(normal, normal), 1e-30);
    return Position(sought.end - 2.0 * before_plane * normal);
}

// From a pixel of the frame before to where the plane that touches the surface there would have mirrored what is sought. False where
// the pixel showed another surface.
bool WayFrom(ivec2 pixel, Sought sought, out vec2 way) {
    Guide guide = GuideAt(pixel);
    vec2 middle = vec2(pixel) + 0.5;
    vec3 there = Unproject(history.clip_to_view_before, middle, guide.depth);
    way = InPlane(there, guide.normal, sought) - middle;
    return ShowsSurface(pixel, guide, there, sought);
}

// Where a mirror showed what is sought, curved or not: at the place whose own plane leads back to it. From `on_surface`, the plane
// there leads to `in_plane`. How this way changes from pixel to pixel says how the mirror is curved, and one step of Newton's method
// ends where no way is left. Where the pixels around tell of no such change, as where a map turns the normals, it is `in_plane`.
vec2 InMirror(vec2 on_surface, vec2 in_plane, Sought sought) {
    vec2 way = in_plane - on_surface;
    ivec2 pixel = ivec2(floor(on_surface));
    vec4 sums = vec4(0.0), differences = vec4(0.0); // of the ways from both pixels along x, and along y
    bool same = true;
    [[dont_unroll]] for (int i = 0; i < 4; ++i) {
        bool is_along_y = i > 1, is_behind = (i & 1) == 1;
        int offset = is_behind ? BESIDE : -BESIDE;
        vec2 from;
        bool shows = WayFrom(pixel + (is_along_y ? ivec2(0, offset) : ivec2(offset, 0)), sought, from);
        same = same && shows;
        vec4 own = is_along_y ? vec4(0.0, 0.0, from) : vec4(from, 0.0, 0.0);
        sums += own;
        differences += is_behind ? own : -own;
    }
    mat2 change = mat2(differences / float(2 * BESIDE)); // of the way, for each pixel along x and along y
    // Where the way changes evenly, both pairs say what it is here.
    vec2 more = change * (on_surface - vec2(pixel) - 0.5);
    float off = max(distance(0.5 * sums.xy + more, way), distance(0.5 * sums.zw + more, way));
    float shortens = determinant(change);
    bool is_even = same && off < UNEVEN * max(length(way), 1.0) && shortens > LEAST_SHORTENING;
    vec2 solved = vec2(change[1].x * way.y - change[1].y * way.x, change[0].y * way.x - change[0].x * way.y);
    return is_even ? on_surface + solved / shortens : in_plane;
}

// The mover that a triangle is of; -1 for what stands still.
int MoverOf(uint triangle) {
    int mover = -1;
    for (int i = 0; i < history.mover_count; ++i) {
        uvec2 range = history.movers[i].triangles.xy;
        mover = triangle >= range.x && triangle < range.y ? i : mover;
    }
    return mover;
}

// Where a point (w = 1) or a direction (w = 0) that goes along with a mover was, in the view space of the frame before.
vec3 Before(vec3 v, float w, int mover) {
    vec3 before = (history.view_to_view_before * vec4(v, w)).xyz;
    for (int i = 0; i < history.mover_count; ++i)
        before = mover == i ? (history.movers[i].to_before * vec4(v, w)).xyz : before;
    return before;
}

// Where a point of the surface that a pixel shows was in the view space of the frame before, by the motion that the caller
// knows. `seen` is where the point is seen now, `still` where it would have been at rest. The motion says where it was seen,
// but not how far away: as far as the frame before shows there, if a history of that is kept.
vec3 Moved(vec2 seen, ivec2 pixel, vec3 still) {
    vec2 way = texelFetch(motion_buffer, pixel, 0).xy * history.motion_scale + history.motion_shift;
    float beside = distance(seen + way, Position(still));
    vec2 before = clamp(seen + way, vec2(-BEYOND), history.beyond);
    ivec2 shows = ivec2(floor(before));
    float kept = IsOn(shows) ? GuideAt(shows).depth : 0.0;
    float shown = kept > 0.0 ? Unproject(history.clip_to_view_before, before, kept).z : still.z;
    float reach = SAME_DEPTH * Reach(still.z, history.clip_to_view_before);
    float z = clamp(shown, still.z - reach, still.z + reach);
    vec4 clip = history.view_to_clip_before * vec4(still.xy, z, 1.0);
    vec3 moved = Unproject(history.clip_to_view_before, before, clip.z / clip.w);
    // False for what is no number.
    bool moves = beside > STILL + STILL_SHARE * length(way);
    return moves && still.z > 0.0 ? moved : still;
}

// Where a reflected point was that may be of a thing that moves. The caller knows the motion of what the screen shows.
vec3 MovedEnd(vec3 end, vec3 still) {
    vec2 seen = PositionBy(history.view_to_clip, end);
    ivec2 pixel = ivec2(floor(seen));
    ivec2 inside = clamp(pixel, ivec2(0), history.size - 1);
    float depth = texelFetch(depth_buffer, inside, 0).r;
    float z = Unproject(history.clip_to_view, seen, depth).z;
    bool is_shown = IsOn(pixel) && depth > 0.0 && abs(z - end.z) < SHOWN * Reach(end.z, history.clip_to_view);
    return is_shown ? Moved(seen, inside, still) : still;
}

uint TriangleAt(ivec2 pixel) {
    return imageLoad(triangle_buffer, min(pixel, imageSize(triangle_buffer) - 1)).x;
}

// What a pixel adds to two sums over its block of 2 x 2, or these sums.
struct Sums {
    vec4 first;
    vec4 second;
};

// The sums over the pixels of a block. The stage has it; every pixel of a block asks for it.
Sums OverBlock(ivec2 pixel, Sums own);

// Keeps what a pixel needs at the end, while the search for its history needs the registers. The stage has both.
void SetAside(Sums values);
Sums TakenBack();

// From a block's pixel to the outside of the block, along each axis: 1 or -1.
vec2 OutwardOf(ivec2 pixel) {
    return vec2(2 * (pixel & 1) - 1);
}

// What the rays around a pixel met.
struct Ends {
    float away; // from the surface, metres; 0 if nothing is known
    int mover;  // that most of them met; -1 for what stands still
};

// What the ray of a pixel met, for the sums over its block; `eye` is how far the pixel's point is from the eye, negative if it does
// not reflect. First come inverse distances, by which images move, and how many: to what stands still, and to what moves. Second are
// the numbers of the movers, how many, and how many pixels reflect.
Sums HitsOf(ivec2 pixel, bool is_wide, float eye) {
    // The ray of a wide lobe is its cell's, so that the pixels of a block ask four cells.
    ivec2 asked = is_wide ? (pixel & ~1) + 2 * (pixel & 1) : pixel;
    uvec2 told = imageLoad(ends_image, min(asked, history.size - 1)).xy;
    float away = eye >= 0.0 && history.has_ends != 0 ? uintBitsToFloat(told.x) * history.unit : 0.0;
    int mover = MoverOf(told.y);
    vec2 one = away > 0.0 ? vec2(1.0 / (eye + away), 1.0) : vec2(0.0);
    vec4 hits = mover < 0 ? vec4(one, 0.0, 0.0) : vec4(0.0, 0.0, one);
    return Sums(hits, vec4(mover < 0 ? vec2(0.0) : vec2(float(mover), 1.0), eye >= 0.0 ? 1.0 : 0.0, 0.0));
}

Ends EndsAround(Sums hits, float eye) {
    bool moves = hits.first.w > hits.first.y;
    vec2 counted = moves ? hits.first.zw : hits.first.xy;
    int mover = moves ? int(hits.second.x / max(hits.second.y, 1.0) + 0.5) : -1;
    return Ends(counted.y > 0.5 ? counted.y / counted.x - eye : 0.0, mover);
}

// Frames that may be averaged, with this one, which does not lag, so that a measure of the lag is at most `most`.
float FramesWithin(float lag, float most) {
    return lag > most ? min(lag / (lag - most), history.most) : history.most;
}

// A pixel, which may stand beyond the border of the image with others of its block.
Averaged Average(ivec2 pixel) {
    ivec2 inside = min(pixel, history.size - 1);
    float depth = texelFetch(depth_buffer, inside, 0).r;
    vec2 material = imageLoad(material_buffer, inside).rg;
    vec3 normal = texelFetch(normal_buffer, inside, 0).xyz;
    float squared = dot(normal, normal);
    bool reflects = depth > 0.0 && material.r > REFLECTS_ABOVE && material.g > 0.0 && squared > NO_NORMAL;
    normal *= inversesqrt(max(squared, 1e-30));
    vec3 point = Unproject(history.clip_to_view, vec2(pixel) + 0.5, depth);
    float eye = ORTHOGRAPHIC ? 0.0 : length(point);
    Sums hits = OverBlock(pixel, HitsOf(pixel, material.g > WIDE_ABOVE, reflects ? eye : -1.0));
    Ends ends = EndsAround(hits, reflects ? eye : -1.0);
    float count = max(hits.second.z, 1.0);

    Sought sought;
    int own = MoverOf(TriangleAt(inside));
    sought.surface = Before(point, 1.0, own);
    if (MOTION && own < 0)
        sought.surface = Moved(vec2(pixel) + 0.5, inside, sought.surface);
    sought.normal = Before(normal, 0.0, own);
    sought.power = LobePower(material.g);
    bool known = ends.away > 0.0;
    float inverse = known ? 1.0 / (eye + ends.away) : 0.0;
    vec3 mirrored = MirrorDirection(Sight(point), normal);
    vec3 end = point + ends.away * mirrored;
    sought.end = Before(end, 1.0, ends.mover);
    if (MOTION && known && ends.mover < 0)
        sought.end = MovedEnd(end, sought.end);
    float eye_before = ORTHOGRAPHIC ? 0.0 : length(sought.surface);
    // Where nothing moves, what is reflected is what it was.
    bool may_differ = known && (history.rests == 0 || history.may_move != 0);
    sought.inverse = may_differ ? 1.0 / (eye_before + distance(sought.surface, sought.end)) : 0.0;
    SetAside(Sums(vec4(normal, depth), vec4(mirrored, inverse)));
    // On the surface itself, where nothing is known of what it reflects, or the mirror agrees less.
    vec2 place = Position(sought.surface);
    if (may_differ) {
        vec2 in_mirror = InMirror(place, InPlane(sought.surface, sought.normal, sought), sought);
        place = AgreesAt(in_mirror, sought) >= AgreesAt(place, sought) ? in_mirror : place;
    }
    Found found = At(place, sought);

    Sums own_values = TakenBack(); // normal and depth; mirrored direction and inverse
    // What the pixels of the block show.
    vec4 alone = imageLoad(reflection_buffer, inside);
    vec4 now = Linear(alone);
    vec4 own_sum = reflects ? now : vec4(0.0);
    Sums shows = OverBlock(pixel, Sums(own_sum, own_sum * own_sum));
    uint print = Alone(alone);
    uvec4 kept = imageLoad(guide_before, inside);
    bool stays = history.repeats != 0 && kept.z != 0u && (kept.w & ~255u) == print;
    // What changed by itself is not what it was.
    bool is_new = history.begins != 0 || (history.repeats != 0 && history.may_move == 0);
    float age = is_new ? 0.0 : found.age * found.agreement;
    vec4 mean = shows.first / count;
    float most = history.deviations * (!known || history.repeats != 0 ? 1.0 : history.rests != 0 ? AT_REST : AGREED);
    vec4 reach = most * sqrt(max(shows.second / count - mean * mean, vec4(0.0)));
    // What the pixel itself shows is as good as what is around it: so what stays as it is is not blurred.
    vec4 before = clamp(found.color, min(mean - reach, now), max(mean + reach, now));
    float within = min(FramesWithin(length(found.lag.mean), MOST_LAG), FramesWithin(found.lag.square, MOST_SQUARE));
    age = min(age + 1.0, within);
    // What is whole stays so while rays turn again for what a thing uncovered before it came to rest.
    bool is_whole = history.rests > 1 && history.may_move == 0 && !is_new && found.age > history.frames - 0.5;
    float part = is_whole ? 0.0 : 1.0 / age, left = 1.0 - part;
    vec4 mixed = FromLinear(mix(before, now, part));
    vec3 lag = found.lag.mean * mat3(history.view_to_view_before);
    vec4 shown = stays ? imageLoad(color_before, inside) : age > 1.0 ? mixed : alone;
    Averaged averaged;
    averaged.reflection = reflects ? shown : alone;
    vec2 across = left * lag * Tangents(own_values.second.xyz);
    Guide guide = Guide(own_values.first.w, own_values.first.xyz, age, own_values.second.w, across, left * found.lag.square);
    averaged.guide = !reflects ? uvec4(0u) : stays ? kept : Pack(guide, print);
    averaged.color = vec4(0.0);
    if (COMPOSITE) {
        vec3 lit = texelFetch(color_buffer, inside, 0).rgb;
        vec3 added = min(lit + material.r * averaged.reflection.a * averaged.reflection.rgb, vec3(GREATEST_HALF));
        averaged.color = vec4(material.r > REFLECTS_ABOVE ? added : lit, 1.0);
    }
    return averaged;
}

#endif
