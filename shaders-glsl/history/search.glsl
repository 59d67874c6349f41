// Finds where the frame before showed the point that a pixel reflects, and the history there. Each stage says by
// SEARCH_LOOP whether loops over four pixels are unrolled.

#ifndef COMMON_HISTORY_SEARCH_GLSL
#define COMMON_HISTORY_SEARCH_GLSL

#include "history/guide.glsl"
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
    vec3 reflected_point;
    float inverse_distance; // the one that the guide of its history should have; 0 if unknown
    float power;            // of the lobe
};

// Whether a pixel of the frame before, whose point was `point_before`, showed the surface of the query.
bool ShowsSameSurface(ivec2 pixel, Guide guide, vec3 point_before, HistoryQuery query) {
    float off_plane = abs(dot(point_before - query.surface, query.normal));
    bool same_plane = off_plane < SAME_PLANE * Reach(point_before.z, history.clip_to_view_before);
    float facing = dot(guide.normal, query.normal), squared = dot(guide.normal, guide.normal);
    bool same_normal = facing * abs(facing) > SAME_NORMAL * SAME_NORMAL * squared;
    return guide.age > 0.0 && same_plane && same_normal && IsOnScreen(pixel);
}

// How well a pixel of the frame before fits a query, from 0 to 1. `lag` becomes how far the mirror directions of the
// frames in the pixel's average miss the reflected point.
float HistoryAgreement(ivec2 pixel, Guide guide, HistoryQuery query, out Lag lag) {
    vec3 point_before = Unproject(history.clip_to_view_before, vec2(pixel) + 0.5, guide.depth);
    float surface_agreement = ShowsSameSurface(pixel, guide, point_before, query) ? 1.0 : 0.0;
    // `direction_error` leads from the pixel's mirror direction to the direction in which the reflected point lies.
    vec3 to_reflected = query.reflected_point - point_before;
    vec3 mirrored = MirrorDirection(ViewDirection(point_before), guide.normal);
    vec3 direction_error = to_reflected * inversesqrt(max(dot(to_reflected, to_reflected), 1e-30)) - mirrored;
    // Where nothing moved, `lag_change` is 0. Each averaged frame's mirror direction missed the reflected point by some
    // offset v (Lag), and misses it by v + lag_change now. So the mean of v * v becomes that of (v + lag_change)^2.
    vec3 lag_change = (query.inverse_distance > 0.0 ? sqrt(query.power) : 0.0) * direction_error;
    vec3 lag_before = Tangents(mirrored) * guide.lag;
    lag = Lag(lag_before + lag_change, max(guide.lag_square + dot(2.0 * lag_before + lag_change, lag_change), 0.0));
    float lobe_error = 0.5 * query.power * dot(direction_error, direction_error);
    // The agreement falls with both errors: of the direction, in widths of the lobe, and of the distance.
    float distance_error = (guide.inverse_distance / max(query.inverse_distance, 1e-12) - 1.0) / SAME_DISTANCE;
    distance_error *= distance_error;
    float point_agreement = 1.0 / ((1.0 + lobe_error + lobe_error * lobe_error)
                                   * (1.0 + distance_error * distance_error));
    return query.inverse_distance > 0.0 ? surface_agreement * point_agreement : surface_agreement;
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
    vec2 first_pixel = floor(position), part = position - first_pixel;
    HistorySample sampled = NO_HISTORY;
    // Colours are loaded when nothing else of the guides is needed.
    vec4 weights = vec4(0.0);
    SEARCH_LOOP for (int i = 0; i < 4; ++i) {
        ivec2 next = ivec2(i & 1, i >> 1);
        ivec2 pixel = ivec2(first_pixel) + next;
        vec2 share = mix(1.0 - part, part, vec2(next));
        Guide guide = LoadGuide(pixel);
        Lag lag;
        float weight = share.x * share.y * HistoryAgreement(pixel, guide, query, lag);
        sampled.age += weight * guide.age;
        sampled.agreement += weight;
        sampled.lag.mean += weight * lag.mean;
        sampled.lag.square += weight * lag.square;
        weights = mix(weights, vec4(weight), equal(ivec4(i), ivec4(0, 1, 2, 3)));
    }
    SEARCH_LOOP for (int i = 0; i < 4; ++i) {
        ivec2 pixel = ivec2(first_pixel) + ivec2(i & 1, i >> 1);
        vec2 row_weights = i < 2 ? weights.xy : weights.zw;
        vec4 color = imageLoad(color_before, clamp(pixel, ivec2(0), history.size - 1));
        sampled.color += ((i & 1) == 0 ? row_weights.x : row_weights.y) * EncodeForMean(color);
    }
    float total_weight = sampled.agreement;
    Lag lag = Lag(sampled.lag.mean / total_weight, sampled.lag.square / total_weight);
    return total_weight > LEAST_SHARE
        ? HistorySample(sampled.color / total_weight, sampled.age / total_weight, total_weight, lag)
        : NO_HISTORY;
}

// The history of the pixel itself, for a frame in which nothing moved. The lag needs no change of basis, since it is
// along the pixel's own two Tangents.
HistorySample LoadHistoryAtRest(ivec2 pixel, Guide guide, HistoryQuery query) {
    vec3 point_before = Unproject(history.clip_to_view_before, vec2(pixel) + 0.5, guide.depth);
    HistorySample sampled = HistorySample(EncodeForMean(imageLoad(color_before, pixel)), guide.age, 1.0,
                                          Lag(vec3(guide.lag, 0.0), guide.lag_square));
    return ShowsSameSurface(pixel, guide, point_before, query) ? sampled : NO_HISTORY;
}

// The position in pixels at which a plane mirror, given by a point and a normal of any length, showed the reflected
// point of a query.
vec2 PlaneMirrorPosition(vec3 point, vec3 normal, HistoryQuery query) {
    float height_above_plane = dot(query.reflected_point - point, normal) / max(dot(normal, normal), 1e-30);
    return ProjectToPreviousPixels(query.reflected_point - 2.0 * height_above_plane * normal);
}

// Finds the offset, in pixels, from a pixel of the frame before to where the pixel's tangent plane, as a mirror,
// would have shown the reflected point of a query. False if the pixel showed another surface.
bool PlaneMirrorOffset(ivec2 pixel, HistoryQuery query, out vec2 offset) {
    Guide guide = LoadGuide(pixel);
    vec2 pixel_centre = vec2(pixel) + 0.5;
    vec3 point_before = Unproject(history.clip_to_view_before, pixel_centre, guide.depth);
    offset = PlaneMirrorPosition(point_before, guide.normal, query) - pixel_centre;
    return ShowsSameSurface(pixel, guide, point_before, query);
}

// The position, in pixels, at which a mirror, curved or not, showed the reflected point: where the offset of
// PlaneMirrorOffset is 0. At `on_surface` this offset leads to `in_plane`. The change of the offset from pixel to pixel
// tells how the mirror is curved, and one step of Newton's method finds where the offset is 0. If it does not change
// evenly around the pixel, for example because a map turns the normals, the result is `in_plane`.
vec2 CurvedMirrorPosition(vec2 on_surface, vec2 in_plane, HistoryQuery query) {
    vec2 offset = in_plane - on_surface;
    ivec2 pixel = ivec2(floor(on_surface));
    vec4 sums = vec4(0.0), differences = vec4(0.0); // of the offsets from both pixels along x in xy, along y in zw
    bool is_one_surface = true;
    SEARCH_LOOP for (int i = 0; i < 4; ++i) {
        bool is_along_y = i > 1, is_second = (i & 1) == 1;
        int shift = is_second ? BESIDE : -BESIDE;
        vec2 offset_there;
        bool shows = PlaneMirrorOffset(pixel + (is_along_y ? ivec2(0, shift) : ivec2(shift, 0)), query, offset_there);
        is_one_surface = is_one_surface && shows;
        vec4 offset_of_axis = is_along_y ? vec4(0.0, 0.0, offset_there) : vec4(offset_there, 0.0, 0.0);
        sums += offset_of_axis;
        differences += is_second ? offset_of_axis : -offset_of_axis;
    }
    mat2 change = mat2(differences / float(2 * BESIDE)); // of the offset, for each pixel along x and along y
    // If the offset changes evenly, the mean of each pair of pixels predicts the offset here.
    vec2 predicted_change = change * (on_surface - vec2(pixel) - 0.5);
    float prediction_error = max(distance(0.5 * sums.xy + predicted_change, offset),
                                 distance(0.5 * sums.zw + predicted_change, offset));
    float scale = determinant(change);
    bool is_even = is_one_surface && prediction_error < UNEVEN * max(length(offset), 1.0) && scale > LEAST_SHORTENING;
    // The inverse of `change` times the negated offset is `scaled_step / scale`.
    vec2 scaled_step = vec2(change[1].x * offset.y - change[1].y * offset.x,
                            change[0].y * offset.x - change[0].x * offset.y);
    return is_even ? on_surface + scaled_step / scale : in_plane;
}

#endif
