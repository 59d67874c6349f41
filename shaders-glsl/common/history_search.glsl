// Finds where the frame before showed the point that a pixel reflects, and the history there. Each stage says by
// SEARCH_LOOP whether loops over four pixels are unrolled.

#ifndef COMMON_HISTORY_SEARCH_GLSL
#define COMMON_HISTORY_SEARCH_GLSL

#include "common/history_guide.glsl"
#include "common/lobe.glsl"
#include "common/sight.glsl"
#include "common/sound.glsl"

// A point of an earlier frame is on the same surface if the cosine between the normals is above SAME_NORMAL, and if the
// point lies off the plane by less than SAME_PLANE of its depth.
#define SAME_NORMAL 0.9
#define SAME_PLANE 0.02
// Least weight that pixels of the same surface must have among the four pixels around a place.
#define LEAST_SHARE 0.05
// A reflected point is taken to be as far away as it was, within this share.
#define SAME_DISTANCE 0.2
// CurvedMirrorPosition finds the curvature of a mirror from the pixels that lie BESIDE pixels away along each axis.
// They count if the offset that they predict in their middle is right within the share UNEVEN, and if the determinant
// of the offset's change from pixel to pixel is above LEAST_SHORTENING.
#define BESIDE 2
#define UNEVEN 0.25
#define LEAST_SHORTENING 0.25

float Luminance(vec3 color) {
    return dot(color, vec3(0.2126, 0.7152, 0.0722));
}

// Encodes a reflection so that means of it can be taken: its colour, black for a miss, and in a its luminance times its
// fade.
vec4 EncodeForMean(vec4 reflection) {
    vec3 color = Sound(reflection.rgb);
    return vec4(color, Luminance(color) * reflection.a);
}

// Decodes a mean of encoded reflections to a colour, and a fade in alpha.
vec4 DecodeMean(vec4 mean) {
    float whole = Luminance(mean.rgb);
    return vec4(Sound(mean.rgb), whole > 0.0 ? clamp(mean.a / whole, 0.0, 1.0) : 0.0);
}

// A pixel's surface and what it reflects, in the view space of the frame before.
struct HistoryQuery {
    vec3 surface;
    vec3 normal;
    vec3 end;      // the reflected point itself
    float inverse; // the Guide.inverse that its history should have; 0 if unknown
    float power;   // the lobe's power
};

// Whether a pixel of the frame before, whose point is `there`, showed the surface of the query.
bool ShowsSameSurface(ivec2 pixel, Guide guide, vec3 there, HistoryQuery query) {
    float off = abs(dot(there - query.surface, query.normal));
    bool same_plane = off < SAME_PLANE * Reach(there.z, history.clip_to_view_before);
    float facing = dot(guide.normal, query.normal), squared = dot(guide.normal, guide.normal);
    bool same_normal = facing * abs(facing) > SAME_NORMAL * SAME_NORMAL * squared;
    return guide.age > 0.0 && same_plane && same_normal && IsOnScreen(pixel);
}

// How well a pixel of the frame before fits a query, from 0 to 1. `lag` becomes how far the mirror directions of the
// frames in the pixel's average miss the reflected point.
float HistoryAgreement(ivec2 pixel, Guide guide, HistoryQuery query, out Lag lag) {
    vec3 there = Unproject(history.clip_to_view_before, vec2(pixel) + 0.5, guide.depth);
    float agrees = ShowsSameSurface(pixel, guide, there, query) ? 1.0 : 0.0;
    // `beside` leads from the pixel's mirror direction to the direction in which the reflected point lies.
    vec3 to = query.end - there;
    vec3 mirrored = MirrorDirection(ViewDirection(there), guide.normal);
    vec3 beside = to * inversesqrt(max(dot(to, to), 1e-30)) - mirrored;
    // Where nothing moved, `more` is 0. Each averaged frame's mirror direction missed the reflected point by some
    // offset v (Lag), and misses it by v + more now. So the mean of v * v becomes that of
    // v * v + 2 v * more + more * more.
    vec3 more = (query.inverse > 0.0 ? sqrt(query.power) : 0.0) * beside;
    vec3 before = Tangents(mirrored) * guide.lag;
    lag = Lag(before + more, max(guide.square + dot(2.0 * before + more, more), 0.0));
    float outside = 0.5 * query.power * dot(beside, beside);
    // The agreement falls with this offset in widths of the lobe, and if the pixel's reflected point was at another
    // distance.
    float nearer = (guide.inverse / max(query.inverse, 1e-12) - 1.0) / SAME_DISTANCE;
    nearer *= nearer;
    float known = 1.0 / ((1.0 + outside + outside * outside) * (1.0 + nearer * nearer));
    return query.inverse > 0.0 ? agrees * known : agrees;
}

// The agreement of the pixel at a position, in pixels of the frame before, with a query.
float HistoryAgreementAt(vec2 position, HistoryQuery query) {
    ivec2 pixel = ivec2(floor(position));
    Lag lag;
    return HistoryAgreement(pixel, LoadGuide(pixel), query, lag);
}

// A history that was found.
struct HistorySample {
    vec4 color; // encoded by EncodeForMean
    float age;
    float agreement; // the part of the history that agrees; 0 for none
    Lag lag;
};

const HistorySample NO_HISTORY = HistorySample(vec4(0.0), 0.0, 0.0, Lag(vec3(0.0), 0.0));

// The history that answers a query, between the four pixels around a position in pixels of the frame before.
HistorySample SampleHistory(vec2 position, HistoryQuery query) {
    position -= 0.5;
    vec2 first = floor(position), part = position - first;
    HistorySample sampled = NO_HISTORY;
    // Colours are loaded when nothing else of the guides is needed.
    vec4 weights = vec4(0.0);
    SEARCH_LOOP for (int i = 0; i < 4; ++i) {
        ivec2 next = ivec2(i & 1, i >> 1);
        ivec2 pixel = ivec2(first) + next;
        vec2 near = mix(1.0 - part, part, vec2(next));
        Guide guide = LoadGuide(pixel);
        Lag lag;
        float weight = near.x * near.y * HistoryAgreement(pixel, guide, query, lag);
        sampled.age += weight * guide.age;
        sampled.agreement += weight;
        sampled.lag.mean += weight * lag.mean;
        sampled.lag.square += weight * lag.square;
        weights = mix(weights, vec4(weight), equal(ivec4(i), ivec4(0, 1, 2, 3)));
    }
    SEARCH_LOOP for (int i = 0; i < 4; ++i) {
        ivec2 pixel = ivec2(first) + ivec2(i & 1, i >> 1);
        vec2 of_row = i < 2 ? weights.xy : weights.zw;
        vec4 color = imageLoad(color_before, clamp(pixel, ivec2(0), history.size - 1));
        sampled.color += ((i & 1) == 0 ? of_row.x : of_row.y) * EncodeForMean(color);
    }
    float whole = sampled.agreement;
    Lag lag = Lag(sampled.lag.mean / whole, sampled.lag.square / whole);
    return whole > LEAST_SHARE ? HistorySample(sampled.color / whole, sampled.age / whole, whole, lag) : NO_HISTORY;
}

// The history of the pixel itself, for a frame in which nothing moved. The lag needs no change of basis, since it is
// along the pixel's own two Tangents.
HistorySample LoadHistoryAtRest(ivec2 pixel, Guide guide, HistoryQuery query) {
    vec3 there = Unproject(history.clip_to_view_before, vec2(pixel) + 0.5, guide.depth);
    HistorySample sampled = HistorySample(EncodeForMean(imageLoad(color_before, pixel)), guide.age, 1.0,
                                          Lag(vec3(guide.lag, 0.0), guide.square));
    return ShowsSameSurface(pixel, guide, there, query) ? sampled : NO_HISTORY;
}

// The position in pixels at which a plane mirror, given by a point and a normal of any length, showed the reflected
// point of a query.
vec2 PlaneMirrorPosition(vec3 point, vec3 normal, HistoryQuery query) {
    float before_plane = dot(query.end - point, normal) / max(dot(normal, normal), 1e-30);
    return ProjectToPreviousPixels(query.end - 2.0 * before_plane * normal);
}

// Finds the offset `way`, in pixels, from a pixel of the frame before to where the pixel's tangent plane, as a mirror,
// would have shown the reflected point of a query. False if the pixel showed another surface.
bool PlaneMirrorOffset(ivec2 pixel, HistoryQuery query, out vec2 way) {
    Guide guide = LoadGuide(pixel);
    vec2 middle = vec2(pixel) + 0.5;
    vec3 there = Unproject(history.clip_to_view_before, middle, guide.depth);
    way = PlaneMirrorPosition(there, guide.normal, query) - middle;
    return ShowsSameSurface(pixel, guide, there, query);
}

// The position, in pixels, at which a mirror, curved or not, showed the reflected point: where the offset of
// PlaneMirrorOffset is 0. At `on_surface` this offset leads to `in_plane`. The change of the offset from pixel to pixel
// tells how the mirror is curved, and one step of Newton's method finds where the offset is 0. If it does not change
// evenly around the pixel, for example because a map turns the normals, the result is `in_plane`.
vec2 CurvedMirrorPosition(vec2 on_surface, vec2 in_plane, HistoryQuery query) {
    vec2 way = in_plane - on_surface;
    ivec2 pixel = ivec2(floor(on_surface));
    vec4 sums = vec4(0.0), differences = vec4(0.0); // of the ways from both pixels along x, and along y
    bool same = true;
    SEARCH_LOOP for (int i = 0; i < 4; ++i) {
        bool is_along_y = i > 1, is_behind = (i & 1) == 1;
        int offset = is_behind ? BESIDE : -BESIDE;
        vec2 from;
        bool shows = PlaneMirrorOffset(pixel + (is_along_y ? ivec2(0, offset) : ivec2(offset, 0)), query, from);
        same = same && shows;
        vec4 own = is_along_y ? vec4(0.0, 0.0, from) : vec4(from, 0.0, 0.0);
        sums += own;
        differences += is_behind ? own : -own;
    }
    mat2 change = mat2(differences / float(2 * BESIDE)); // of the way, for each pixel along x and along y
    // If the offset changes evenly, the mean of each pair of pixels predicts the offset here.
    vec2 more = change * (on_surface - vec2(pixel) - 0.5);
    float off = max(distance(0.5 * sums.xy + more, way), distance(0.5 * sums.zw + more, way));
    float shortens = determinant(change);
    bool is_even = same && off < UNEVEN * max(length(way), 1.0) && shortens > LEAST_SHORTENING;
    vec2 solved = vec2(change[1].x * way.y - change[1].y * way.x, change[0].y * way.x - change[0].x * way.y);
    return is_even ? on_surface + solved / shortens : in_plane;
}

#endif
