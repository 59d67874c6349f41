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
#include "common/history_motion.glsl"
#include "common/history_search.glsl"
#include "common/lobe.glsl"
#include "common/sight.glsl"

// The result for a pixel of this frame.
struct AccumulatedPixel {
    vec4 reflection; // colour, and fade in alpha
    uvec4 guide;     // Guide, packed
    vec4 color;      // lit colour + reflectivity * fade * reflection, where it is wanted
};

// Factors by which the history may lie farther from what the pixels around show: AGREED where the reflected point is
// known, and AT_REST where nothing moves.
#define AGREED 4.0
#define AT_REST 8.0

// The summands of a pixel for two sums over its block of 2 x 2, or the sums themselves.
struct BlockSums {
    vec4 first;
    vec4 second;
};

// The sums over the pixels of a block. Each stage defines this function, and every pixel of a block calls it.
BlockSums SumOverBlock(ivec2 pixel, BlockSums own);

// SpillValues puts aside values that a pixel needs at the end, while the search for its history needs the registers,
// and ReloadValues returns them. Each stage defines both functions.
void SpillValues(BlockSums values);
BlockSums ReloadValues();

// From a block's pixel to the outside of the block, along each axis: 1 or -1.
vec2 DirectionOutOfBlock(ivec2 pixel) {
    return vec2(2 * (pixel & 1) - 1);
}

// What the rays around a pixel met.
struct MeanHit {
    float hit_distance; // from the surface, metres; 0 if nothing is known
    int mover;          // the mover that most of them met; -1 if most met things at rest
};

// The summands of a pixel, from what its ray met, for the sums over its block. `eye` is the distance of the pixel's
// point from the eye, negative if the pixel does not reflect. `first` has the sum of the inverse distances from the eye
// to hits, and the number of these hits: in xy for objects at rest, in zw for movers. (A reflected image shifts by the
// inverse distance.) `second` has the sum of the movers' indices, the number of hits on movers, and the number of pixels
// that reflect.
BlockSums HitSummands(ivec2 pixel, bool is_wide, float eye) {
    // A wide lobe has one ray for its cell of 2 x 2 pixels. So the four pixels of a block read the rays of four cells.
    ivec2 ray_pixel = is_wide ? (pixel & ~1) + 2 * (pixel & 1) : pixel;
    uvec2 ray_end = imageLoad(ends_image, min(ray_pixel, history.size - 1)).xy;
    float hit_distance = eye >= 0.0 && history.has_ends != 0 ? uintBitsToFloat(ray_end.x) * history.unit : 0.0;
    int mover = FindMover(ray_end.y);
    vec2 counted_inverse = hit_distance > 0.0 ? vec2(1.0 / (eye + hit_distance), 1.0) : vec2(0.0);
    vec4 hits = mover < 0 ? vec4(counted_inverse, 0.0, 0.0) : vec4(0.0, 0.0, counted_inverse);
    return BlockSums(hits, vec4(mover < 0 ? vec2(0.0) : vec2(float(mover), 1.0), eye >= 0.0 ? 1.0 : 0.0, 0.0));
}

// The mean hit of a block, from the sums of HitSummands, for a pixel at the distance `eye` from the eye. If more rays
// met movers than objects at rest, only the hits on movers count. The mean of the hits' distances from the eye is
// harmonic.
MeanHit FindMeanHit(BlockSums hit_sums, float eye) {
    bool moves = hit_sums.first.w > hit_sums.first.y;
    vec2 sum_and_count = moves ? hit_sums.first.zw : hit_sums.first.xy;
    int mover = moves ? int(hit_sums.second.x / max(hit_sums.second.y, 1.0) + 0.5) : -1;
    return MeanHit(sum_and_count.y > 0.5 ? sum_and_count.y / sum_and_count.x - eye : 0.0, mover);
}

// The number of frames, with this one, that may be averaged so that a measure of the lag is at most `most`. This frame
// does not lag, so that the lag of n frames is lag (1 - 1 / n).
float FramesWithinLag(float lag, float most) {
    return lag > most ? min(lag / (lag - most), history.most) : history.most;
}

// The history of a pixel, whose surface and reflected point `query` gives in this frame's view space. `known` says
// whether the reflected point is known, and `mover` which mover this point is on (-1 for none).
HistorySample SearchHistory(ivec2 pixel, HistoryQuery query, bool known, int mover) {
    vec3 end = query.end;
    int own = FindMover(TriangleAt(pixel));
    query.surface = ToPreviousView(query.surface, 1.0, own);
    if (MOTION && own < 0)
        query.surface = PreviousPointByMotion(vec2(pixel) + 0.5, pixel, query.surface);
    query.normal = ToPreviousView(query.normal, 0.0, own);
    query.end = ToPreviousView(end, 1.0, mover);
    if (MOTION && known && mover < 0)
        query.end = PreviousReflectedPoint(end, query.end);
    float eye = ORTHOGRAPHIC ? 0.0 : length(query.surface);
    query.inverse = known ? 1.0 / (eye + distance(query.surface, query.end)) : 0.0;
    // The place on the surface itself counts if the reflected point is not known, or if the place in the mirror agrees
    // less.
    vec2 place = ProjectToPreviousPixels(query.surface);
    if (known) {
        vec2 in_mirror = CurvedMirrorPosition(place, PlaneMirrorPosition(query.surface, query.normal, query), query);
        place = HistoryAgreementAt(in_mirror, query) >= HistoryAgreementAt(place, query) ? in_mirror : place;
    }
    return SampleHistory(place, query);
}

// Makes the result of a pixel, which may stand beyond the border of the image with others of its block.
AccumulatedPixel AccumulatePixel(ivec2 pixel) {
    ivec2 inside = min(pixel, history.size - 1);
    float depth = texelFetch(depth_buffer, inside, 0).r;
    vec2 material = imageLoad(material_buffer, inside).rg;
    vec3 normal = imageLoad(normal_buffer, inside).xyz;
    float squared = dot(normal, normal);
    bool reflects = depth > 0.0 && material.r > REFLECTS_ABOVE && material.g > 0.0 && squared > NO_NORMAL;
    normal *= inversesqrt(max(squared, 1e-30));
    vec3 point = Unproject(history.clip_to_view, vec2(pixel) + 0.5, depth);
    float eye = ORTHOGRAPHIC ? 0.0 : length(point);
    BlockSums hit_sums = SumOverBlock(pixel, HitSummands(pixel, material.g > WIDE_ABOVE, reflects ? eye : -1.0));
    MeanHit mean_hit = FindMeanHit(hit_sums, reflects ? eye : -1.0);
    float count = max(hit_sums.second.z, 1.0);
    bool known = mean_hit.hit_distance > 0.0;
    float inverse = known ? 1.0 / (eye + mean_hit.hit_distance) : 0.0;
    vec3 mirrored = MirrorDirection(ViewDirection(point), normal);
    SpillValues(BlockSums(vec4(normal, depth), vec4(mirrored, inverse)));
    HistoryQuery query = HistoryQuery(point, normal, point + mean_hit.hit_distance * mirrored, 0.0, LobePower(material.g));
    HistorySample sampled;
    uvec4 kept; // the pixel's own guide of the frame before
    if (SEARCH) {
        sampled = SearchHistory(inside, query, known, mean_hit.mover);
        kept = imageLoad(guide_before, inside);
    } else {
        kept = imageLoad(guide_before, inside);
        sampled = LoadHistoryAtRest(inside, UnpackGuide(kept), query);
    }
    BlockSums own_values = ReloadValues(); // normal and depth; mirrored direction and inverse
    // What the pixels of the block show.
    vec4 unfiltered = imageLoad(reflection_buffer, inside);
    vec4 now = EncodeForMean(unfiltered);
    vec4 summand = reflects ? now : vec4(0.0);
    BlockSums shows = SumOverBlock(pixel, BlockSums(summand, summand * summand));
    uint hash = ReflectionHash(unfiltered);
    bool stays = history.repeats != 0 && kept.z != 0u && (kept.w & ~255u) == hash;
    // A reflection that changed although nothing moved begins a new history.
    bool is_new = history.begins != 0 || (history.repeats != 0 && !SEARCH);
    float age = is_new ? 0.0 : sampled.age * sampled.agreement;
    vec4 mean = shows.first / count;
    float most = history.deviations * (!known || history.repeats != 0 ? 1.0 : history.rests != 0 ? AT_REST : AGREED);
    vec4 reach = most * sqrt(max(shows.second / count - mean * mean, vec4(0.0)));
    // The history is clamped around the mean of the block. The bounds include what the pixel itself shows, so that a
    // reflection that does not change is not blurred.
    vec4 before = clamp(sampled.color, min(mean - reach, now), max(mean + reach, now));
    float within = min(FramesWithinLag(length(sampled.lag.mean), MOST_LAG), FramesWithinLag(sampled.lag.square, MOST_SQUARE));
    age = min(age + 1.0, within);
    // After a thing came to rest, rays turn once more for the surfaces that it uncovered. Averages that are complete
    // stay as they are meanwhile.
    bool is_whole = !SEARCH && history.rests > 1 && !is_new && sampled.age > history.frames - 0.5;
    float part = is_whole ? 0.0 : 1.0 / age, left = 1.0 - part;
    vec4 mixed = DecodeMean(mix(before, now, part));
    vec4 shown = stays ? imageLoad(color_before, inside) : age > 1.0 ? mixed : unfiltered;
    AccumulatedPixel accumulated;
    accumulated.reflection = reflects ? shown : unfiltered;
    vec3 lag = sampled.lag.mean;
    vec2 across = left * (SEARCH ? lag * mat3(history.view_to_view_before) * Tangents(own_values.second.xyz) : lag.xy);
    Guide guide = Guide(own_values.first.w, own_values.first.xyz, age, own_values.second.w, across, left * sampled.lag.square);
    accumulated.guide = !reflects ? uvec4(0u) : stays ? kept : PackGuide(guide, hash);
    accumulated.color = vec4(0.0);
    if (COMPOSITE) {
        vec3 lit = imageLoad(color_buffer, inside).rgb;
        vec3 added = min(lit + material.r * accumulated.reflection.a * accumulated.reflection.rgb, vec3(GREATEST_HALF));
        accumulated.color = vec4(material.r > REFLECTS_ABOVE ? added : lit, 1.0);
    }
    return accumulated;
}

#endif
