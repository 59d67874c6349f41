// Temporal filtering (thesis 4.2.11) averages the reflection of this frame with those of earlier frames, over as many
// frames as the reflections agree (docs/definitions.md, "Histories"). The earlier reflection is taken from where the
// reflected point was seen then.
//
// The rays of a pixel tell which point it reflects, on a thing that may move. The frame before showed the reflection of
// the same point at another place of the surface. A pixel whose own reflection stays the same, to the bit, keeps its
// history as it is. A mirror needs no history, since its lobe is the one direction of its ray.

#ifndef COMMON_HISTORY_GLSL
#define COMMON_HISTORY_GLSL

#extension GL_EXT_control_flow_attributes : require

#include "common/constants.glsl"
#include "history/motion.glsl"
#include "history/search.glsl"
#include "common/lobe.glsl"
#include "common/sight.glsl"

// What a history makes of a pixel in this frame.
struct AccumulatedPixel {
    vec4 reflection; // colour, and fade in alpha
    uvec4 guide;     // Guide, packed
    vec4 color;      // lit colour + reflectivity * fade * reflection, where it is wanted
};

// Factors by which the history may lie farther from what the pixels around show: where the reflected point is known,
// and where the camera is at rest as well.
#define FACTOR_IF_KNOWN 4.0
#define FACTOR_AT_REST 8.0

// The summands of a pixel for two sums over its block of 2 x 2, or the sums themselves.
struct BlockSums {
    vec4 first;
    vec4 second;
};

// The sums over the pixels of a block. Each stage defines this function, and every pixel of a block calls it.
BlockSums SumOverBlock(ivec2 pixel, BlockSums own);

// SpillValues puts aside values that a pixel needs only after the search for its history, since the search needs the
// registers. ReloadValues returns these values. Each stage defines both functions.
void SpillValues(BlockSums values);
BlockSums ReloadValues();

// From a block's pixel to the outside of the block, along each axis: 1 or -1.
vec2 DirectionOutOfBlock(ivec2 pixel) {
    return vec2(2 * (pixel & 1) - 1);
}

// The mean of what the rays around a pixel met.
struct MeanHit {
    float hit_distance; // from the surface, metres; 0 if nothing is known
    int mover;          // the mover that these rays met; -1 if most of them met things at rest
};

// The summands of a pixel, from what its ray met, for the sums over its block. `eye_distance` is that of the pixel's
// point in metres, negative if the pixel does not reflect. `first` has the sum of the inverse distances from the eye to
// hits, and the number of these hits: in xy for objects at rest, in zw for movers. (A reflected image shifts by the
// inverse distance.) `second` has the sum of the movers' indices, the number of hits on movers, and the number of
// pixels that reflect.
BlockSums HitSummands(ivec2 pixel, bool has_wide_lobe, float eye_distance) {
    // A wide lobe has one ray for its cell of 2 x 2 pixels. So the four pixels of a block read the rays of four cells.
    ivec2 ray_pixel = has_wide_lobe ? (pixel & ~1) + 2 * (pixel & 1) : pixel;
    uvec2 ray_end = imageLoad(ends_image, min(ray_pixel, history.size - 1)).xy;
    float hit_distance = eye_distance >= 0.0 && history.has_ends != 0 ? uintBitsToFloat(ray_end.x) * history.unit : 0.0;
    int mover = FindMover(ray_end.y);
    vec2 counted_inverse = hit_distance > 0.0 ? vec2(1.0 / (eye_distance + hit_distance), 1.0) : vec2(0.0);
    vec4 hits = mover < 0 ? vec4(counted_inverse, 0.0, 0.0) : vec4(0.0, 0.0, counted_inverse);
    return BlockSums(hits, vec4(mover < 0 ? vec2(0.0) : vec2(float(mover), 1.0), eye_distance >= 0.0 ? 1.0 : 0.0, 0.0));
}

// The mean hit of a block, from the sums of HitSummands, for a pixel at a distance from the eye. If more rays met
// movers than objects at rest, only the hits on movers count. The mean of the hits' distances from the eye is harmonic.
// Rays that met several movers have a hit on none of them in the mean; the mover's index is then a mean, too.
MeanHit FindMeanHit(BlockSums hit_sums, float eye_distance) {
    bool is_on_mover = hit_sums.first.w > hit_sums.first.y;
    vec2 sum_and_count = is_on_mover ? hit_sums.first.zw : hit_sums.first.xy;
    int mover = is_on_mover ? int(hit_sums.second.x / max(hit_sums.second.y, 1.0) + 0.5) : -1;
    return MeanHit(sum_and_count.y > 0.5 ? sum_and_count.y / sum_and_count.x - eye_distance : 0.0, mover);
}

// The number of frames, with this one, that may be averaged so that a measure of the lag is at most `most_lag`. `lag`
// is this measure for the frames before. This frame does not lag, so that the lag of n frames is lag (1 - 1 / n).
float FramesWithinLag(float lag, float most_lag) {
    return lag > most_lag ? min(lag / (lag - most_lag), history.most) : history.most;
}

// The history of a pixel, whose surface and reflected point `query` gives in this frame's view space. `is_known` says
// whether the reflected point is known, and `reflected_mover` on which mover it lies (-1 for none).
HistorySample SearchHistory(ivec2 pixel, HistoryQuery query, bool is_known, int reflected_mover) {
    vec3 reflected_point = query.reflected_point;
    int own_mover = FindMover(TriangleAt(pixel));
    query.surface = ToPreviousView(query.surface, 1.0, own_mover);
    if (MOTION && own_mover < 0)
        query.surface = PreviousPointByMotion(vec2(pixel) + 0.5, pixel, query.surface);
    query.normal = ToPreviousView(query.normal, 0.0, own_mover);
    query.reflected_point = ToPreviousView(reflected_point, 1.0, reflected_mover);
    if (MOTION && is_known && reflected_mover < 0)
        query.reflected_point = PreviousReflectedPoint(reflected_point, query.reflected_point);
    float eye_distance = ORTHOGRAPHIC ? 0.0 : length(query.surface);
    query.inverse_distance = is_known ? 1.0 / (eye_distance + distance(query.surface, query.reflected_point)) : 0.0;
    // `place` is where the frame before showed the surface itself, or its reflection if that agrees as well or better.
    vec2 place = ProjectToPreviousPixels(query.surface);
    if (is_known) {
        vec2 mirrored_place = CurvedMirrorPosition(place, PlaneMirrorPosition(query.surface, query.normal, query),
                                                   query);
        place = HistoryAgreementAt(mirrored_place, query) >= HistoryAgreementAt(place, query) ? mirrored_place : place;
    }
    return SampleHistory(place, query);
}

// Makes the result of a pixel, which may stand beyond the border of the image with others of its block.
AccumulatedPixel AccumulatePixel(ivec2 pixel) {
    ivec2 image_pixel = min(pixel, history.size - 1);
    float depth = texelFetch(depth_buffer, image_pixel, 0).r;
    vec2 material = imageLoad(material_buffer, image_pixel).rg;
    vec3 normal = imageLoad(normal_buffer, image_pixel).xyz;
    float squared_length = dot(normal, normal);
    bool reflects = depth > 0.0 && material.r > REFLECTS_ABOVE && material.g > 0.0 && squared_length > NO_NORMAL;
    normal *= inversesqrt(max(squared_length, 1e-30));
    vec3 point = Unproject(history.clip_to_view, vec2(pixel) + 0.5, depth);
    float eye_distance = ORTHOGRAPHIC ? 0.0 : length(point);
    BlockSums hit_sums = SumOverBlock(pixel, HitSummands(pixel, material.g > WIDE_ABOVE,
                                                         reflects ? eye_distance : -1.0));
    MeanHit mean_hit = FindMeanHit(hit_sums, reflects ? eye_distance : -1.0);
    float reflecting_count = max(hit_sums.second.z, 1.0);
    bool is_known = mean_hit.hit_distance > 0.0;
    float inverse_distance = is_known ? 1.0 / (eye_distance + mean_hit.hit_distance) : 0.0;
    vec3 mirror_direction = MirrorDirection(ViewDirection(point), normal);
    SpillValues(BlockSums(vec4(normal, depth), vec4(mirror_direction, inverse_distance)));
    HistoryQuery query = HistoryQuery(point, normal, point + mean_hit.hit_distance * mirror_direction, 0.0,
                                      LobePower(material.g));
    HistorySample sampled;
    uvec4 own_guide; // the pixel's own guide of the frame before
    if (SEARCH) {
        sampled = SearchHistory(image_pixel, query, is_known, mean_hit.mover);
        own_guide = imageLoad(guide_before, image_pixel);
    } else {
        own_guide = imageLoad(guide_before, image_pixel);
        sampled = LoadHistoryAtRest(image_pixel, UnpackGuide(own_guide), query);
    }
    BlockSums own_values = ReloadValues(); // normal and depth; mirror direction and inverse distance
    // The sums of the colours of the block's pixels, and of their squares.
    vec4 unfiltered = imageLoad(reflection_buffer, image_pixel);
    vec4 current = EncodeForMean(unfiltered);
    vec4 color_summand = reflects ? current : vec4(0.0);
    BlockSums color_sums = SumOverBlock(pixel, BlockSums(color_summand, color_summand * color_summand));
    uint hash = ReflectionHash(unfiltered);
    bool is_unchanged = history.repeats != 0 && own_guide.z != 0u && (own_guide.w & ~255u) == hash;
    // A reflection that changed although nothing moved begins a new history.
    bool is_new = history.begins != 0 || (history.repeats != 0 && !SEARCH);
    float age = is_new ? 0.0 : sampled.age * sampled.agreement;
    vec4 mean = color_sums.first / reflecting_count;
    float allowed_deviations = history.deviations
        * (!is_known || history.repeats != 0 ? 1.0 : history.rests != 0 ? FACTOR_AT_REST : FACTOR_IF_KNOWN);
    vec4 allowed_range = allowed_deviations * sqrt(max(color_sums.second / reflecting_count - mean * mean, vec4(0.0)));
    // The history is clamped around the mean of the block. The bounds include what the pixel itself shows, so that a
    // reflection that does not change is not blurred.
    vec4 clamped_history = clamp(sampled.color, min(mean - allowed_range, current), max(mean + allowed_range, current));
    float frames_within_lag = min(FramesWithinLag(length(sampled.lag.mean), MOST_LAG),
                                  FramesWithinLag(sampled.lag.square, MOST_SQUARE));
    age = min(age + 1.0, frames_within_lag);
    // After a thing came to rest, frames go on being averaged for the surfaces that it uncovered. Histories that are
    // complete stay as they are meanwhile.
    bool is_complete = !SEARCH && history.rests > 1 && !is_new && sampled.age > history.frames - 0.5;
    float current_share = is_complete ? 0.0 : 1.0 / age, history_share = 1.0 - current_share;
    vec4 mixed = DecodeMean(mix(clamped_history, current, current_share));
    vec4 averaged = is_unchanged ? imageLoad(color_before, image_pixel) : age > 1.0 ? mixed : unfiltered;
    AccumulatedPixel accumulated;
    accumulated.reflection = reflects ? averaged : unfiltered;
    vec3 lag = sampled.lag.mean;
    vec2 tangent_lag = history_share
        * (SEARCH ? lag * mat3(history.view_to_view_before) * Tangents(own_values.second.xyz) : lag.xy);
    Guide guide = Guide(own_values.first.w, own_values.first.xyz, age, own_values.second.w, tangent_lag,
                        history_share * sampled.lag.square);
    accumulated.guide = !reflects ? uvec4(0u) : is_unchanged ? own_guide : PackGuide(guide, hash);
    accumulated.color = vec4(0.0);
    if (COMPOSITE) {
        vec3 lit = imageLoad(color_buffer, image_pixel).rgb;
        vec3 added = min(lit + material.r * accumulated.reflection.a * accumulated.reflection.rgb, vec3(GREATEST_HALF));
        accumulated.color = vec4(material.r > REFLECTS_ABOVE ? added : lit, 1.0);
    }
    return accumulated;
}

#endif
